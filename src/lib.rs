//! `sesc`: centre of mass by the statically equivalent serial chain.
//!
//! The command line and its reports, above the libraries that do the work:
//!
//! ```text
//! sesc-model → sesc-codegen                    generate
//!     |      → sesc-reference → verify         generated functions against the reference
//!     `------→ sesc-identify                   fit, plan, diagnose, fleet
//!                   `→ report, cli             figures, tables, pages, options
//! ```
//!
//! A command in [`cli`] parses its options, calls one function and prints what it returns.

#![forbid(unsafe_code)]

pub mod cli;
pub mod demo;
pub mod effect_pages;
pub mod error;
pub mod inspect;
pub mod report;
pub mod servos;
pub mod verify;
mod words;

pub use error::Error;

/// The URDF of the OP2, embedded: `sesc demo` needs no files.
pub const OP2_URDF: &str = include_str!("../robots/op2/op2.urdf");
