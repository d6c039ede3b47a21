//! The CoP posture by posture: measured, simulated, corrected.

use super::super::super::svg::{Axes, BLUE, Figure, HEADING, INK, MUTED, Mark, ORANGE, key, span};
use super::super::to_mm;
use super::WIDE;
use sesc_identify::diagnose::view::{Posture, chosen};

/// Postures that stay apart in one panel.
const MOST: usize = 90;
const RIGHT: f64 = 972.0;

/// x above, y below.
pub fn course(rows: &[Posture]) -> String {
    let few: Vec<(usize, &Posture)> = chosen(rows.len(), MOST)
        .into_iter()
        .map(|k| (k, &rows[k]))
        .collect();
    let label = format!(
        "CoP of {} postures, mm: measured, simulated, corrected",
        few.len()
    );
    let which = match few.len() < rows.len() {
        true => format!("{} of {} postures, evenly chosen", few.len(), rows.len()),
        false => "posture, in the order of the log".to_string(),
    };
    let mut figure = Figure::new([WIDE, 484.0], &label);
    panel(&mut figure, &few, (0, ""), [32.0, 212.0]);
    panel(&mut figure, &few, (1, &which), [262.0, 442.0]);
    figure.finish()
}

fn panel(
    figure: &mut Figure,
    rows: &[(usize, &Posture)],
    (axis, x_name): (usize, &str),
    [top, bottom]: [f64; 2],
) {
    let of = |pick: fn(&Posture) -> [f64; 2]| {
        let rows = rows.iter().zip(1..);
        rows.map(move |((_, row), k)| [f64::from(k), to_mm(pick(row)[axis])])
    };
    let picks: [fn(&Posture) -> [f64; 2]; 3] =
        [|row| row.measured, |row| row.simulated, |row| row.corrected];
    let [measured, simulated, corrected] = picks;
    let plane = Axes {
        title: ["CoP x, mm", "CoP y, mm"][axis],
        x: 0.0..(rows.len() + 1) as f64,
        y: span(picks.into_iter().flat_map(of).map(|[_, value]| value)),
        x_name,
        ticks: [12, 6],
        edges: [48.0, top, RIGHT, bottom],
    }
    .draw(figure);
    let places = |pick| of(pick).map(|point| plane.at(point));
    // Neighbours in a log have nothing to do with each other: no lines between.
    let all = places(simulated)
        .zip(places(measured))
        .zip(places(corrected));
    for ((posture, row), ((from, to), corrected)) in rows.iter().zip(all) {
        figure.posture(*posture, |figure| {
            figure.line([from, to], ORANGE, 1.25);
            figure.mark(from, Mark::Dot(ORANGE));
            figure.mark(to, Mark::Ring(MUTED));
            if row.outlier {
                figure.boxed(to, 5.0);
            }
            figure.dot(corrected, 2.0, BLUE);
        });
    }
    let mut marks = vec![
        (Mark::Ring(MUTED), "measured"),
        (Mark::Dot(ORANGE), "simulated (CAD)"),
        (Mark::Dot(BLUE), "corrected"),
    ];
    if rows.iter().any(|(_, row)| row.outlier) {
        marks.push((Mark::Box(INK), "outlier"));
    }
    key(figure, RIGHT, top - HEADING, &marks);
}
