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
pub mod diagnose;
pub mod error;
pub mod evaluate;
pub mod identify;
pub mod inspect;
pub mod output;
pub mod plan;
pub mod posture_log;
pub mod regenerate;
pub mod report;
pub mod robot;
pub mod simulate;
pub mod verify;

pub use error::Error;
