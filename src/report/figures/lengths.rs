//! ‖r_i‖ from CAD and identified, body by body (the paper's Fig. 3a).

use super::super::LengthRow;
use super::super::svg::{
    self, BLUE, Frame, GRID, HEADING, INK, Mark, ORANGE, Side, key, note, px, span,
};
use super::to_mm;

/// Height of a body's row, pixels.
const ROW: f64 = 20.0;
/// Longest name that fits beside the plane.
const NAME: usize = 19;

/// All columns by pseudo-inverse: lengths that CAD does not share, where part
/// of the vector cannot be known.
pub fn lengths_full(rows: &[LengthRow]) -> String {
    draw(
        rows,
        "‖r‖ from all columns, mm",
        |row| (row.cad_m, row.full_m),
        |row| !row.unseen.is_empty(),
    )
}

/// The identifiable part alone: lengths that agree with CAD, but for the
/// body that stands, whose height is the constant flat CoP cannot tell.
pub fn lengths_base(rows: &[LengthRow]) -> String {
    draw(
        rows,
        "‖identifiable part of r‖, mm",
        |row| (row.base_cad_m, row.base_m),
        |row| row.joint.is_empty() && !row.unseen.is_empty(),
    )
}

fn draw(
    rows: &[LengthRow],
    heading: &str,
    pair: fn(&LengthRow) -> (f64, f64),
    partly_unseen: fn(&LengthRow) -> bool,
) -> String {
    const TOP: f64 = 32.0;
    let bottom = TOP + ROW * rows.len().max(1) as f64;
    let size = [480, (bottom + 24.0).ceil() as u32];
    let label = format!("{heading}: CAD and identified for {} bodies", rows.len());
    svg::figure(size, &label, |area| {
        // Both figures of a page share the scale.
        let all = rows
            .iter()
            .flat_map(|r| [r.cad_m, r.full_m, r.base_cad_m, r.base_m]);
        let end = span(all.map(to_mm).chain([0.0])).end;
        let plane = Frame {
            title: heading,
            x: 0.0..end,
            y: -(rows.len().max(1) as f64)..0.0,
            x_name: "",
            ticks: [7, 0],
            edges: [136.0, TOP, 470.0, bottom],
        }
        .draw(area)?;
        for (k, row) in rows.iter().enumerate() {
            let y = -(k as f64) - 0.5;
            let (left, middle) = plane.place(0.0, y);
            plane.line([(0.0, y), (end, y)], GRID, 1.0)?;
            note(
                area,
                &shortened(&row.body),
                (left - px(8.0), middle),
                Side::Right,
                INK,
            )?;
            let (cad, identified) = pair(row);
            let (cad, identified) = (to_mm(cad), to_mm(identified));
            let (joined, dot) = if partly_unseen(row) {
                (ORANGE, Mark::Ring(ORANGE))
            } else {
                (BLUE, Mark::Dot(BLUE))
            };
            plane.line([(cad, y), (identified, y)], joined, 1.5)?;
            plane.mark(cad, y, Mark::Stroke(INK))?;
            plane.mark(identified, y, dot)?;
        }
        let stroke = (Mark::Stroke(INK), "CAD");
        let dot = (Mark::Dot(BLUE), "identified");
        let marks = match rows.iter().filter(|row| partly_unseen(row)).count() {
            0 => vec![stroke, dot],
            n if n == rows.len() => vec![stroke, (Mark::Ring(ORANGE), "identified, partly unseen")],
            _ => vec![stroke, dot, (Mark::Ring(ORANGE), "partly unseen")],
        };
        key(area, 470.0, TOP - HEADING, &marks)
    })
}

fn shortened(name: &str) -> String {
    if name.chars().count() <= NAME {
        return name.to_string();
    }
    name.chars().take(NAME - 1).chain(['…']).collect()
}
