//! Figures of a plan: postures in, SVG out.

#[cfg(test)]
mod tests;

use super::super::plot::{Mark, Panel, Point, segments, series, span};
use super::super::svg::{Anchor, BAND, BLUE, Figure, GRID, INK, MUTED, SMALL};
use super::super::table::{mm, position};
use super::{HALF, to_mm};
use sesc_identify::plan::Efficiency;
use sesc_identify::plan::JointUse;
use sesc_identify::plan::Plan;
use sesc_model::text::apart;

/// Where the CoP of the planned postures is, and where it may be: the sole plane from above, a dot
/// per posture, in their order along a thin line.
pub fn region(plan: &Plan) -> String {
    let places = || plan.cop.iter().map(|at| at.map(to_mm));
    let allowed = plan.corners.iter().chain(plan.corners.first());
    let points = places().enumerate().map(|(k, at)| Point::posture(k, at));
    let panel = Panel {
        title: "CoP from above, mm".to_string(),
        x_name: "x, forward; y, left".to_string(),
        ticks: [5, 6],
        height: 272.0,
        is_map: true,
        series: vec![
            series(Mark::Line(GRID, 1.0), places()),
            series(Mark::Line(INK, 1.5), allowed.map(|at| at.map(to_mm))).named("allowed"),
            series(Mark::dot(BLUE), points).named("posture"),
        ],
        ..Panel::default()
    };
    let label = format!(
        "CoP of {} planned postures on the sole, mm, within {}",
        plan.cop.len(),
        plan.cop_region
    );
    panel.alone(340.0, label)
}

/// Random postures that hardly tell all directions are off by anything: what is
/// higher than so many times the last of them is not drawn.
const HIGHEST: f64 = 6.0;

/// The error to expect over the number of postures: planned ones, and as many random ones of the
/// same candidates.
pub fn efficiency(curve: &[Efficiency]) -> String {
    let label = match curve.last() {
        Some(last) => format!(
            "Expected error over the number of postures: {} mm of {} planned, {} mm of random ones",
            mm(last.planned),
            last.postures,
            mm(last.random)
        ),
        None => "Expected error over the number of postures: not known".to_string(),
    };
    let highest = curve.last().map_or(0.0, |last| HIGHEST * last.random);
    let of = |pick: fn(&Efficiency) -> f64| -> Vec<[f64; 2]> {
        let low = curve.iter().filter(|point| pick(point) <= highest);
        low.map(|point| [point.postures as f64, to_mm(pick(point))])
            .collect()
    };
    let [random, planned] = [of(|point| point.random), of(|point| point.planned)];
    let reach = |axis: usize| {
        let all = random.iter().chain(&planned).map(|at| at[axis]);
        let range = span(all.chain((axis == 1).then_some(0.0)));
        Some(range.start.max(0.0)..range.end)
    };
    let mut all = Vec::new();
    // One number above its line, one below.
    for (name, places, color, mark, beside) in [
        ("random", &random, MUTED, Mark::Ring(MUTED), -13.0),
        ("planned", &planned, BLUE, Mark::dot(BLUE), 13.0),
    ] {
        let curve = series(Mark::Line(color, 1.75), places.iter().copied());
        all.push(curve.named(name));
        if let Some(&end @ [postures, error]) = places.last() {
            let said = format!("{} mm", mm(1e-3 * error));
            let words = format!("{postures} {name} postures · {said} of error expected");
            all.push(series(mark, [Point::worded(words, end)]));
            let beside = Mark::Words(INK, SMALL, Anchor::End, [0.0, beside]);
            all.push(series(beside, [Point::worded(said, end)]));
        }
    }
    let panel = Panel {
        title: "Expected error of the CoP, mm".to_string(),
        x: reach(0),
        y: reach(1),
        x_name: "postures".to_string(),
        ticks: [6, 6],
        height: 332.0,
        series: all,
        nothing: "these postures leave directions open",
        ..Panel::default()
    };
    panel.alone(HALF, label)
}

/// Letters of a joint before its row.
const NAME: usize = 23;
/// Ticks that stay apart.
const MOST: usize = 120;

/// How much of its range every joint uses, each in units of that range: a band for what is
/// allowed, a tick per posture.
pub fn joints(rows: &[JointUse]) -> String {
    let (mut allowed, mut used, mut ticks) = (Vec::new(), Vec::new(), Vec::new());
    let mut limits = [Vec::new(), Vec::new()];
    for (row, k) in rows.iter().zip(0..) {
        let at = |share: f64| [share, -f64::from(k) - 0.5];
        let [lower, upper] = row.limits;
        let share = |value: &f64| match upper > lower {
            true => at(((value - lower) / (upper - lower)).clamp(0.0, 1.0)),
            false => at(0.5),
        };
        let step = row.values.len().div_ceil(MOST).max(1);
        allowed.push([at(0.0), at(1.0)]);
        used.push(row.used.each_ref().map(share));
        ticks.extend(row.values.iter().step_by(step).map(share));
        for (end, limit) in row.limits.into_iter().enumerate() {
            let limit = position(limit, row.prismatic);
            limits[end].push(Point::worded(limit, at(end as f64)));
        }
    }
    let [low, high] = limits;
    let names: Vec<&str> = rows.iter().map(|row| row.joint.as_str()).collect();
    let panel = Panel {
        title: "Joint ranges".to_string(),
        x: Some(-0.1..1.1),
        rows: apart(&names, NAME),
        height: 20.0 * rows.len().max(1) as f64,
        series: vec![
            series(Mark::Words(MUTED, SMALL, Anchor::End, [-10.0, 0.0]), low),
            series(Mark::Words(MUTED, SMALL, Anchor::Start, [10.0, 0.0]), high),
            segments(BAND, 5.0, allowed).named("allowed"),
            segments(BLUE, 1.75, used),
            series(Mark::Stroke(BLUE, [9.0, 1.0]), ticks).named("posture"),
        ],
        ..Panel::default()
    };
    let label = format!("Ranges of {} joints: allowed and used", rows.len());
    panel.alone(1000.0, label)
}

// A bar for what is used of a range, with a tick per posture.

const BAR_SIZE: [f64; 2] = [200.0, 12.0];
/// Ticks that stay apart.
const BAR_MOST: usize = 100;

/// The range from limit to limit, what is `used` of it, and single `values`.
pub fn range_bar(limits: [f64; 2], used: [f64; 2], values: &[f64]) -> String {
    let [low, high] = limits;
    let at = |value: f64| match high > low {
        true => 2.0 + (BAR_SIZE[0] - 4.0) * ((value - low) / (high - low)).clamp(0.0, 1.0),
        false => BAR_SIZE[0] / 2.0,
    };
    let share = match high > low {
        true => 100.0 * (used[1] - used[0]) / (high - low),
        false => 0.0,
    };
    let mut figure = Figure::plain(BAR_SIZE, &format!("{share:.0} % of the range is used"));
    figure.fill([[2.0, 4.0], [BAR_SIZE[0] - 2.0, 8.0]], BAND, 1.0);
    let [from, to] = used.map(at);
    figure.fill([[from, 3.0], [to.max(from + 1.0), 9.0]], BLUE, 1.0);
    let step = values.len().div_ceil(BAR_MOST).max(1);
    let ticks = values.iter().step_by(step).map(|value| at(*value));
    figure.lines(ticks.map(|x| [[x, 1.5], [x, 10.5]]), INK, 0.75);
    figure
        .finish()
        .replacen("<svg ", "<svg preserveAspectRatio=\"none\" ", 1)
}
