//! The gap on the sole, seen from above: arrows from where the CoP was predicted to
//! where it was measured.

use super::super::svg::{Anchor, Axes, BAND, Color, Figure, HEADING, INK, MUTED, Mark, Place};
use super::super::svg::{ORANGE, key, same_scale, span};
use super::super::table::mm;
use super::to_mm;

/// Size of a figure in a pair, and of the one beside the robot, pixels.
const PAIR: [f64; 2] = [480.0, 448.0];
const BESIDE: [f64; 2] = [340.0, 340.0];

/// One reading and what was predicted there, m.
pub struct Gap {
    pub measured: [f64; 2],
    /// Before and after the correction.
    pub predicted: [[f64; 2]; 2],
    pub outlier: bool,
}

/// The arrows of both figures, before and after the correction.
pub struct Arrows {
    pub gaps: Vec<Gap>,
    /// RMS length before and after, m.
    pub rms: [f64; 2],
    /// Opposite corners of the foot, m, where they are known.
    pub foot: Option<[[f64; 2]; 2]>,
    /// Outline of the sole, m; empty where it is not known.
    pub sole: Vec<[f64; 2]>,
    /// Cells of the foot, m, and whether one is meant.
    pub cells: Vec<([f64; 2], bool)>,
}

impl Arrows {
    /// Draw the arrows before (0) or after (1) the correction; both figures have the
    /// same scale.
    pub fn draw(&self, which: usize, title: &str, color: Color) -> String {
        self.figure(which, title, color, PAIR)
    }

    /// The arrows before the correction, for a script to shorten: what it needs for that
    /// stands in attributes of their group.
    pub fn beside_the_robot(&self, title: &str) -> String {
        self.figure(0, title, ORANGE, BESIDE)
    }

    fn figure(&self, which: usize, title: &str, color: Color, size: [f64; 2]) -> String {
        let beside = size == BESIDE;
        let edges = [
            if beside { 34.0 } else { 48.0 },
            32.0,
            size[0] - 8.0,
            size[1] - 36.0,
        ];
        let label = format!(
            "{title}: arrows from the predicted to the measured CoP of {} readings, mm",
            self.gaps.len()
        );
        let mut figure = Figure::new(size, &label);
        let gain = self.gain();
        let tail = |gap: &Gap, which: usize| {
            let [from, to] = [gap.predicted[which], gap.measured];
            [0, 1].map(|axis| to_mm(to[axis] + gain * (from[axis] - to[axis])))
        };
        let reach = |axis: usize| {
            let ends = self.gaps.iter().flat_map(move |gap| {
                let tails = [0, 1].map(|which| tail(gap, which)[axis]);
                [to_mm(gap.measured[axis]), tails[0], tails[1]]
            });
            let foot = self.foot.iter().flatten().chain(&self.sole);
            span(ends.chain(foot.map(move |at| to_mm(at[axis]))))
        };
        let [x, y] = same_scale([reach(0), reach(1)], edges);
        let plane = Axes {
            title,
            x,
            y,
            x_name: "x, mm (y upwards)",
            ticks: if beside { [5, 7] } else { [7, 7] },
            edges,
        }
        .draw(&mut figure);
        if let Some(corners) = self.foot {
            let [low, high] = corners.map(|corner| plane.at(corner.map(to_mm)));
            figure.outline([low, high], BAND);
            let place = [low[0], high[1] - 9.0];
            figure.note(place, Anchor::Start, MUTED, "cells of the foot");
        }
        let sole: Vec<Place> = (self.sole.iter().chain(self.sole.first()))
            .map(|corner| plane.at(corner.map(to_mm)))
            .collect();
        figure.line(sole, MUTED, 1.5);
        for (place, meant) in &self.cells {
            let [x, y] = plane.at(place.map(to_mm));
            let color = if *meant { ORANGE } else { BAND };
            figure.fill([[x - 6.0, y - 6.0], [x + 6.0, y + 6.0]], color, 1.0);
        }
        let attributes = match beside {
            true => format!("data-gain=\"{gain}\" {}", plane.attributes()),
            false => "data-still=\"\"".to_string(),
        };
        figure.group(&attributes, |figure| {
            for (k, gap) in self.gaps.iter().enumerate() {
                let [tail, tip] =
                    [tail(gap, which), gap.measured.map(to_mm)].map(|at| plane.at(at));
                if tail.iter().chain(&tip).all(|x| x.is_finite()) {
                    figure.posture(k, |figure| {
                        figure.arrow(tail, tip, color);
                        figure.dot(tip, 1.3, INK);
                        if gap.outlier {
                            figure.boxed(tip, 5.0);
                        }
                    });
                }
            }
        });
        if self.gaps.is_empty() {
            let place = [edges[0] + 20.0, edges[1] + 20.0];
            figure.note(place, Anchor::Start, MUTED, "no readings at hand");
        }
        // Of two axes.
        let rms = mm(self.rms[which] / 2.0_f64.sqrt());
        let text = match gain > 1.0 {
            _ if beside => format!("gap × {gain}"),
            true => format!("{rms} mm RMS per axis, drawn × {gain}"),
            false => format!("{rms} mm RMS per axis"),
        };
        let marks = [(Mark::Line(color, 1.5), text.as_str())];
        key(&mut figure, edges[2], edges[1] - HEADING, &marks);
        figure.finish()
    }

    /// How much longer arrows are drawn than gaps are: alike before and after.
    fn gain(&self) -> f64 {
        let longest = self.rms[0].max(self.rms[1]);
        let side = |axis: usize| {
            let values = self.gaps.iter().map(|gap| gap.measured[axis]);
            let ends = values.filter(|x| x.is_finite());
            let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            });
            high - low
        };
        let widest = side(0).max(side(1));
        let steps = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0];
        let fits = |gain: &f64| longest > 0.0 && gain * longest < 0.08 * widest;
        steps.into_iter().find(fits).unwrap_or(1.0)
    }
}
