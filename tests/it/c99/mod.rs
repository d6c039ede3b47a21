//! The generated C99, compiled and run on this machine: the bits of Rust, inside its proven bounds,
//! without overflow, without a warning. `tests/boards` runs these with other compilers once more.

pub(crate) mod bits;
pub(crate) mod bounds;
pub(crate) mod case;
pub(crate) mod compiled;
mod compilers;
pub(crate) mod draw;
pub(crate) mod entry;
mod estimator;
pub(crate) mod fixed;
pub(crate) mod lanes;
mod model;
mod rounding;
mod stack;
mod text;
