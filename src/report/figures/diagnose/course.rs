//! The CoP posture by posture: measured, simulated, corrected.

use super::super::super::svg::{
    self, Area, BLUE, Drawn, Frame, HEADING, INK, MUTED, Mark, ORANGE, key, span,
};
use super::super::to_mm;
use super::{WIDE, boxed, dot};
use sesc_identify::diagnose::view::{Posture, chosen};

/// Postures that stay apart in one panel.
const MOST: usize = 90;
const RIGHT: f64 = 972.0;

/// x above, y below.
pub fn course(rows: &[Posture]) -> String {
    let few: Vec<&Posture> = chosen(rows.len(), MOST)
        .into_iter()
        .map(|k| &rows[k])
        .collect();
    let label = format!(
        "CoP of {} postures, mm: measured, simulated, corrected",
        few.len()
    );
    let which = match few.len() < rows.len() {
        true => format!("{} of {} postures, evenly chosen", few.len(), rows.len()),
        false => "posture, in the order of the log".to_string(),
    };
    svg::figure([WIDE, 484], &label, |area| {
        panel(area, &few, (0, ""), [32.0, 212.0])?;
        panel(area, &few, (1, &which), [262.0, 442.0])
    })
}

fn panel(
    area: &Area<'_>,
    rows: &[&Posture],
    (axis, x_name): (usize, &str),
    [top, bottom]: [f64; 2],
) -> Drawn {
    let of = |pick: fn(&Posture) -> [f64; 2]| {
        let values = rows.iter().enumerate();
        values.map(move |(k, row)| ((k + 1) as f64, to_mm(pick(row)[axis])))
    };
    let picks: [fn(&Posture) -> [f64; 2]; 3] =
        [|row| row.measured, |row| row.simulated, |row| row.corrected];
    let [measured, simulated, corrected] = picks;
    let title = ["CoP x, mm", "CoP y, mm"][axis];
    let plane = Frame {
        title,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(picks.into_iter().flat_map(of).map(|(_, value)| value)),
        x_name,
        ticks: [12, 6],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(area)?;
    // Neighbours in a log have nothing to do with each other: no lines between.
    for ((x, from), (_, to)) in of(simulated).zip(of(measured)) {
        plane.line([(x, from), (x, to)], ORANGE, 1.25)?;
        plane.mark(x, from, Mark::Dot(ORANGE))?;
    }
    for (row, (x, y)) in rows.iter().zip(of(measured)) {
        plane.mark(x, y, Mark::Ring(MUTED))?;
        if row.outlier && y.is_finite() {
            boxed(area, plane.place(x, y), 5.0)?;
        }
    }
    for (x, y) in of(corrected).filter(|(_, y)| y.is_finite()) {
        dot(area, plane.place(x, y), 2.0, BLUE)?;
    }
    let mut marks = vec![
        (Mark::Ring(MUTED), "measured"),
        (Mark::Dot(ORANGE), "simulated (CAD)"),
        (Mark::Dot(BLUE), "corrected"),
    ];
    if rows.iter().any(|row| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(area, RIGHT, top - HEADING, &marks)
}
