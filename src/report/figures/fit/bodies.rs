//! ‖r_i‖ from CAD and identified, body by body, with one standard deviation.

use super::super::super::svg::{
    self, BLUE, Frame, GRID, HEADING, INK, Mark, ORANGE, Side, key, note, px, span,
};
use super::super::to_mm;
use super::shortened;
use sesc_identify::fit::identification::BodyLength;

/// Height of a body's row, pixels.
const ROW: f64 = 18.0;
const TOP: f64 = 32.0;
const RIGHT: f64 = 470.0;

/// One row per body, outward from the support.
pub fn bodies(rows: &[BodyLength]) -> String {
    let bottom = TOP + ROW * rows.len().max(1) as f64;
    let size = [480, (bottom + 24.0).ceil() as u32];
    let label = format!("‖r‖ of {} bodies, mm: CAD and identified", rows.len());
    svg::figure(size, &label, |area| {
        let ends = rows.iter().flat_map(|row| {
            let wide = row.std.unwrap_or(0.0);
            [row.cad, row.identified - wide, row.identified + wide]
        });
        let range = span(ends.map(to_mm).chain([0.0]));
        let plane = Frame {
            title: "‖r‖ per body, mm",
            x: range.start.min(0.0)..range.end,
            y: -(rows.len().max(1) as f64)..0.0,
            x_name: "",
            ticks: [7, 0],
            edges: [148.0, TOP, RIGHT, bottom],
        }
        .draw(area)?;
        for (k, row) in rows.iter().enumerate() {
            let y = -(k as f64) - 0.5;
            let (left, middle) = plane.place(range.start.min(0.0), y);
            plane.line([(range.start.min(0.0), y), (range.end, y)], GRID, 1.0)?;
            let name = shortened(&row.body);
            note(area, &name, (left - px(8.0), middle), Side::Right, INK)?;
            let found = to_mm(row.identified);
            plane.mark(to_mm(row.cad), y, Mark::Stroke(INK))?;
            match row.std.map(to_mm).filter(|wide| wide.is_finite()) {
                Some(wide) => {
                    plane.line([(found - wide, y), (found + wide, y)], BLUE, 2.0)?;
                    plane.mark(found, y, Mark::Dot(BLUE))?;
                }
                None => plane.mark(found, y, Mark::Ring(ORANGE))?,
            }
        }
        let mut marks = vec![
            (Mark::Stroke(INK), "CAD"),
            (Mark::Dot(BLUE), "identified ± std"),
        ];
        if rows.iter().any(|row| row.std.is_none()) {
            marks.push((Mark::Ring(ORANGE), "not told"));
        }
        key(area, RIGHT, TOP - HEADING, &marks)
    })
}
