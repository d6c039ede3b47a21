//! What is wrong with data, row by row.

use super::super::svg::{Axes, Figure, HEADING, MUTED, Mark, ORANGE, key, span};
use sesc_identify::health::Picture;

/// One number over the rows of a log, the rows that are meant apart.
pub fn health(picture: &Picture) -> String {
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
    let known = picture.points.iter().filter(|point| point.1.is_finite());
    for &(at, value, meant) in known {
        let mark = if meant { found } else { row };
        let words = format!("row {at} · {}: {}", picture.title, rounded(value));
        figure.worded(&words, |figure| {
            figure.mark(plane.at([at as f64, value]), mark);
        });
    }
    let [other, meant] = picture.marks();
    let marks = [(row, other), (found, meant)];
    key(&mut figure, EDGES[2], EDGES[1] - HEADING, &marks);
    figure.finish()
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
