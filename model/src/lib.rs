//! From a URDF to the functions of its centre of mass as straight-line programs.
//!
//! ```text
//! CoM(q) = r_0 + Σ B_i(q) r_i
//! ```
//!
//! The CoM is linear in constants r that CAD or data provide; the orientations
//! `B_i` come from the kinematics alone. This crate re-roots the tree at the
//! support link, finds the base parameters (what data can determine), writes the
//! functions of the CoM and of its measurement as hash-consed expressions, proves
//! how exact they are, and evaluates them on a tape.
//!
//! Data walks one way; each stage imports only from those before it:
//!
//! ```text
//! urdf → tree → chain → frames → base → robot → inertia            kinematics: no file, no effect
//! expr → program → bounds | wide → tape                            straight-line code
//! interface → functions → measurement → effects → model            what is computed
//! ```

#![deny(unsafe_code)]

pub mod base;
pub mod bounds;
pub mod chain;
pub mod effects;
mod error;
pub mod expr;
#[doc(hidden)]
pub mod files;
pub mod frames;
mod functions;
#[doc(hidden)]
pub mod hash;
pub mod inertia;
mod interface;
mod measurement;
mod model;
pub mod names;
pub mod numeric;
pub mod program;
mod robot;
pub mod snap;
#[doc(hidden)]
pub mod spelling;
mod stamp;
pub mod standard;
pub mod tape;
#[doc(hidden)]
pub mod text;
pub mod tree;
pub mod urdf;
pub mod wide;

pub use error::Error;
pub use functions::{differentiate_com, motion_parts, motion_rows};
pub use interface::{Extent, Function, Given, Interface};
pub use model::{
    DataUsed, EffectRecord, Information, Model, ModelFile, Parameter, Quantity, sensor_reading,
    tilted_com, tilted_cop,
};
pub use robot::Robot;
pub use snap::Snapping;
