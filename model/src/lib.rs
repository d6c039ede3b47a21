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
//! expr → formula → program → bounds | wide → tape                            straight-line code
//! interface → functions → measurement → effects → model            what is computed
//! ```
//!
//! What a program calls:
//!
//! * [`urdf::read`] and [`urdf::parse`]: a URDF, with all that is wrong with it.
//! * [`Robot`]: it stands on a link, with its [`base`] parameters and its [`tree::Dof`]s.
//! * [`Model`]: a robot with the parameters and effects of a [`ModelFile`];
//!   [`Model::evaluate`] computes a [`Function`] in one posture.
//! * [`Model::program`]: a [`program`] of a function, [`Model::rounding`] its proven
//!   [`bounds`], and [`tape`] runs it over many postures.
//!
//! ```
//! use sesc_model::tape::{Kernels, Tape, Values};
//! use sesc_model::{Function, Given, Model, Snapping, urdf};
//!
//! let pole = urdf::parse(
//!     r#"<robot name="pole">
//!          <link name="foot"/>
//!          <link name="rod"><inertial><origin xyz="0 0 0.5"/><mass value="2"/></inertial></link>
//!          <joint name="ankle" type="continuous">
//!            <parent link="foot"/><child link="rod"/><axis xyz="0 1 0"/>
//!          </joint>
//!        </robot>"#,
//!     "pole.urdf",
//! )?;
//! let model = Model::new(&pole, "foot", Snapping::default())?;
//! let program = model.program(Function::Com, Given::Positions).unwrap();
//! assert_eq!(program.counts().sin_cos, 1);
//!
//! let (q, r) = ([0.0, 0.3], model.params());
//! let mut com = [0.0; 6];
//! let arguments = [Values::PerPosture(&q), Values::Shared(&r)];
//! Tape::new(&program).run(&arguments, 2, &mut com, Kernels::LIBM);
//! assert_eq!(com, [0.0, 0.0, 0.5, 0.5 * 0.3_f64.sin(), 0.0, 0.5 * 0.3_f64.cos()]);
//! # Ok::<(), sesc_model::Error>(())
//! ```
//!
//! What stands beside these serves `sesc-codegen`, `sesc-identify` and the command line;
//! it stays out of the documentation and may change in any release.

#![deny(unsafe_code)]

pub mod base;
pub mod bounds;
#[doc(hidden)]
pub mod chain;
#[doc(hidden)]
pub mod effects;
mod error;
#[doc(hidden)]
pub mod expr;
#[doc(hidden)]
pub mod files;
#[doc(hidden)]
pub mod formula;
#[doc(hidden)]
pub mod frames;
mod functions;
#[doc(hidden)]
pub mod hash;
#[doc(hidden)]
pub mod inertia;
mod interface;
mod measurement;
mod model;
#[doc(hidden)]
pub mod names;
#[doc(hidden)]
pub mod numeric;
pub mod program;
mod robot;
mod snap;
#[doc(hidden)]
pub mod spelling;
mod stamp;
#[doc(hidden)]
pub mod standard;
pub mod tape;
#[doc(hidden)]
pub mod text;
pub mod tree;
pub mod urdf;
#[doc(hidden)]
pub mod wide;

pub use error::{Error, ErrorKind};
#[doc(hidden)]
pub use functions::{motion_parts, motion_rows};
pub use interface::{Extent, Function, Given, Interface};
pub use model::{
    DataUsed, EffectRecord, Information, Model, ModelFile, MotionCounted, Parameter, Quantity,
};
#[doc(hidden)]
pub use model::{sensor_reading, tilted_com, tilted_cop};
pub use robot::Robot;
pub use snap::Snapping;
