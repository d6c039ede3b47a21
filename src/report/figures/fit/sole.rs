//! Residuals where they were measured: CAD's and the fit's, at one scale.

use super::super::super::svg::{
    self, Area, BLUE, Drawn, Frame, HEADING, MUTED, Mark, Side, key, note, px, span,
};
use super::super::to_mm;
use crate::identify::residuals::Residual;

/// Residuals that stay readable.
const MOST: usize = 400;
const TOP: f64 = 32.0;
const SIDE: f64 = 420.0;

/// One stroke per reading, from what was measured towards what was predicted.
pub fn sole(rows: &[Residual], fitted: bool) -> String {
    let step = rows.len().div_ceil(MOST).max(1);
    let few: Vec<&Residual> = rows.iter().step_by(step).collect();
    let whose = if fitted { "the fit" } else { "CAD" };
    let label = format!("Residuals of {whose} at {} readings on the sole", few.len());
    svg::figure([480, (TOP + SIDE + 42.0) as u32], &label, |area| {
        draw(area, &few, fitted)
    })
}

fn draw(area: &Area<'_>, rows: &[&Residual], fitted: bool) -> Drawn {
    let predicted = |row: &Residual| if fitted { row.fitted } else { row.cad };
    let residual = |row: &Residual| {
        let to = predicted(row);
        (to[0] - row.measured[0]).hypot(to[1] - row.measured[1])
    };
    let mut ends: Vec<[f64; 2]> = Vec::new();
    for row in rows {
        ends.extend([row.measured, row.cad, row.fitted]);
    }
    let [x, y] = [0, 1].map(|axis| span(ends.iter().map(|end| to_mm(end[axis]))));
    // One scale for both axes: a sole is not stretched.
    let half = ((x.end - x.start).max(y.end - y.start) / 2.0).max(1e-6);
    let [x, y] = [x, y].map(|range| {
        let middle = (range.start + range.end) / 2.0;
        middle - half..middle + half
    });
    let plane = Frame {
        title: if fitted { "The fit" } else { "CAD" },
        x,
        y,
        x_name: "x, mm (y upwards)",
        ticks: [7, 7],
        edges: [48.0, TOP, 48.0 + SIDE, TOP + SIDE],
    }
    .draw(area)?;
    let color = if fitted { BLUE } else { MUTED };
    for row in rows {
        let [from, to] = [row.measured, predicted(row)].map(|at| (to_mm(at[0]), to_mm(at[1])));
        plane.line([from, to], color, 1.5)?;
    }
    for row in rows {
        let [x, y] = row.measured.map(to_mm);
        if x.is_finite() && y.is_finite() {
            dot(area, plane.place(x, y))?;
        }
    }
    if rows.is_empty() {
        let place = (px(68.0), px(TOP + 20.0));
        note(area, "no readings at hand", place, Side::Left, MUTED)?;
    }
    let sum: f64 = rows.iter().map(|row| residual(row).powi(2)).sum();
    let rms = (sum / rows.len().max(1) as f64).sqrt();
    let text = format!(
        "{} mm RMS of the length",
        super::super::super::table::mm(rms)
    );
    key(
        area,
        48.0 + SIDE,
        TOP - HEADING,
        &[(Mark::Line(color, 1.5), text.as_str())],
    )
}

/// A small dot at what was measured.
fn dot(area: &Area<'_>, (x, y): svg::Place) -> Drawn {
    let half = px(1.0);
    svg::fill(area, [(x - half, y - half), (x + half, y + half)], svg::INK)
}
