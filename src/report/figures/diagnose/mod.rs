//! Figures of a diagnosis: rows in, SVG out.
//!
//! Grey is what was measured, orange the simulation as CAD has it, blue the
//! simulation with what was missing; an outlier wears a box.

mod arrows;
mod confusion;
mod course;
mod regions;
mod rest;
mod spread;
#[cfg(test)]
mod tests;
mod trends;
mod waterfall;

use std::ops::Range;

use plotters::prelude::*;

use super::super::svg::{Area, Drawn, INK, Place, line, px, span};

pub use arrows::arrows;
pub use confusion::confusion;
pub use course::course;
pub use regions::regions;
pub use rest::rest;
pub use spread::spread;
pub use trends::trends;
pub use waterfall::waterfall;

/// Width of a figure that has a row of the page for itself, pixels.
const WIDE: u32 = 980;

/// A dot for one of many.
fn dot(area: &Area<'_>, place: Place, radius: f64, color: RGBColor) -> Drawn {
    area.draw(&Circle::new(place, px(radius), color.filled()))
}

/// The box around an outlier.
fn boxed(area: &Area<'_>, (x, y): Place, half: f64) -> Drawn {
    let half = px(half);
    outline(area, [(x - half, y - half), (x + half, y + half)], INK)
}

/// The edges of a box; plotters draws those of a rectangle as thin as it can.
fn outline(area: &Area<'_>, [a, b]: [Place; 2], color: RGBColor) -> Drawn {
    line(area, vec![a, (b.0, a.1), b, (a.0, b.1), a], color, 1.0)
}

/// A range that leaves room for ticks, even around a single value.
fn room(values: impl IntoIterator<Item = f64>) -> Range<f64> {
    let Range { start, end } = span(values);
    match end - start > 1e-3 * start.abs().max(end.abs()).max(1e-3) {
        true => start..end,
        false => {
            let middle = (start + end) / 2.0;
            let half = (0.05 * middle.abs()).max(1.0);
            middle - half..middle + half
        }
    }
}

/// The first letters of a name that is too long for its place.
fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_string();
    }
    name.chars().take(most - 1).chain(['…']).collect()
}
