//! What is wrong with data, row by row.

use super::super::svg::{Axes, Figure, HEADING, MUTED, Mark, ORANGE, key, span};
use sesc_identify::health::{Picture, Row};

/// One number over the rows of a log, the rows that are meant apart; `posture` is the number
/// under which a page shows a row's posture, if it does.
pub fn health(picture: &Picture, posture: impl Fn(&Row) -> Option<usize>) -> String {
    const EDGES: [f64; 4] = [52.0, 32.0, 704.0, 206.0];
    let meant = picture.points.iter().filter(|point| point.2).count();
    let label = format!(
        "{} over {} rows, of which the finding is about {meant}",
        picture.title,
        picture.points.len()
    );
    let mut figure = Figure::new([720.0, 244.0], &label);
    let last = picture.points.last().map_or(1, |point| point.0);
    let plane = Axes {
        title: &picture.title,
        x: 0.0..(last + 1) as f64,
        y: span(picture.points.iter().map(|point| point.1)),
        x_name: "row",
        ticks: [8, 5],
        edges: EDGES,
    }
    .draw(&mut figure);
    let (row, found) = (Mark::Ring(MUTED), Mark::Dot(ORANGE));
    let mut rows = picture.rows.iter().peekable();
    for point in &picture.points {
        let (at, value, meant) = *point;
        while rows.next_if(|row| row.number != at).is_some() {}
        if !value.is_finite() {
            continue;
        }
        let mark = if meant { found } else { row };
        let draw = |figure: &mut Figure| figure.mark(plane.at([at as f64, value]), mark);
        match rows.peek().and_then(|row| posture(row)) {
            Some(k) => figure.posture(k, draw),
            None => figure.worded(&format!("row {at} · {}", said(picture, &[*point])), draw),
        }
    }
    let [other, meant] = picture.marks();
    let marks = [(row, other), (found, meant)];
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
    figure.finish()
}

/// What a row's `points` show, in words: `CoP x, mm: CAD 12.3, reading 14`.
pub fn said(picture: &Picture, points: &[(usize, f64, bool)]) -> String {
    let [sound, found] = picture.marks();
    let value = |&(_, value, meant): &(usize, f64, bool)| match (&picture.marks, meant) {
        (None, _) => rounded(value),
        (Some(_), false) => format!("{sound} {}", rounded(value)),
        (Some(_), true) => format!("{found} {}", rounded(value)),
    };
    let values: Vec<String> = points.iter().map(value).collect();
    format!("{}: {}", picture.title, values.join(", "))
}

/// Four digits, as people write a number.
fn rounded(value: f64) -> String {
    let digits = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    text.replace('-', "−")
}
