//! Residuals in units of noise: counted, against the normal curve.

use super::super::super::svg::{
    Anchor, Axes, BLUE, Figure, HEADING, INK, MUTED, Mark, ORANGE, key,
};
use super::super::super::table::mm;
use sesc_identify::diagnose::view::{EDGE, Spread};

const EDGES: [f64; 4] = [48.0, 32.0, 472.0, 246.0];
/// Points of the curve.
const POINTS: usize = 121;

/// Bars after, a stepped line before, the curve of pure noise.
pub fn spread(rows: &Spread) -> String {
    let label = format!(
        "{} residuals in units of noise: before and after",
        rows.count
    );
    let width = 2.0 * EDGE / rows.after.len().max(1) as f64;
    let normal = |x: f64| {
        rows.count as f64 * width * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
    };
    let mut figure = Figure::new([480.0, 320.0], &label);
    let most = rows.before.iter().chain(&rows.after).max();
    let most = most.map_or(0.0, |&count| count as f64);
    let plane = Axes {
        title: "Residuals per bin",
        x: -EDGE..EDGE,
        y: 0.0..1.08 * most.max(normal(0.0)).max(1.0),
        x_name: "(measured − simulated) ÷ noise",
        ticks: [7, 5],
        edges: EDGES,
    }
    .draw(&mut figure);
    let left = |k: usize| -EDGE + width * k as f64;
    for (k, &count) in rows.after.iter().enumerate().filter(|(_, n)| **n > 0) {
        let [low, high] = [[left(k), 0.0], [left(k + 1), count as f64]].map(|at| plane.at(at));
        figure.fill(
            [[low[0] + 0.5, low[1]], [high[0] - 0.5, high[1]]],
            BLUE,
            1.0,
        );
    }
    let steps = rows.before.iter().enumerate();
    let steps = steps.flat_map(|(k, &n)| [[left(k), n as f64], [left(k + 1), n as f64]]);
    figure.line(steps.map(|at| plane.at(at)), ORANGE, 1.75);
    let curve = (0..POINTS).map(|k| -EDGE + 2.0 * EDGE * k as f64 / (POINTS - 1) as f64);
    figure.line(curve.map(|x| plane.at([x, normal(x)])), INK, 1.75);
    let marks = [
        (Mark::Line(ORANGE, 1.75), "before"),
        (Mark::Square(BLUE), "after"),
        (Mark::Line(INK, 1.75), "noise alone"),
    ];
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
    let said = format!(
        "Beyond ±{EDGE:.0}: {} before, {} after. RMS: {} before, {} after.",
        rows.beyond[0],
        rows.beyond[1],
        mm(1e-3 * rows.rms[0]),
        mm(1e-3 * rows.rms[1])
    );
    figure.note([EDGES[0], 302.0], Anchor::Start, MUTED, &said);
    figure.finish()
}
