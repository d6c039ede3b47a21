//! The generated C99, compiled by gcc and clang and run on this machine: the
//! bits of Rust, inside its proven bounds, without overflow, without a warning.

mod bits;
mod bounds;
mod case;
mod compiled;
mod draw;
mod entry;
mod estimator;
mod fixed;
mod lanes;
mod machines;
mod model;
mod quality;
mod rounding;
