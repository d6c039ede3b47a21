//! `sesc`: centre of mass by the statically equivalent serial chain.
//!
//! From a URDF to verified functions of the CoM, and from posture logs to
//! identified parameters. Data walks one way:
//!
//! ```text
//! robot → evaluate → simulate | verify | identify → plan | demo → report
//! ```
//!
//! The command line in [`cli`] parses, calls and prints; nothing else.

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
