//! Where on the sole the gap is: RMS in units of noise, square by square.

use plotters::prelude::*;

use super::super::super::svg::{
    self, BLUE, Frame, HEADING, INK, MUTED, ORANGE, Side, note, px, span, write,
};
use super::super::cop::same_scale;
use super::super::to_mm;
use super::outline;
use sesc_identify::diagnose::view::Regions;

const EDGES: [f64; 4] = [48.0, 32.0, 472.0, 412.0];
/// Shade of what is many times the noise.
const DARKEST: f64 = 0.7;

/// The map before or after.
pub fn regions(rows: &Regions, after: bool) -> String {
    let when = if after { "after" } else { "before" };
    let label = format!(
        "RMS gap {when}, in units of noise, in {} squares of the sole",
        rows.squares.len()
    );
    svg::figure([480, 448], &label, |area| {
        let reach = |axis: usize| {
            let corners = rows.squares.iter().map(move |s| s.corner[axis]);
            let ends = corners.flat_map(|low| [low, low + rows.side]);
            span(ends.map(to_mm))
        };
        let [x, y] = same_scale([reach(0), reach(1)], EDGES);
        let plane = Frame {
            title: if after { "Corrected" } else { "Simulated" },
            x,
            y,
            x_name: "x, mm (y upwards)",
            ticks: [7, 7],
            edges: EDGES,
        }
        .draw(area)?;
        let place = (px(EDGES[2]), px(EDGES[1] - HEADING));
        note(area, "RMS ÷ noise, per square", place, Side::Right, MUTED)?;
        for square in &rows.squares {
            let rms = square.rms[usize::from(after)];
            if !rms.is_finite() {
                continue;
            }
            let [low, high] = [0.0, rows.side].map(|by| {
                let [x, y] = square.corner.map(|at| to_mm(at + by));
                plane.place(x, y)
            });
            // Noise alone is left white; steps, so that equal shades are equal bytes.
            let shade = DARKEST * (1.0 - 1.0 / rms.max(1.0));
            let shade = (shade * 20.0).round() / 20.0;
            let color = if after { BLUE } else { ORANGE };
            area.draw(&Rectangle::new([low, high], color.mix(shade).filled()))?;
            outline(area, [low, high], svg::GRID)?;
            let middle = ((low.0 + high.0) / 2, (low.1 + high.1) / 2);
            write(area, &number(rms), middle, Side::Middle, 11.0, INK, false)?;
        }
        if rows.squares.is_empty() {
            let place = (px(68.0), px(52.0));
            note(area, "no readings", place, Side::Left, MUTED)?;
        }
        Ok(())
    })
}

/// Two digits where they fit into a square.
pub(super) fn number(value: f64) -> String {
    match value {
        v if v < 9.95 => format!("{v:.1}"),
        v if v < 999.5 => format!("{v:.0}"),
        _ => "> 999".to_string(),
    }
}
