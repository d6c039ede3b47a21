//! The gap in the order of the log: before and after.

use super::super::super::svg::{self, Area, BLUE, Drawn, Frame, HEADING, INK, Mark, ORANGE, key};
use super::super::to_mm;
use super::{WIDE, boxed, dot, room};
use sesc_identify::diagnose::view::{DiagnosisView, Posture};

const RIGHT: f64 = 972.0;

/// Measured less simulated over time, or over the postures where none is logged.
pub fn rest(view: &DiagnosisView) -> String {
    let label = format!(
        "Measured less simulated CoP of {} postures over the log, mm: before and after",
        view.postures.len()
    );
    svg::figure([WIDE, 404], &label, |area| {
        panel(area, view, 0, [32.0, 172.0])?;
        panel(area, view, 1, [222.0, 362.0])
    })
}

fn panel(area: &Area<'_>, view: &DiagnosisView, axis: usize, [top, bottom]: [f64; 2]) -> Drawn {
    let rows = &view.postures;
    let of = |row: &Posture, from: [f64; 2]| to_mm(row.measured[axis] - from[axis]);
    let both = rows
        .iter()
        .flat_map(|row| [of(row, row.simulated), of(row, row.corrected)]);
    let along = room(rows.iter().map(|row| row.at));
    let plane = Frame {
        title: ["Gap in x, mm", "Gap in y, mm"][axis],
        x: along.clone(),
        y: room(both.chain([0.0])),
        x_name: match (axis, view.timed) {
            (0, _) => "",
            (_, true) => "time, s",
            (_, false) => "posture, in the order of the log",
        },
        ticks: [12, 5],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(area)?;
    plane.line([(along.start, 0.0), (along.end, 0.0)], INK, 1.0)?;
    for (color, after) in [(ORANGE, false), (BLUE, true)] {
        for row in rows {
            let gap = of(row, if after { row.corrected } else { row.simulated });
            if gap.is_finite() && row.at.is_finite() {
                let place = plane.place(row.at, gap);
                dot(area, place, 2.4, color)?;
                if row.outlier && after {
                    boxed(area, place, 5.0)?;
                }
            }
        }
    }
    let mut marks = vec![
        (Mark::Dot(ORANGE), "before: CAD"),
        (Mark::Dot(BLUE), "after: corrected"),
    ];
    if rows.iter().any(|row| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(area, RIGHT, top - HEADING, &marks)
}
