//! Where on the sole the gap is: RMS in units of noise, square by square.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, GRID, HEADING, INK, MUTED, ORANGE};
use super::super::super::svg::{TINY, same_scale, span};
use super::super::{shade, to_mm};
use sesc_identify::diagnose::view::Regions;

const EDGES: [f64; 4] = [48.0, 32.0, 472.0, 412.0];
/// Shade of what is many times the noise.
const DARKEST: f64 = 0.5;

/// The map before or after.
pub fn regions(rows: &Regions, after: bool) -> String {
    let when = if after { "after" } else { "before" };
    let label = format!(
        "RMS gap {when}, in units of noise, in {} squares of the sole",
        rows.squares.len()
    );
    let mut figure = Figure::new([480.0, 448.0], &label);
    let reach = |axis: usize| {
        let corners = rows.squares.iter().map(move |s| s.corner[axis]);
        let ends = corners.flat_map(|low| [low, low + rows.side]);
        span(ends.map(to_mm))
    };
    let [x, y] = same_scale([reach(0), reach(1)], EDGES);
    let plane = Axes {
        title: if after { "Corrected" } else { "Simulated" },
        x,
        y,
        x_name: "x, mm (y upwards)",
        ticks: [7, 7],
        edges: EDGES,
    }
    .draw(&mut figure);
    let place = [EDGES[2], EDGES[1] - HEADING];
    figure.note(place, Anchor::End, MUTED, "RMS ÷ noise, per square");
    for square in &rows.squares {
        let rms = square.rms[usize::from(after)];
        if !rms.is_finite() {
            continue;
        }
        let corners = [0.0, rows.side].map(|by| plane.at(square.corner.map(|at| to_mm(at + by))));
        // Noise alone is left white.
        let part = DARKEST * (1.0 - 1.0 / rms.max(1.0));
        let color = if after { BLUE } else { ORANGE };
        figure.fill(corners, color, shade(part));
        figure.outline(corners, GRID);
        let [low, high] = corners;
        let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
        figure.text(middle, Anchor::Middle, TINY, INK, &number(rms));
    }
    if rows.squares.is_empty() {
        figure.note([68.0, 52.0], Anchor::Start, MUTED, "no readings");
    }
    figure.finish()
}

/// Two digits where they fit into a square.
pub(super) fn number(value: f64) -> String {
    match value {
        v if v < 9.95 => format!("{v:.1}"),
        v if v < 999.5 => format!("{v:.0}"),
        _ => "> 999".to_string(),
    }
}
