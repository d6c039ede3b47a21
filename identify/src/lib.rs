//! From posture logs to a robot's mass parameters, and to what its model misses.
//!
//! Data walks one way:
//!
//! ```text
//! logs → observations → health → lsq → fit → plan → diagnose → fleet
//! ```

#![forbid(unsafe_code)]
// The rooms whose signatures hold matrices are public with the feature `nalgebra` alone; what
// only our tests and studies ask of them is then used by nobody.
#![cfg_attr(not(feature = "nalgebra"), allow(dead_code))]

pub mod compare;
pub mod diagnose;
mod error;
pub mod evaluate;
pub mod feet;
pub mod fit;
pub mod fleet;
pub mod health;
pub mod hide;
pub mod logs;
#[cfg(feature = "nalgebra")]
#[doc(hidden)]
pub mod lsq;
#[cfg(not(feature = "nalgebra"))]
mod lsq;
pub mod next_steps;
#[cfg(feature = "nalgebra")]
#[doc(hidden)]
pub mod observations;
#[cfg(not(feature = "nalgebra"))]
mod observations;
pub mod plan;
pub mod predict;
pub mod robot;
pub mod simulate;
pub mod skeleton;
pub mod stance;
mod svd;
mod threads;
mod watch;
mod words;

pub use error::{Error, ErrorKind};
pub use watch::{Progress, Watch, tell};
pub use words::{Message, Piece, Setting};
