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
//! A command in `cli` parses its options, calls one function and prints what it returns.
//!
//! The package is a command line: programs call `sesc-model`, `sesc-codegen` and
//! `sesc-identify`. What is reachable here serves the binary, the tests and the benches,
//! stays out of the documentation and may change in any release.

#![forbid(unsafe_code)]

#[doc(hidden)]
pub mod cli;
#[doc(hidden)]
pub mod demo;
#[doc(hidden)]
pub mod error;
#[doc(hidden)]
pub mod inspect;
#[doc(hidden)]
pub mod report;
#[doc(hidden)]
pub mod servos;
#[doc(hidden)]
pub mod verify;
mod words;

#[doc(hidden)]
pub use error::Error;

/// The URDF of the OP2, embedded: `sesc demo` needs no files.
#[doc(hidden)]
pub const OP2_URDF: &str = include_str!("../robots/op2/op2.urdf");
