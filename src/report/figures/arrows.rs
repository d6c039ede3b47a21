//! The gap on the sole, seen from above: arrows from where the CoP was predicted to
//! where it was measured.

use super::super::plot::{Mark, Panel, Point, outline, series, span};
use super::super::robot::Shown;
use super::super::svg::{Anchor, BAND, Color, INK, MUTED, ORANGE, SMALL};
use super::super::table::mm;
use super::{HALF, to_mm};

/// The arrows of both figures, before and after the correction.
#[derive(Default)]
pub(super) struct Arrows<'a> {
    /// Postures with what was read and predicted.
    pub postures: Vec<Shown>,
    /// RMS length before and after, m.
    pub rms: [f64; 2],
    /// Opposite corners of the foot, m, where they are known.
    pub foot: Option<[[f64; 2]; 2]>,
    /// Outline of the sole, m; empty where it is not known.
    pub sole: &'a [[f64; 2]],
    /// Cells of the foot, m.
    pub cells: &'a [[f64; 2]],
    /// Those that are meant.
    pub meant: &'a [usize],
}

impl Arrows<'_> {
    /// Draw the arrows before (0) or after (1) the correction; both figures have the
    /// same scale.
    pub(super) fn draw(&self, which: usize, title: &str, color: Color) -> String {
        self.figure(which, title, color, false)
    }

    /// The arrows before the correction, for a script to shorten: what it needs for that
    /// stands in attributes of their group.
    pub(super) fn beside_the_robot(&self, title: &str) -> String {
        self.figure(0, title, ORANGE, true)
    }

    /// Where arrows end, and where those begin that are drawn `gain` times as long, before and
    /// after the correction, mm.
    fn ends(&self, gain: f64) -> impl Iterator<Item = ([f64; 2], [[f64; 2]; 2])> {
        let known = self
            .postures
            .iter()
            .filter_map(|own| Some((own.measured?, own.predicted?)));
        known.map(move |(to, predicted)| {
            let tail = |from: [f64; 2]| {
                [0, 1].map(|axis| to_mm(to[axis] + gain * (from[axis] - to[axis])))
            };
            (to.map(to_mm), predicted.map(tail))
        })
    }

    fn figure(&self, which: usize, title: &str, color: Color, beside: bool) -> String {
        let gain = self.gain();
        let reach = |axis: usize| {
            let ends = self
                .ends(gain)
                .flat_map(|(tip, [before, after])| [tip, before, after]);
            let foot = self.foot.iter().flatten().chain(self.sole);
            let all = ends.chain(foot.map(|at| at.map(to_mm)));
            Some(span(all.map(|at| at[axis])))
        };
        let outliers = self.postures.iter().zip(self.ends(gain));
        let outliers = outliers
            .filter(|(own, _)| own.outlier)
            .map(|(_, (tip, _))| tip);
        // Of two axes.
        let rms = mm(self.rms[which] / 2.0_f64.sqrt());
        let said = match gain > 1.0 {
            _ if beside => format!("gap × {gain}"),
            true => format!("{rms} mm RMS per axis, drawn × {gain}"),
            false => format!("{rms} mm RMS per axis"),
        };
        let drawn = self.ends(gain).enumerate();
        let drawn = drawn.map(|(k, (tip, tails))| Point::posture(k, tip).coming_from(tails[which]));
        let sole = self.sole.iter().chain(self.sole.first());
        let cells = [(false, BAND), (true, ORANGE)].map(|(is_meant, color)| {
            let own = self.cells.iter().enumerate();
            let own = own.filter(|(k, _)| self.meant.contains(k) == is_meant);
            series(Mark::Square(color, 12.0), own.map(|(_, at)| at.map(to_mm)))
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
            self.postures.len()
        );
        panel.alone(if beside { 340.0 } else { HALF }, label)
    }

    /// How much longer arrows are drawn than gaps are: alike before and after.
    fn gain(&self) -> f64 {
        let longest = self.rms[0].max(self.rms[1]);
        let side = |axis: usize| {
            let values = self
                .postures
                .iter()
                .filter_map(|own| Some(own.measured?[axis]));
            let values = values.filter(|x| x.is_finite());
            let low = values.clone().fold(f64::INFINITY, f64::min);
            values.fold(f64::NEG_INFINITY, f64::max) - low
        };
        let widest = side(0).max(side(1));
        let steps = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0];
        let fits = |gain: &f64| longest > 0.0 && gain * longest < 0.08 * widest;
        steps.into_iter().find(fits).unwrap_or(1.0)
    }
}
