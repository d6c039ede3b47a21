//! The figures of the reports, one file each: rows in, SVG out.
//!
//! One colour means one thing throughout: grey is what a sensor read, black
//! or a pale band what is true, blue what was identified, orange what cannot
//! be known. Lengths are drawn in millimetres.

mod arrows;
mod bars;
mod cop;
pub mod diagnose;
mod errors;
pub mod fit;
mod health;
mod height;
mod lengths;
mod parameters;
pub mod plan;
mod range_bar;
pub mod robot;
#[cfg(test)]
mod tests;

pub use cop::{cop_over_postures, cop_plane};
pub use errors::errors;
pub use health::{health, said};
pub use height::{height_level, height_shape};
pub use lengths::{lengths_base, lengths_full};
pub use parameters::parameters;
pub use range_bar::range_bar;

/// Metres to millimetres.
fn to_mm(metres: f64) -> f64 {
    1e3 * metres
}

/// An opacity in twentieths, so that equal shades are equal bytes.
fn shade(part: f64) -> f64 {
    (part.clamp(0.0, 1.0) * 20.0).round() / 20.0
}
