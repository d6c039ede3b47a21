//! From posture logs to a robot's mass parameters, and to what its model misses.
//!
//! Data walks one way:
//!
//! ```text
//! logs → observations → health → lsq → fit → plan → diagnose → fleet
//! ```
//!
//! Each call takes a `Request` and a [`Watch`], which shows progress and may stop it, and
//! returns all that is found:
//!
//! * [`robot::Robot`]: a URDF; [`logs::LogSource`]: a posture log by its path or from memory;
//!   [`robot::Stance`]: a robot on its support link.
//! * [`fit::fit`]: the base parameters with their uncertainty; [`fit::gather()`]: a part of a
//!   fit, to be joined elsewhere.
//! * [`diagnose::diagnose`]: what the model misses, and what to do about it.
//! * [`plan::plan`]: postures that tell most; [`simulate::simulate`]: a log of a virtual robot;
//!   [`predict::predict`]: CoM and CoP of logged postures; [`evaluate`]: of many postures.
//! * [`compare::compare`]: two model files; [`health::of_log`]: what is wrong with a log;
//!   [`fleet::run`]: many robots and days.
//!
//! What else is reachable serves the command line, the bindings for Python and the project's
//! tests; it stays out of the documentation and may change in any release.

#![forbid(unsafe_code)]

pub mod compare;
pub mod diagnose;
mod error;
pub mod evaluate;
pub mod feet;
pub mod files;
pub mod fit;
pub mod fleet;
pub mod health;
pub mod logs;
#[doc(hidden)]
pub mod lsq;
#[doc(hidden)]
pub mod observations;
pub mod plan;
mod poses;
pub mod predict;
pub mod robot;
pub mod simulate;
#[doc(hidden)]
pub mod skeleton;
mod svd;
#[cfg(test)]
mod tests;
#[doc(hidden)]
pub mod threads;
mod tolerances;
mod watch;
mod words;

pub use error::{Error, ErrorKind};
#[doc(hidden)]
pub use watch::tell;
pub use watch::{Progress, Watch};
pub use words::{Functions, Message, NextStep, Piece, Setting};
