//! CoM height over postures (the paper's Fig. 8): its shape is known, one
//! constant is not.

use super::super::HeightRow;
use super::super::svg::{Anchor, Axes, BAND, BLUE, Color, Figure, HEADING, INK, Mark};
use super::super::svg::{ORANGE, Place, key, span};
use super::super::table::mm;
use super::to_mm;

const SIZE: [f64; 2] = [480.0, 270.0];
const EDGES: [f64; 4] = [44.0, 32.0, 474.0, 236.0];

/// The identified height with the constant of minimum norm, off by `offset_m`. The page has the
/// first row's posture under the number `first`.
pub fn height_level(rows: &[HeightRow], offset_m: f64, first: usize) -> String {
    let label = format!(
        "CoM height over {} postures: identified lies {} mm off the truth",
        rows.len(),
        mm(offset_m)
    );
    let mut figure = Figure::new(SIZE, &label);
    let curves = draw(
        &mut figure,
        rows,
        "CoM height as fitted, mm",
        (|row| row.identified, ORANGE),
        Some(0.0),
    );
    for (truth, identified) in curves[0].iter().zip(&curves[1]) {
        figure.line([*truth, *identified], ORANGE, 0.75);
    }
    dots(&mut figure, &curves[1], ORANGE, first);
    // The text stands under the curves where it has room.
    let lowest = curves.iter().flatten().map(|place| place[1]);
    let lowest = lowest.filter(|y| y.is_finite()).fold(EDGES[1], f64::max);
    if EDGES[3] - lowest > 48.0 {
        let (left, middle) = (EDGES[0] + 20.0, (EDGES[3] + lowest) / 2.0);
        let text = format!("on average {} mm apart:", mm(offset_m.abs()));
        figure.note([left, middle - 8.0], Anchor::Start, INK, &text);
        let text = "one constant that flat CoP cannot tell";
        figure.note([left, middle + 8.0], Anchor::Start, INK, text);
    }
    figure.finish()
}

/// The identified height with its constant from CAD, magnified. The page has the first row's
/// posture under the number `first`.
pub fn height_shape(rows: &[HeightRow], first: usize) -> String {
    let label = format!(
        "CoM height over {} postures with the constant from CAD: identified follows the truth",
        rows.len()
    );
    let mut figure = Figure::new(SIZE, &label);
    let title = "CoM height, constant from CAD, mm";
    let curves = draw(&mut figure, rows, title, (|row| row.anchored, BLUE), None);
    dots(&mut figure, &curves[1], BLUE, first);
    figure.finish()
}

/// A dot for each posture on a curve.
fn dots(figure: &mut Figure, curve: &[Place], color: Color, first: usize) {
    for (at, k) in curve.iter().zip(first..) {
        figure.posture(k, |figure| figure.dot(*at, 2.4, color));
    }
}

/// The true curve and another one; returns the places of both. The axis reaches down
/// to `lowest`.
fn draw(
    figure: &mut Figure,
    rows: &[HeightRow],
    title: &str,
    (pick, color): (fn(&HeightRow) -> f64, Color),
    lowest: Option<f64>,
) -> [Vec<Place>; 2] {
    let heights = rows.iter().flat_map(|row| [row.truth, pick(row)]);
    let plane = Axes {
        title,
        x: 0.0..(rows.len() + 1) as f64,
        y: span(heights.map(to_mm).chain(lowest)),
        x_name: "posture",
        ticks: [6, 6],
        edges: EDGES,
    }
    .draw(figure);
    let curve = |pick: fn(&HeightRow) -> f64| -> Vec<Place> {
        let rows = rows.iter().zip(1..);
        rows.map(|(row, k)| plane.at([f64::from(k), to_mm(pick(row))]))
            .collect()
    };
    let curves = [curve(|row| row.truth), curve(pick)];
    figure.line(curves[0].iter().copied(), BAND, 7.0);
    figure.line(curves[1].iter().copied(), color, 1.75);
    let marks = [
        (Mark::Line(BAND, 7.0), "truth"),
        (Mark::Line(color, 1.75), "identified"),
    ];
    key(figure, EDGES[2], EDGES[1] - HEADING, &marks);
    curves
}
