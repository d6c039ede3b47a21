//! The gap in the order of the log: before and after.

use super::super::super::svg::{Axes, BLUE, Figure, HEADING, INK, Mark, ORANGE, key, span};
use super::super::to_mm;
use super::WIDE;
use sesc_identify::diagnose::view::{DiagnosisView, Posture};

const RIGHT: f64 = 972.0;

/// Measured less simulated over time, or over the postures where none is logged.
pub fn rest(view: &DiagnosisView) -> String {
    let label = format!(
        "Measured less simulated CoP of {} postures over the log, mm: before and after",
        view.postures.len()
    );
    let mut figure = Figure::new([WIDE, 404.0], &label);
    panel(&mut figure, view, 0, [32.0, 172.0]);
    panel(&mut figure, view, 1, [222.0, 362.0]);
    figure.finish()
}

fn panel(figure: &mut Figure, view: &DiagnosisView, axis: usize, [top, bottom]: [f64; 2]) {
    let rows = &view.postures;
    let of = |row: &Posture, from: [f64; 2]| to_mm(row.measured[axis] - from[axis]);
    let both = rows
        .iter()
        .flat_map(|row| [of(row, row.simulated), of(row, row.corrected)]);
    let along = span(rows.iter().map(|row| row.at));
    let plane = Axes {
        title: ["Gap in x, mm", "Gap in y, mm"][axis],
        x: along.clone(),
        y: span(both.chain([0.0])),
        x_name: match (axis, view.timed) {
            (0, _) => "",
            (_, true) => "time, s",
            (_, false) => "posture, in the order of the log",
        },
        ticks: [12, 5],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(figure);
    let zero = [along.start, along.end].map(|x| plane.at([x, 0.0]));
    figure.line(zero, INK, 1.0);
    for (k, row) in rows.iter().enumerate() {
        let at = plane.at([row.at, of(row, row.simulated)]);
        figure.posture(k, |figure| figure.dot(at, 2.4, ORANGE));
    }
    for (k, row) in rows.iter().enumerate() {
        let at = plane.at([row.at, of(row, row.corrected)]);
        figure.posture(k, |figure| {
            figure.dot(at, 2.4, BLUE);
            if row.outlier {
                figure.boxed(at, 5.0);
            }
        });
    }
    let mut marks = vec![
        (Mark::Dot(ORANGE), "before: CAD"),
        (Mark::Dot(BLUE), "after: corrected"),
    ];
    if rows.iter().any(|row| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(figure, RIGHT, top - HEADING, &marks);
}
