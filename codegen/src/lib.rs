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
//! Data walks one way; each stage imports only from those before it:
//!
//! ```text
//! urdf → tree → chain → frames → base → model → expr → program → emit | tape
//! ```

#![deny(unsafe_code)]

pub mod base;
pub mod bounds;
mod builder;
pub mod chain;
pub mod effects;
pub mod emit;
mod error;
pub mod expr;
pub mod frames;
mod functions;
mod model;
mod model_file;
pub mod numeric;
pub mod program;
pub mod snap;
pub mod standard;
pub mod tape;
mod ties;
pub mod tree;
pub mod urdf;

pub use builder::{Builder, write_all_if_changed, write_if_changed};
pub use error::Error;
pub use functions::differentiate_com;
pub use model::{Function, Given, Model};
pub use model_file::{DataUsed, EffectRecord, ModelFile, Parameter, Quantity};
pub use snap::Snapping;
