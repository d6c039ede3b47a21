//! The generated C99, compiled and run on this machine: the bits of Rust, inside its proven bounds,
//! without overflow, without a warning. `tests/boards` runs these with other compilers once more.

pub mod bits;
pub mod bounds;
pub mod case;
pub mod compiled;
mod compilers;
pub mod draw;
pub mod entry;
mod estimator;
pub mod fixed;
pub mod lanes;
mod model;
mod rounding;
mod stack;
mod text;
