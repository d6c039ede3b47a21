//! The generated C99, compiled and run on this machine: the bits of Rust, inside its proven bounds,
//! without overflow, without a warning. `tests/boards` runs these with other compilers once more.

mod bits;
mod bounds;
pub mod case;
pub mod compiled;
mod compilers;
mod draw;
mod entry;
mod estimator;
pub mod fixed;
pub mod lanes;
mod model;
mod rounding;
mod text;
