//! What is wrong with data, row by row.

use super::super::plot::{Mark, Panel, Point, series};
use super::super::svg::{MUTED, ORANGE};
use sesc_identify::health::{Picture, Row};

/// One number over the rows of a log, the rows that are meant apart; `posture` is the number
/// under which a page shows a row's posture, if it does.
pub fn health(picture: &Picture, posture: impl Fn(&Row) -> Option<usize>) -> String {
    let meant = picture.points.iter().filter(|point| point.2).count();
    let last = picture.points.last().map_or(1, |point| point.0);
    let mut rows = picture.rows.iter().peekable();
    let mut points = [Vec::new(), Vec::new()];
    for point in &picture.points {
        let (number, value, meant) = *point;
        while rows.next_if(|row| row.number != number).is_some() {}
        let at = [number as f64, value];
        points[usize::from(meant)].push(match rows.peek().and_then(|row| posture(row)) {
            Some(k) => Point::posture(k, at),
            None => Point::worded(format!("row {number} · {}", said(picture, &[*point])), at),
        });
    }
    let kinds = [Mark::Ring(MUTED), Mark::dot(ORANGE)]
        .into_iter()
        .zip(points);
    let all = kinds.zip(picture.marks());
    let all = all.map(|((mark, points), name)| series(mark, points).named(name));
    let panel = Panel {
        title: picture.title.clone(),
        x: Some(0.0..(last + 1) as f64),
        x_name: "row".to_string(),
        ticks: [8, 5],
        height: 174.0,
        series: all.collect(),
        ..Panel::default()
    };
    let label = format!(
        "{} over {} rows, of which the finding is about {meant}",
        picture.title,
        picture.points.len()
    );
    panel.alone(720.0, label)
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
