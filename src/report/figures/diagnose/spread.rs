//! Residuals in units of noise: counted, against the normal curve.

use super::super::super::svg::{
    self, BLUE, Frame, HEADING, INK, MUTED, Mark, ORANGE, Side, fill, key, note, px,
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
    svg::figure([480, 320], &label, |area| {
        let counts = rows.before.iter().chain(&rows.after);
        let most = counts.copied().max().unwrap_or(0) as f64;
        let plane = Frame {
            title: "Residuals",
            x: -EDGE..EDGE,
            y: 0.0..1.08 * most.max(normal(0.0)).max(1.0),
            x_name: "(measured − simulated) ÷ noise",
            ticks: [7, 5],
            edges: EDGES,
        }
        .draw(area)?;
        let left = |k: usize| -EDGE + width * k as f64;
        for (k, &count) in rows.after.iter().enumerate().filter(|(_, n)| **n > 0) {
            let (low, high) = (
                plane.place(left(k), 0.0),
                plane.place(left(k + 1), count as f64),
            );
            fill(
                area,
                [(low.0 + px(0.5), low.1), (high.0 - px(0.5), high.1)],
                BLUE,
            )?;
        }
        let steps = rows.before.iter().enumerate();
        plane.line(
            steps.flat_map(|(k, &n)| [(left(k), n as f64), (left(k + 1), n as f64)]),
            ORANGE,
            1.75,
        )?;
        let curve = (0..POINTS).map(|k| -EDGE + 2.0 * EDGE * k as f64 / (POINTS - 1) as f64);
        plane.line(curve.map(|x| (x, normal(x))), INK, 1.75)?;
        let marks = [
            (Mark::Line(ORANGE, 1.75), "before"),
            (Mark::Square(BLUE), "after"),
            (Mark::Line(INK, 1.75), "noise alone"),
        ];
        key(area, EDGES[2], EDGES[1] - HEADING, &marks)?;
        let said = format!(
            "Beyond ±{EDGE:.0}: {} before, {} after. RMS: {} before, {} after.",
            rows.beyond[0],
            rows.beyond[1],
            mm(1e-3 * rows.rms[0]),
            mm(1e-3 * rows.rms[1])
        );
        note(area, &said, (px(EDGES[0]), px(302.0)), Side::Left, MUTED)
    })
}
