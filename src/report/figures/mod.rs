//! The figures of the reports: rows in, SVG out.
//!
//! One colour means one thing throughout: grey is what a sensor read, black
//! or a pale band what is true, blue what was identified, orange what cannot
//! be known. Lengths are drawn in millimetres.

mod arrows;
mod bars;
pub mod demo;
pub mod diagnose;
pub mod fit;
mod health;
pub mod plan;
pub mod robot;
#[cfg(test)]
mod tests;

pub use health::{health, said};

/// Metres to millimetres.
fn to_mm(metres: f64) -> f64 {
    1e3 * metres
}

/// An opacity in twentieths, so that equal shades are equal bytes.
fn shade(part: f64) -> f64 {
    (part.clamp(0.0, 1.0) * 20.0).round() / 20.0
}
