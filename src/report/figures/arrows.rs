//! The gap on the sole, seen from above: arrows from where the CoP was predicted to
//! where it was measured.

use super::super::plot::{Mark, Panel, Point, outline, series, span};
use super::super::svg::{Anchor, BAND, Color, INK, MUTED, ORANGE, SMALL};
use super::super::table::mm;
use super::{HALF, to_mm};

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
        self.figure(which, title, color, false)
    }

    /// The arrows before the correction, for a script to shorten: what it needs for that
    /// stands in attributes of their group.
    pub fn beside_the_robot(&self, title: &str) -> String {
        self.figure(0, title, ORANGE, true)
    }

    fn figure(&self, which: usize, title: &str, color: Color, beside: bool) -> String {
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
            Some(span(ends.chain(foot.map(move |at| to_mm(at[axis])))))
        };
        let numbered = self.gaps.iter().enumerate();
        let tip = |k: usize, gap: &Gap| Point::posture(k, gap.measured.map(to_mm));
        let outliers = self.gaps.iter().filter(|gap| gap.outlier);
        let outliers = outliers.map(|gap| Point::from(gap.measured.map(to_mm)));
        // Of two axes.
        let rms = mm(self.rms[which] / 2.0_f64.sqrt());
        let said = match gain > 1.0 {
            _ if beside => format!("gap × {gain}"),
            true => format!("{rms} mm RMS per axis, drawn × {gain}"),
            false => format!("{rms} mm RMS per axis"),
        };
        let drawn = numbered.map(|(k, gap)| tip(k, gap).coming_from(tail(gap, which)));
        let sole = self.sole.iter().chain(self.sole.first());
        let cells = [(false, BAND), (true, ORANGE)].map(|(wanted, color)| {
            let own = self.cells.iter().filter(|(_, meant)| *meant == wanted);
            let own = own.map(|(at, _)| Point::from(at.map(to_mm)));
            series(Mark::Square(color, 12.0), own)
        });
        let foot = self.foot.iter().flat_map(|corners| {
            let [low, high] = corners.map(|corner| corner.map(to_mm));
            let name = Point::worded("cells of the foot", [low[0], high[1]]);
            let beside = Mark::Words(MUTED, SMALL, Anchor::Start, [0.0, -9.0]);
            [outline(BAND, [low, high]), series(beside, [name])]
        });
        let all = foot
            .chain([series(Mark::Line(MUTED, 1.5), sole.map(|at| at.map(to_mm)))])
            .chain(cells)
            .chain([
                series(Mark::Arrow(color, beside.then_some(gain)), drawn).named(said),
                series(Mark::Frame(INK, 10.0), outliers),
            ]);
        let panel = Panel {
            title: title.to_string(),
            x: reach(0),
            y: reach(1),
            x_name: "x, mm (y upwards)".to_string(),
            ticks: if beside { [5, 7] } else { [7, 7] },
            height: if beside { 272.0 } else { 380.0 },
            is_map: true,
            series: all.collect(),
            nothing: "no readings at hand",
            ..Panel::default()
        };
        let label = format!(
            "{title}: arrows from the predicted to the measured CoP of {} readings, mm",
            self.gaps.len()
        );
        panel.alone(if beside { 340.0 } else { HALF }, label)
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
