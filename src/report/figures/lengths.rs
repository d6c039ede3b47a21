//! ‖r_i‖ from CAD and identified, body by body (the paper's Fig. 3a).

use super::super::LengthRow;
use super::super::svg::{Anchor, Axes, BLUE, Figure, GRID, HEADING, INK, Mark, ORANGE, key, span};
use super::to_mm;
use sesc_model::text::shortened;

/// Height of a body's row, pixels.
const ROW: f64 = 20.0;
const TOP: f64 = 32.0;
const LEFT: f64 = 148.0;
const RIGHT: f64 = 470.0;
/// Letters of a name that fit beside the plane.
const NAME: usize = 19;

/// All columns by pseudo-inverse: lengths that CAD does not share, where part
/// of the vector cannot be known.
pub fn lengths_full(rows: &[LengthRow]) -> String {
    draw(
        rows,
        "‖r‖ from all columns, mm",
        |row| [row.cad_m, row.full_m],
        |row| !row.unseen.is_empty(),
    )
}

/// The identifiable part alone: lengths that agree with CAD, but for the
/// body that stands, whose height is the constant flat CoP cannot tell.
pub fn lengths_base(rows: &[LengthRow]) -> String {
    draw(
        rows,
        "‖identifiable r‖, mm",
        |row| [row.base_cad_m, row.base_m],
        |row| row.joint.is_empty() && !row.unseen.is_empty(),
    )
}

fn draw(
    rows: &[LengthRow],
    title: &str,
    pair: fn(&LengthRow) -> [f64; 2],
    partly_unseen: fn(&LengthRow) -> bool,
) -> String {
    let count = rows.len().max(1) as f64;
    let bottom = TOP + ROW * count;
    let label = format!("{title}: CAD and identified for {} bodies", rows.len());
    let mut figure = Figure::new([480.0, bottom + 24.0], &label);
    // Both figures of a page share the scale.
    let all = rows
        .iter()
        .flat_map(|r| [r.cad_m, r.full_m, r.base_cad_m, r.base_m]);
    let end = span(all.map(to_mm).chain([0.0])).end;
    let plane = Axes {
        title,
        x: 0.0..end,
        y: -count..0.0,
        x_name: "",
        ticks: [7, 0],
        edges: [LEFT, TOP, RIGHT, bottom],
    }
    .draw(&mut figure);
    for (k, row) in rows.iter().enumerate() {
        let at = |x: f64| plane.at([x, -(k as f64) - 0.5]);
        let [left, middle] = at(0.0);
        figure.line([at(0.0), at(end)], GRID, 1.0);
        let name = shortened(&row.body, NAME);
        figure.note([left - 8.0, middle], Anchor::End, INK, &name);
        let lengths = pair(row).map(to_mm);
        let [cad, identified] = lengths.map(at);
        let (color, mark) = match partly_unseen(row) {
            true => (ORANGE, Mark::Ring(ORANGE)),
            false => (BLUE, Mark::Dot(BLUE)),
        };
        figure.line([cad, identified], color, 1.5);
        figure.mark(cad, Mark::Stroke(INK));
        // What is no number is not drawn.
        if lengths.iter().all(|length| length.is_finite()) {
            let [cad, found] = lengths;
            let words = format!("{} · CAD {cad:.2} mm, identified {found:.2} mm", row.body);
            figure.worded(&words, |figure| figure.mark(identified, mark));
        }
    }
    let cad = (Mark::Stroke(INK), "CAD");
    let dot = (Mark::Dot(BLUE), "identified");
    let marks = match rows.iter().filter(|row| partly_unseen(row)).count() {
        0 => vec![cad, dot],
        n if n == rows.len() => vec![cad, (Mark::Ring(ORANGE), "identified, partly unseen")],
        _ => vec![cad, dot, (Mark::Ring(ORANGE), "partly unseen")],
    };
    key(&mut figure, RIGHT, TOP - HEADING, &marks);
    figure.finish()
}
