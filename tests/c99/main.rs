//! The generated C99, compiled by gcc and clang and run on this machine: the
//! bits of Rust, inside its proven bounds, without overflow, without a warning.

mod bits;
mod bounds;
mod case;
#[path = "../common/mod.rs"]
mod common;
mod compiled;
#[path = "../common/exact.rs"]
mod exact;
mod fixed;
mod model;
mod quality;
