//! Figures of a plan: postures in, SVG out.

#[cfg(test)]
mod tests;

use super::super::svg::{Anchor, Axes, BAND, BLUE, Figure, GRID, HEADING, INK, MUTED, Mark, key};
use super::super::svg::{same_scale, span};
use super::super::table::mm;
use super::to_mm;
use sesc_identify::plan::Efficiency;
use sesc_identify::plan::JointUse;
use sesc_identify::plan::Plan;
use sesc_model::text::apart;

// Where the CoP of the planned postures is, and where it may be.

const REGION_EDGES: [f64; 4] = [40.0, 32.0, 334.0, 306.0];

/// The sole plane from above: a dot per posture, in their order along a thin line.
pub fn region(plan: &Plan) -> String {
    let label = format!(
        "CoP of {} planned postures on the sole, mm, within {}",
        plan.cop.len(),
        plan.cop_region
    );
    let mut figure = Figure::new([340.0, 340.0], &label);
    let reach = |axis: usize| {
        let points = plan.corners.iter().chain(&plan.cop);
        span(points.map(|point| to_mm(point[axis])))
    };
    let [x, y] = same_scale([reach(0), reach(1)], REGION_EDGES);
    let plane = Axes {
        title: "CoP from above, mm",
        x,
        y,
        x_name: "x, forward",
        ticks: [5, 6],
        edges: REGION_EDGES,
    }
    .draw(&mut figure);
    let place = [REGION_EDGES[0] + 6.0, REGION_EDGES[1] + 8.0];
    figure.note(place, Anchor::Start, MUTED, "y, left");
    let at = |point: &[f64; 2]| plane.at(point.map(to_mm));
    figure.line(plan.cop.iter().map(at), GRID, 1.0);
    let closed = plan.corners.iter().chain(plan.corners.first());
    figure.line(closed.map(at), INK, 1.5);
    for (k, point) in plan.cop.iter().enumerate() {
        figure.posture(k, |figure| figure.mark(at(point), Mark::Dot(BLUE)));
    }
    let marks = [(Mark::Dot(BLUE), "posture"), (Mark::Box(INK), "allowed")];
    key(
        &mut figure,
        REGION_EDGES[2],
        REGION_EDGES[1] - HEADING,
        &marks,
    );
    figure.finish()
}

// The error to expect over the number of postures, planned and at random.

const CURVE_EDGES: [f64; 4] = [44.0, 32.0, 470.0, 366.0];
/// Random postures that hardly tell all directions are off by anything: what is
/// higher than so many times the last of them is not drawn.
const HIGHEST: f64 = 6.0;

/// Planned postures and as many random ones of the same candidates.
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
    let mut figure = Figure::new([480.0, 400.0], &label);
    let highest = curve.last().map_or(0.0, |last| HIGHEST * last.random);
    let of = |pick: fn(&Efficiency) -> f64| {
        let low = move |point: &&Efficiency| pick(point) <= highest;
        let place = move |point: &Efficiency| [point.postures as f64, to_mm(pick(point))];
        curve.iter().filter(low).map(place)
    };
    let (mut planned, mut random) = (of(|point| point.planned), of(|point| point.random));
    let both = || planned.clone().chain(random.clone());
    let x = span(both().map(|point| point[0]));
    let y = span(both().map(|point| point[1]).chain([0.0]));
    let plane = Axes {
        title: "Expected error of the CoP, mm",
        x: x.start.max(0.0)..x.end,
        y: y.start.max(0.0)..y.end,
        x_name: "postures",
        ticks: [6, 6],
        edges: CURVE_EDGES,
    }
    .draw(&mut figure);
    if curve.is_empty() {
        let place = [CURVE_EDGES[0] + 20.0, CURVE_EDGES[1] + 20.0];
        let why = "these postures leave directions open";
        figure.note(place, Anchor::Start, MUTED, why);
        return figure.finish();
    }
    figure.line(random.clone().map(|point| plane.at(point)), MUTED, 1.75);
    figure.line(planned.clone().map(|point| plane.at(point)), BLUE, 1.75);
    // One number above its line, one below.
    let ends = [
        ("random", random.next_back(), Mark::Ring(MUTED), -13.0),
        ("planned", planned.next_back(), Mark::Dot(BLUE), 13.0),
    ];
    for (name, point, mark, beside) in ends {
        let Some(point) = point else { continue };
        let [right, middle] = plane.at(point);
        let text = format!("{} mm", mm(1e-3 * point[1]));
        let words = format!("{} {name} postures · {text} of error expected", point[0]);
        figure.worded(&words, |figure| figure.mark([right, middle], mark));
        figure.note([right, middle + beside], Anchor::End, INK, &text);
    }
    let marks = [
        (Mark::Line(MUTED, 1.75), "random"),
        (Mark::Line(BLUE, 1.75), "planned"),
    ];
    key(
        &mut figure,
        CURVE_EDGES[2],
        CURVE_EDGES[1] - HEADING,
        &marks,
    );
    figure.finish()
}

// How much of its range every joint uses, each in units of that range.

const ROW: f64 = 20.0;
const TOP: f64 = 32.0;
const LEFT: f64 = 236.0;
const RIGHT: f64 = 910.0;
/// Letters of a joint before its row.
const NAME: usize = 23;
/// Ticks that stay apart.
const MOST: usize = 120;

/// One row per joint: a band for what is allowed, a tick per posture.
pub fn joints(rows: &[JointUse]) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = TOP + ROW * count;
    let label = format!("Ranges of {} joints: allowed and used", rows.len());
    let mut figure = Figure::new([1000.0, bottom + 10.0], &label);
    let plane = Axes {
        title: "Joint ranges",
        x: 0.0..1.0,
        y: -count..0.0,
        x_name: "",
        ticks: [0, 0],
        edges: [LEFT, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    let names: Vec<&str> = rows.iter().map(|row| row.joint.as_str()).collect();
    let names = apart(&names, NAME);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [_, middle] = at(0.0);
        figure.note([170.0, middle], Anchor::End, INK, &names[k]);
        let [low, high] = row.limits.map(|limit| number(limit, row.prismatic));
        figure.note([LEFT - 10.0, middle], Anchor::End, MUTED, &low);
        figure.note([RIGHT + 10.0, middle], Anchor::Start, MUTED, &high);
        let wide = row.limits[1] - row.limits[0];
        let share = |value: f64| match wide > 0.0 {
            true => ((value - row.limits[0]) / wide).clamp(0.0, 1.0),
            false => 0.5,
        };
        figure.line([at(0.0), at(1.0)], BAND, 5.0);
        figure.line(row.used.map(|value| at(share(value))), BLUE, 1.75);
        let step = row.values.len().div_ceil(MOST).max(1);
        let ticks = row.values.iter().step_by(step).map(|value| {
            let [x, y] = at(share(*value));
            [[x, y - 4.5], [x, y + 4.5]]
        });
        figure.lines(ticks, BLUE, 1.0);
    }
    let marks = [
        (Mark::Line(BAND, 5.0), "allowed"),
        (Mark::Stroke(BLUE), "posture"),
    ];
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}

/// A limit with its unit: degrees, or mm of a prismatic joint.
fn number(limit: f64, prismatic: bool) -> String {
    let (value, unit) = match prismatic {
        true => (1e3 * limit, " mm"),
        false => (limit.to_degrees(), "°"),
    };
    let text = format!("{:.0}{unit}", value + 0.0);
    text.replace('-', "−")
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
