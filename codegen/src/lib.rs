//! From a URDF to unrolled centre-of-mass code.
//!
//! ```text
//! CoM(q) = r_0 + Σ B_i(q) r_i
//! ```
//!
//! A humanoid's CoM is linear in constants r that CAD or data provide; the
//! orientations `B_i` come from the kinematics alone. This crate expands them
//! symbolically and writes branch-free, allocation-free Rust. It is made to be
//! called from a controller's `build.rs`:
//!
//! ```no_run
//! # fn main() -> Result<(), sesc_codegen::Error> {
//! sesc_codegen::Builder::new("op2.urdf").support("r_sole").emit()?;
//! # Ok(()) }
//! ```
//!
//! The model crate (`sesc-model`) reads the URDF and makes straight-line programs of
//! it; here they become source text.

#![deny(unsafe_code)]

mod builder;
#[doc(hidden)]
pub mod emit;
mod error;
#[doc(hidden)]
pub mod facts;
mod routines;
mod seen;
#[doc(hidden)]
pub mod sources;

pub use builder::Builder;
#[cfg(feature = "c99")]
pub use emit::c::{Scalar, Scale, Servo, Servos, Setting, layout::Layout};
pub use error::{Error, ErrorKind};
pub use sesc_model::Snapping;
