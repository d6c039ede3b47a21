//! The figures of the reports: rows in, SVG out.
//!
//! One colour means one thing throughout: grey is what a sensor read, black
//! or a pale band what is true, blue what was identified, orange what cannot
//! be known. Lengths are drawn in millimetres.

mod arrows;
pub mod demo;
pub mod diagnose;
pub mod fit;
mod health;
pub mod plan;
pub mod robot;
#[cfg(test)]
mod tests;

pub use health::{health, said};

use super::plot::{Mark, Panel, Point, Series, area, rule, segments, series};
use super::svg::{Anchor, BAND, BLUE, Color, GRID, INK, MUTED, NUMBER, ORANGE, SMALL, TINY};
use super::table::mm;
use sesc_model::text::apart;

/// Width of a figure beside another one, and of one that has a row of the page for itself, pixels.
const HALF: f64 = 480.0;
const WIDE: f64 = 980.0;

/// Metres to millimetres.
fn to_mm(metres: f64) -> f64 {
    1e3 * metres
}

/// An opacity in twentieths, so that equal shades are equal bytes.
fn shade(part: f64) -> f64 {
    (part.clamp(0.0, 1.0) * 20.0).round() / 20.0
}

/// A bar and what it stands for.
struct Bar<'t> {
    name: &'t str,
    length_m: f64,
    color: Color,
    /// Where a pale bar behind it ends, m.
    pale_m: f64,
}

impl<'t> Bar<'t> {
    fn new(name: &'t str, length_m: f64, color: Color) -> Bar<'t> {
        let pale_m = 0.0;
        Bar {
            name,
            length_m,
            color,
            pale_m,
        }
    }
}

/// Letters beside a bar, at most.
const LETTERS: usize = 33;

/// The greatest of some lengths.
fn longest(lengths: impl IntoIterator<Item = f64>) -> f64 {
    let known = lengths.into_iter().filter(|length| length.is_finite());
    known.fold(0.0, f64::max)
}

/// Bars one below the other with their names and numbers, and a line at a length that has a name;
/// `longest_m` leaves room for its number.
fn bars(title: &str, bars: &[Bar<'_>], (name, limit_m): (&str, f64), longest_m: f64) -> Panel {
    let drawn = bars.iter().zip(0..).flat_map(|(bar, k)| {
        let ends = [bar.length_m, bar.pale_m, limit_m].map(to_mm);
        let ends = ends.map(|end| if end.is_finite() { end } else { 0.0 });
        let [upper, middle, lower] = [0.2, 0.5, 0.8].map(|part| -f64::from(k) - part);
        let number = format!("{} mm", mm(bar.length_m));
        let number = Point::worded(number, [longest(ends), middle]);
        let behind = Mark::Words(INK, NUMBER, Anchor::Start, [8.0, 0.0]);
        [
            area(GRID, 1.0, [[0.0, upper], [ends[1], lower]]),
            area(bar.color, 1.0, [[0.0, upper], [ends[0], lower]]),
            series(behind, [number]),
        ]
    });
    // A line without a name steps back.
    let color = if name.is_empty() { BAND } else { INK };
    let limit = rule(0, to_mm(limit_m), color, 1.5).named(name);
    let names: Vec<&str> = bars.iter().map(|bar| bar.name).collect();
    Panel {
        title: title.to_string(),
        x: Some(0.0..1.25 * to_mm(longest_m).max(1e-9)),
        rows: apart(&names, LETTERS),
        height: 34.0 * bars.len() as f64,
        series: drawn.chain([limit]).collect(),
        ..Panel::default()
    }
}

/// Bars with a line at the noise.
fn waterfall(title: &str, all: &[Bar<'_>], noise_m: f64) -> String {
    let words = all.iter();
    let words = words.map(|bar| format!("{} {} mm", bar.name, mm(bar.length_m)));
    let longest_m = longest(all.iter().map(|bar| bar.length_m));
    let panel = bars(title, all, ("", noise_m), longest_m);
    let label = format!("{title}: {}", words.collect::<Vec<_>>().join(", "));
    panel.alone(600.0, label)
}

/// ‖r‖ of a body, m.
struct Length<'t> {
    body: &'t str,
    cad: f64,
    found: f64,
    /// Ends of the line that is drawn.
    line: [f64; 2],
    /// Whether data tell it.
    is_told: bool,
    /// What a pointer is told after the lengths.
    more: String,
}

/// A row for each body with its length by CAD and as identified; `names` are those of what data
/// tell and do not tell.
fn lengths(title: &str, rows: &[Length<'_>], names: [&str; 2]) -> Panel {
    /// Letters of a body that fit beside the plane.
    const LETTERS: usize = 19;
    let at = |k: usize, metres: f64| [to_mm(metres), -(k as f64) - 0.5];
    let cad = rows.iter().enumerate().map(|(k, row)| at(k, row.cad));
    let kinds = [
        (true, BLUE, Mark::dot(BLUE), names[0]),
        (false, ORANGE, Mark::Ring(ORANGE), names[1]),
    ];
    let found = kinds.into_iter().flat_map(|(is_told, color, mark, name)| {
        let own = rows.iter().enumerate();
        let own = own.filter(move |(_, row)| row.is_told == is_told);
        let lines = own.clone().map(|(k, row)| row.line.map(|end| at(k, end)));
        // What is no number is not drawn.
        let known = own.filter(|(_, row)| row.cad.is_finite());
        let found = known.map(|(k, row)| {
            let [cad, found] = [row.cad, row.found].map(to_mm);
            let lengths = format!("CAD {cad:.2} mm, identified {found:.2}{}", row.more);
            Point::worded(format!("{} · {lengths}", row.body), at(k, row.found))
        });
        [
            segments(color, 1.75, lines),
            series(mark, found).named(name),
        ]
    });
    let bodies: Vec<&str> = rows.iter().map(|row| row.body).collect();
    let cad = series(Mark::stroke(INK), cad).named("CAD");
    Panel {
        title: title.to_string(),
        ticks: [7, 0],
        rows: apart(&bodies, LETTERS),
        height: 19.0 * rows.len().max(1) as f64,
        series: std::iter::once(cad).chain(found).collect(),
        ..Panel::default()
    }
}

/// A square for each pair of `count` numbered things: its colour, opacity and number.
fn pairs(
    title: &str,
    count: usize,
    square: impl Fn(usize, usize) -> Option<(Color, f64, String)>,
) -> Panel {
    let mut squares: Vec<Series> = Vec::new();
    let mut numbers = Vec::new();
    for (row, column) in (0..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
        let [x, y] = [column as f64, -(row as f64)];
        if let Some((color, opacity, number)) = square(row, column) {
            squares.push(area(color, opacity, [[x, y], [x + 1.0, y - 1.0]]));
            numbers.push(Point::worded(number, [x + 0.5, y - 0.5]));
        }
    }
    // Numbers that stay apart.
    let step = match count {
        0..=20 => 1,
        21..=100 => 5,
        _ => 20,
    };
    let told = (0..count).filter(|k| *k == 0 || (k + 1) % step == 0);
    let at = |place: fn(f64) -> [f64; 2]| {
        let told = told.clone();
        told.map(move |k| Point::worded((k + 1).to_string(), place(k as f64 + 0.5)))
    };
    let inside = Mark::Words(INK, TINY, Anchor::Middle, [0.0; 2]);
    let above = Mark::Words(MUTED, SMALL, Anchor::Middle, [0.0, -8.0]);
    let left = Mark::Words(MUTED, SMALL, Anchor::End, [-8.0, 0.0]);
    let numbers = [
        series(inside, numbers),
        series(above, at(|k| [k, 0.0])),
        series(left, at(|k| [0.0, -k])),
    ];
    Panel {
        title: title.to_string(),
        x: Some(0.0..count as f64),
        y: Some(-(count as f64)..0.0),
        height: HALF - 56.0,
        series: squares.into_iter().chain(numbers).collect(),
        ..Panel::default()
    }
}
