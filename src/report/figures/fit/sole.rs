//! Residuals where they were measured: CAD's and the fit's, at one scale.

use super::super::super::svg::{
    self, Area, BLUE, Drawn, Frame, HEADING, MUTED, Mark, Side, key, note, px, span,
};
use super::super::to_mm;
use sesc_identify::fit::residuals::Residual;

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

/// How much longer strokes are drawn than residuals are: the same for CAD and fit.
fn gain(rows: &[&Residual]) -> f64 {
    let both = [rms(rows, false), rms(rows, true)];
    let longest = both
        .into_iter()
        .filter(|x| x.is_finite())
        .fold(0.0, f64::max);
    let far = rows
        .iter()
        .flat_map(|row| row.measured)
        .filter(|x| x.is_finite());
    let far = far.fold(0.0, |far: f64, x| far.max(x.abs()));
    let steps = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0];
    let fits = |gain: &f64| longest > 0.0 && gain * longest < 0.12 * far;
    steps.into_iter().find(fits).unwrap_or(1.0)
}

/// RMS of the lengths of residuals, m.
fn rms(rows: &[&Residual], fitted: bool) -> f64 {
    let square = |row: &&Residual| {
        let to = if fitted { row.fitted } else { row.cad };
        (to[0] - row.measured[0]).powi(2) + (to[1] - row.measured[1]).powi(2)
    };
    (rows.iter().map(square).sum::<f64>() / rows.len().max(1) as f64).sqrt()
}

fn draw(area: &Area<'_>, rows: &[&Residual], fitted: bool) -> Drawn {
    let gain = gain(rows);
    let end = |row: &Residual, fitted: bool| {
        let to = if fitted { row.fitted } else { row.cad };
        [0, 1].map(|axis| row.measured[axis] + gain * (to[axis] - row.measured[axis]))
    };
    let mut ends: Vec<[f64; 2]> = Vec::new();
    for row in rows {
        ends.extend([row.measured, end(row, false), end(row, true)]);
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
        let [from, to] = [row.measured, end(row, fitted)].map(|at| (to_mm(at[0]), to_mm(at[1])));
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
    let length = super::super::super::table::mm(rms(rows, fitted));
    let text = match gain > 1.0 {
        true => format!("{length} mm RMS of the length, drawn × {gain}"),
        false => format!("{length} mm RMS of the length"),
    };
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
