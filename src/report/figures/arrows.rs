//! The gap on the sole, seen from above: arrows from where the CoP was predicted to
//! where it was measured.

use super::super::svg::{Anchor, Axes, BAND, Color, Figure, HEADING, INK, MUTED, Mark, Place};
use super::super::svg::{key, same_scale, span};
use super::super::table::mm;
use super::to_mm;

const EDGES: [f64; 4] = [48.0, 32.0, 472.0, 412.0];
/// Length of an arrow's head, and half its width, pixels.
const HEAD: [f64; 2] = [5.5, 2.2];

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
}

impl Arrows {
    /// Draw the arrows before (0) or after (1) the correction; both figures have the
    /// same scale.
    pub fn draw(&self, which: usize, title: &str, color: Color) -> String {
        let label = format!(
            "{title}: arrows from the predicted to the measured CoP of {} readings, mm",
            self.gaps.len()
        );
        let mut figure = Figure::new([480.0, 448.0], &label);
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
            let foot = self.foot.iter().flatten().map(move |at| to_mm(at[axis]));
            span(ends.chain(foot))
        };
        let [x, y] = same_scale([reach(0), reach(1)], EDGES);
        let plane = Axes {
            title,
            x,
            y,
            x_name: "x, mm (y upwards)",
            ticks: [7, 7],
            edges: EDGES,
        }
        .draw(&mut figure);
        if let Some(corners) = self.foot {
            let [low, high] = corners.map(|corner| plane.at(corner.map(to_mm)));
            figure.outline([low, high], BAND);
            let place = [low[0], high[1] - 9.0];
            figure.note(place, Anchor::Start, MUTED, "cells of the foot");
        }
        for gap in &self.gaps {
            let [tail, tip] = [tail(gap, which), gap.measured.map(to_mm)].map(|at| plane.at(at));
            if tail.iter().chain(&tip).all(|x| x.is_finite()) {
                arrow(&mut figure, tail, tip, color);
                figure.dot(tip, 1.3, INK);
                if gap.outlier {
                    figure.boxed(tip, 5.0);
                }
            }
        }
        if self.gaps.is_empty() {
            let place = [EDGES[0] + 20.0, EDGES[1] + 20.0];
            figure.note(place, Anchor::Start, MUTED, "no readings at hand");
        }
        let length = mm(self.rms[which]);
        let text = match gain > 1.0 {
            true => format!("{length} mm RMS of the length, drawn × {gain}"),
            false => format!("{length} mm RMS of the length"),
        };
        let marks = [(Mark::Line(color, 1.5), text.as_str())];
        key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
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

/// A line, with a head where it is long enough for one.
fn arrow(figure: &mut Figure, tail: Place, tip: Place, color: Color) {
    figure.line([tail, tip], color, 1.25);
    let [x, y] = [tip[0] - tail[0], tip[1] - tail[1]];
    let length = x.hypot(y);
    if length < 1.6 * HEAD[0] {
        return;
    }
    let [x, y] = [x / length, y / length];
    let [back, side] = HEAD;
    let corner = |way: f64| {
        [
            tip[0] - back * x - way * side * y,
            tip[1] - back * y + way * side * x,
        ]
    };
    figure.polygon(&[tip, corner(1.0), corner(-1.0)], color);
}
