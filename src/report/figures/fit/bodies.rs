//! ‖r_i‖ from CAD and identified, body by body, with one standard deviation.

use super::super::super::svg::{Anchor, Axes, BLUE, Figure, GRID, HEADING, INK, Mark, ORANGE};
use super::super::super::svg::{key, span};
use super::super::to_mm;
use super::NAME;
use sesc_identify::fit::BodyLength;
use sesc_model::text::shortened;

/// Height of a body's row, pixels.
const ROW: f64 = 18.0;
const TOP: f64 = 32.0;
const RIGHT: f64 = 470.0;

/// One row per body, outward from the support.
pub fn bodies(rows: &[BodyLength]) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = TOP + ROW * count;
    let label = format!("‖r‖ of {} bodies, mm: CAD and identified", rows.len());
    let mut figure = Figure::new([480.0, bottom + 24.0], &label);
    let ends = rows.iter().flat_map(|row| {
        let wide = row.std.unwrap_or(0.0);
        [row.cad, row.identified - wide, row.identified + wide]
    });
    let range = span(ends.map(to_mm).chain([0.0]));
    let low = range.start.min(0.0);
    let plane = Axes {
        title: "‖r‖ per body, mm",
        x: low..range.end,
        y: -count..0.0,
        x_name: "",
        ticks: [7, 0],
        edges: [158.0, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(low);
        figure.line([at(low), at(range.end)], GRID, 1.0);
        let name = shortened(&row.body, NAME);
        figure.note([left - 8.0, middle], Anchor::End, INK, &name);
        let found = to_mm(row.identified);
        figure.mark(at(to_mm(row.cad)), Mark::Stroke(INK));
        // What is no number is not drawn.
        if !found.is_finite() || !row.cad.is_finite() {
            continue;
        }
        let lengths = format!("CAD {:.2} mm, identified {found:.2}", to_mm(row.cad));
        let (words, mark) = match row.std.map(to_mm).filter(|wide| wide.is_finite()) {
            Some(wide) => {
                figure.line([at(found - wide), at(found + wide)], BLUE, 2.0);
                let words = format!("{} · {lengths} ± {wide:.2} mm", row.body);
                (words, Mark::Dot(BLUE))
            }
            None => {
                let words = format!("{} · {lengths} mm, which data do not tell", row.body);
                (words, Mark::Ring(ORANGE))
            }
        };
        figure.worded(&words, |figure| figure.mark(at(found), mark));
    }
    let mut marks = vec![
        (Mark::Stroke(INK), "CAD"),
        (Mark::Dot(BLUE), "identified ± std"),
    ];
    if rows.iter().any(|row| row.std.is_none()) {
        marks.push((Mark::Ring(ORANGE), "not told"));
    }
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}
