//! Figures of a diagnosis: rows in, SVG out.
//!
//! Grey is what was measured, orange the simulation with CAD masses, blue the
//! simulation with what was missing; an outlier wears a box.

#[cfg(test)]
mod tests;

use super::super::plot::{
    Mark, Panel, Plot, Point, Series, area, outline, rule, segments, series, span, stacked,
};
use super::super::robot::Shown;
use super::super::svg::{Anchor, BLUE, GRID, INK, MUTED, ORANGE, TINY};
use super::super::table::mm;
use super::arrows::Arrows;
use super::{Bar, HALF, WIDE, pairs, shade, to_mm};
use sesc_identify::diagnose::view::{
    DiagnosisView, EDGE, Middle, Posture, Predicted, PredictedPoint, Regions, Spread, Stage,
    StageKind, Trend, chosen,
};
use sesc_model::text::apart;

/// Shade of what is many times the noise.
const DARKEST: f64 = 0.5;
const AXES: [&str; 2] = ["x", "y"];

/// Arrows to the measured CoP from CAD's simulation, and from the corrected one.
pub fn arrows(view: &DiagnosisView) -> [String; 2] {
    let arrows = of_view(view, &[]);
    [
        arrows.draw(0, "Simulated", ORANGE),
        arrows.draw(1, "Corrected", BLUE),
    ]
}

/// The same beside the robot, before the correction; cells that are meant are marked.
pub fn arrows_beside(view: &DiagnosisView, cells: &[usize]) -> String {
    of_view(view, cells).beside_the_robot("CoP on the ground")
}

fn of_view<'a>(view: &'a DiagnosisView, meant: &'a [usize]) -> Arrows<'a> {
    Arrows {
        postures: postures(view),
        rms: view.rms_lengths,
        foot: view.foot,
        sole: &view.skeleton.sole,
        cells: &view.cells,
        meant,
    }
}

/// The postures of a diagnosis as its page shows them.
pub fn postures(view: &DiagnosisView) -> Vec<Shown> {
    let shown = |row: &Posture| Shown {
        pose: row.pose,
        q: row.q.clone(),
        measured: Some(row.measured),
        predicted: Some([row.simulated, row.corrected]),
        outlier: row.outlier,
        ..Shown::default()
    };
    view.postures.iter().map(shown).collect()
}

/// The held-out error on its way from CAD, effect by effect, to the noise.
pub fn waterfall(stages: &[Stage]) -> String {
    let before = std::iter::once(0.0).chain(stages.iter().map(|stage| stage.rmse));
    let bars = stages.iter().zip(before).map(|(stage, before)| {
        let (color, pale_m) = match stage.kind {
            StageKind::Cad => (ORANGE, 0.0),
            StageKind::Better => (BLUE, before),
            StageKind::Noise => (MUTED, 0.0),
        };
        let own = Bar::new(&stage.name, stage.rmse, color);
        Bar { pale_m, ..own }
    });
    let bars: Vec<Bar<'_>> = bars.collect();
    let noise = stages.iter().find(|s| s.kind == StageKind::Noise);
    let noise = noise.map_or(f64::NAN, |stage| stage.rmse);
    super::waterfall("RMS error per axis, held out", &bars, noise)
}

/// Boxes of a size around outliers.
fn outliers(side: f64, at: impl Iterator<Item = [f64; 2]>) -> Series {
    series(Mark::Frame(INK, side), at).named("outlier")
}

// The CoP posture by posture: measured, simulated, corrected.

/// Postures that stay apart in a panel.
const COURSE_MOST: usize = 90;

/// x above, y below.
pub fn course(rows: &[Posture]) -> String {
    let few = chosen(rows.len(), COURSE_MOST);
    let which = match few.len() < rows.len() {
        true => format!("{} of {} postures, evenly chosen", few.len(), rows.len()),
        false => "posture, in the order of the log".to_string(),
    };
    let panel = |axis: usize| {
        let places = |pick: fn(&Posture) -> [f64; 2]| {
            let rows = few.iter().map(|k| &rows[*k]).zip(1..);
            rows.map(move |(row, k)| [f64::from(k), to_mm(pick(row)[axis])])
        };
        let dots = |mark, name: &str, pick| {
            let points = few.iter().zip(places(pick));
            series(mark, points.map(|(k, at)| Point::posture(*k, at))).named(name)
        };
        let measured = places(|row| row.measured);
        let both = places(|row| row.simulated).zip(measured.clone());
        let boxed = few.iter().zip(measured);
        let boxed = boxed.filter_map(|(k, at)| rows[*k].outlier.then_some(at));
        Panel {
            title: format!("CoP {}, mm", AXES[axis]),
            x: Some(0.0..(few.len() + 1) as f64),
            x_name: [String::new(), which.clone()][axis].clone(),
            ticks: [12, 6],
            height: 180.0,
            series: vec![
                // Neighbours in a log have nothing to do with each other: no lines between.
                segments(ORANGE, 1.25, both.map(|(from, to)| [from, to])),
                dots(Mark::dot(ORANGE), "simulated (CAD)", |row| row.simulated),
                dots(Mark::Ring(MUTED), "measured", |row| row.measured),
                dots(Mark::Dot(BLUE, 2.0), "corrected", |row| row.corrected),
                outliers(10.0, boxed),
            ],
            ..Panel::default()
        }
    };
    let label = format!(
        "CoP of {} postures, mm: measured, simulated, corrected",
        few.len()
    );
    stacked(WIDE, label, vec![panel(0), panel(1)])
}

/// Measured less simulated over time, or over the postures where none is logged: before and after.
pub fn rest(view: &DiagnosisView) -> String {
    let rows = &view.postures;
    let along = match view.timed {
        true => "time, s",
        false => "posture, in the order of the log",
    };
    let panel = |axis: usize| {
        let places = |pick: fn(&Posture) -> [f64; 2]| {
            let rows = rows.iter();
            rows.map(move |row| [row.at, to_mm(row.measured[axis] - pick(row)[axis])])
        };
        let dots = |color, name: &str, pick| {
            let points = places(pick).enumerate();
            let points = points.map(|(k, at)| Point::posture(k, at));
            series(Mark::Dot(color, 2.4), points).named(name)
        };
        let boxed = rows.iter().zip(places(|row| row.corrected));
        let boxed = boxed.filter_map(|(row, at)| row.outlier.then_some(at));
        Panel {
            title: format!("Gap in {}, mm", AXES[axis]),
            x_name: ["", along][axis].to_string(),
            ticks: [12, 5],
            height: 140.0,
            series: vec![
                rule(1, 0.0, INK, 1.0),
                dots(ORANGE, "before: CAD", |row| row.simulated),
                dots(BLUE, "after: corrected", |row| row.corrected),
                outliers(10.0, boxed),
            ],
            ..Panel::default()
        }
    };
    let label = format!(
        "Measured less simulated CoP of {} postures over the log, mm: before and after",
        rows.len()
    );
    stacked(WIDE, label, vec![panel(0), panel(1)])
}

/// Letters of a subject over its panel.
const SUBJECT: usize = 44;

/// The gap against what an effect predicts of it: a pair of panels an effect, x and y, with the
/// straight line on which the gap lies if the effect explains all of it, mm.
pub fn predicted(rows: &[Predicted]) -> String {
    let names: Vec<&str> = rows.iter().map(|row| row.subject.as_str()).collect();
    let subjects: Vec<&str> = names.iter().step_by(2).copied().collect();
    let names = apart(&names, SUBJECT);
    let panel = |(row, name): (&Predicted, &String)| {
        let at = |p: &PredictedPoint| [p.change, p.gap].map(to_mm);
        // Outliers would flatten the rest: they stay at the edge. The lines are in sight.
        let kept = row.points.iter().filter(|point| !point.outlier);
        let y = span(kept.flat_map(at).chain([0.0]));
        let x = span(row.points.iter().map(|p| to_mm(p.change)).chain([0.0]));
        let equal = [x.start.max(y.start), x.end.min(y.end)].map(|x| [x, x]);
        let fitted = [x.start, x.end].map(|x| [x, row.slope * x]);
        let slope = match row.slope.is_finite() {
            true => format!("; slope {:.2}", row.slope),
            false => String::new(),
        };
        let points = row.points.iter().map(|p| Point::posture(p.posture, at(p)));
        let boxed = row.points.iter().filter(|point| point.outlier);
        Panel {
            title: format!("{name} ({})", AXES[row.axis]),
            x: Some(x),
            y: Some(y),
            x_name: format!("predicted change, mm{slope}"),
            ticks: [7, 5],
            height: 150.0,
            series: vec![
                series(Mark::Line(INK, 1.0), equal).named("gap = predicted change"),
                series(Mark::Dot(ORANGE, 2.2), points).named("a posture"),
                series(Mark::Frame(INK, 8.0), boxed.map(at)),
                series(Mark::Line(BLUE, 1.75), fitted).named("line that fits best"),
            ],
            ..Panel::default()
        }
    };
    Plot {
        label: format!(
            "Gap against what the named effects predict of it, mm: {}",
            subjects.join("; ")
        ),
        width: WIDE,
        title: "Gap in mm against the change that the named effect predicts".to_string(),
        columns: 2,
        panels: rows.iter().zip(&names).map(panel).collect(),
    }
    .draw()
}

/// Letters of a joint over its panel.
const JOINT: usize = 22;

/// Residuals against `what` of the joints, mm: joints that the explanation names first and marked,
/// then the strongest.
pub fn trends(rows: &[Trend], what: &str) -> String {
    let names: Vec<&str> = rows.iter().map(|row| row.joint.as_str()).collect();
    // What is named is marked at the other end of the line.
    let names = [JOINT, JOINT - 9].map(|most| apart(&names, most));
    let panel = |(k, row): (usize, &Trend)| {
        // Outliers would flatten the rest: they stay at the edge.
        let kept = row.points.iter().filter(|point| !point.outlier);
        let kept = kept.flat_map(|point| [point.before, point.after]);
        let [before, after] = row.share.map(|share| 100.0 * share.max(0.0));
        let all = || row.points.iter();
        let old = all().map(|p| Point::posture(p.posture, [p.at, to_mm(p.before)]));
        let new = all().map(|p| Point::posture(p.posture, [p.at, to_mm(p.after)]));
        let boxed = all().filter(|point| point.outlier);
        let boxed = boxed.map(|p| [p.at, to_mm(p.after)]);
        let means = |color, pick: fn(&Middle) -> f64| {
            let means = row.means.iter().map(|mean| [mean.at, to_mm(pick(mean))]);
            series(Mark::Line(color, 1.75), means)
        };
        let named = row.named.then_some((Mark::Square(ORANGE, 9.0), "named"));
        let (name, axis) = (&names[usize::from(row.named)][k], AXES[row.axis]);
        Panel {
            title: format!("{name} ({axis})"),
            y: Some(span(kept.map(to_mm).chain([0.0]))),
            x_name: format!("{}: {before:.0} % before, {after:.0} % after", row.unit),
            ticks: [5, 4],
            height: 96.0,
            // Letters in orange are too pale to read.
            key: named.into_iter().collect(),
            series: vec![
                rule(1, 0.0, INK, 1.0),
                series(Mark::Dot(ORANGE, 1.4), old).named("before"),
                series(Mark::Dot(BLUE, 1.4), new).named("after"),
                series(Mark::Frame(INK, 7.0), boxed),
                means(ORANGE, |mean| mean.before),
                means(BLUE, |mean| mean.after),
            ],
            ..Panel::default()
        }
    };
    let nothing = rows.is_empty().then(|| Panel {
        nothing: "no joints",
        ..Panel::default()
    });
    let panels = rows.iter().enumerate().map(panel).chain(nothing).collect();
    Plot {
        label: format!(
            "Gap against {what} of {} joints, mm: before and after",
            rows.len()
        ),
        width: HALF,
        title: format!("Gap in mm against the {what}"),
        columns: 2,
        panels,
    }
    .draw()
}

/// Points of the curve.
const CURVE_POINTS: usize = 121;

/// Residuals in units of noise: counted in bars after, a stepped line before, against the curve of
/// pure noise.
pub fn spread(rows: &Spread) -> String {
    let width = 2.0 * EDGE / rows.after.len().max(1) as f64;
    let normal = |x: f64| {
        rows.count as f64 * width * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
    };
    let most = rows.before.iter().chain(&rows.after).max();
    let most = most.map_or(0.0, |&count| count as f64);
    let left = |k: usize| -EDGE + width * k as f64;
    let bars = rows.after.iter().enumerate().filter(|(_, n)| **n > 0);
    let bars = bars.map(|(k, &count)| {
        let gap = 0.04 * width;
        Point::between([[left(k) + gap, 0.0], [left(k + 1) - gap, count as f64]])
    });
    let steps = rows.before.iter().enumerate();
    let steps = steps.flat_map(|(k, &n)| [[left(k), n as f64], [left(k + 1), n as f64]]);
    let curve =
        (0..CURVE_POINTS).map(|k| -EDGE + 2.0 * EDGE * k as f64 / (CURVE_POINTS - 1) as f64);
    let ([before, after], rms) = (rows.beyond, rows.rms.map(|rms| mm(1e-3 * rms)));
    let said = format!(
        "Beyond ±{EDGE:.0}: {before} before, {after} after. RMS: {} before, {} after.",
        rms[0], rms[1]
    );
    let panel = Panel {
        title: "Residuals per bin".to_string(),
        x: Some(-EDGE..EDGE),
        y: Some(0.0..1.08 * most.max(normal(0.0)).max(1.0)),
        x_name: "(measured − simulated) ÷ noise".to_string(),
        ticks: [7, 5],
        height: 214.0,
        series: vec![
            series(Mark::Box(BLUE, 1.0), bars).named("after"),
            series(Mark::Line(ORANGE, 1.75), steps).named("before"),
            series(Mark::Line(INK, 1.75), curve.map(|x| [x, normal(x)])).named("noise alone"),
        ],
        foot: said,
        ..Panel::default()
    };
    let count = rows.count;
    let label = format!("{count} residuals in units of noise: before and after");
    panel.alone(HALF, label)
}

/// Where on the sole the gap is, before or after: RMS in units of noise, square by square.
pub fn regions(rows: &Regions, after: bool) -> String {
    let (when, title, color) = match after {
        true => ("after", "Corrected", BLUE),
        false => ("before", "Simulated", ORANGE),
    };
    let mut squares = Vec::new();
    let mut numbers = Vec::new();
    for square in &rows.squares {
        let rms = square.rms[usize::from(after)];
        let corners = [0.0, rows.side].map(|by| square.corner.map(|at| to_mm(at + by)));
        // Noise alone is left white.
        let part = DARKEST * (1.0 - 1.0 / rms.max(1.0));
        if rms.is_finite() {
            squares.push(area(color, shade(part), corners));
            squares.push(outline(GRID, corners));
            let middle = square.corner.map(|at| to_mm(at + rows.side / 2.0));
            numbers.push(Point::worded(number(rms), middle));
        }
    }
    let numbers = series(Mark::Words(INK, TINY, Anchor::Middle, [0.0; 2]), numbers);
    let panel = Panel {
        title: format!("{title}: RMS ÷ noise, per square"),
        x_name: "x, mm (y upwards)".to_string(),
        ticks: [7, 7],
        height: 380.0,
        is_map: true,
        series: squares.into_iter().chain([numbers]).collect(),
        nothing: "no readings",
        ..Panel::default()
    };
    let label = format!(
        "RMS gap {when}, in units of noise, in {} squares of the sole",
        rows.squares.len()
    );
    panel.alone(HALF, label)
}

/// Two digits where they fit into a square.
fn number(value: f64) -> String {
    match value {
        v if v < 9.95 => format!("{v:.1}"),
        v if v < 999.5 => format!("{v:.0}"),
        _ => "> 999".to_string(),
    }
}

/// Squares that have room for a number.
const NUMBERED: usize = 14;

/// How far apart the explanations of a class are, what each pair would read differently over this
/// log: RMS differences in units of noise; what no such log tells apart is left white.
pub fn confusion(differences: &[Vec<f64>]) -> String {
    let n = differences.len();
    let square = |row: usize, column: usize| {
        let value = *differences[row].get(column)?;
        let number = match value < 0.995 {
            _ if n > NUMBERED => String::new(),
            true => format!("{value:.2}"),
            false => number(value),
        };
        // Half the noise and more is seen in some hundred postures.
        let opacity = shade(DARKEST * value / (value + 0.5));
        (value.is_finite() && row != column).then_some((BLUE, opacity, number))
    };
    let title = "How far apart they are: RMS difference ÷ noise";
    let mut panel = pairs(title, n, square);
    let edges = (0..=n).map(|k| k as f64);
    let edges = edges.flat_map(|k| [rule(0, k, GRID, 1.0), rule(1, -k, GRID, 1.0)]);
    panel.series.extend(edges);
    let label = format!("RMS difference between {n} explanations, in units of noise");
    panel.alone(HALF, label)
}
