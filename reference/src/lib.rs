//! Centre of mass link by link, the slow and literal way: the yardstick for
//! everything that is generated.
//!
//! ```text
//! CoM(q) = Σ_l m_l T_l(q) c_l / M          Eq. (3) of the seed paper
//! ```
//!
//! `T_l` is the homogeneous transform of link `l` in the support frame,
//! `m_l` its mass and `c_l` its centre of mass in its own frame. The CoM is summed
//! link by link: nothing is re-rooted, folded or regrouped. Derivatives are
//! differences of it, in which a joint moves what it carries as one body; tests
//! compare them with differences of whole postures. Nothing is shared with the
//! code that is checked: this crate reads the URDF by urdf-rs and multiplies matrices.
//!
//! * [`Robot`]: a URDF, read leniently and exactly.
//! * [`Reference`]: CoM, link poses, Jacobian and gravity moments by
//!   differences, standard regressor columns, with one link held fixed.
//! * [`Motion`]: what moves with the joints, and the zero-moment point, by Newton and Euler.
//! * [`numeric_rank`]: how many parameters a set of postures can determine.
//! * [`World`]: a virtual robot that is bent on purpose; [`Track`]: the postures
//!   of a log, with which it is read.
//!
//! Lengths are metres, masses kilograms, angles radians.
//!
//! The crate is published because `sesc verify` compares with it. Its items serve the
//! project's own commands and tests: they stay out of the documentation and may change
//! in any release.
//!
//! ```
//! use sesc_reference::{Reference, Robot};
//!
//! let robot = Robot::from_urdf(
//!     r#"<robot name="pendulum">
//!          <link name="stand"/>
//!          <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/></inertial></link>
//!          <joint name="pivot" type="continuous">
//!            <parent link="stand"/><child link="rod"/>
//!            <origin xyz="0 0 1"/><axis xyz="0 1 0"/>
//!          </joint>
//!        </robot>"#,
//! )?;
//! let reference = Reference::new(&robot, "stand")?;
//! let com = reference.com(&[0.3]);
//! assert!((com.x + 0.5 * 0.3_f64.sin()).abs() < 1e-15);
//! assert!((com.z - (1.0 - 0.5 * 0.3_f64.cos())).abs() < 1e-15);
//! # Ok::<(), sesc_reference::Error>(())
//! ```

mod com;
mod complete;
mod dynamics;
mod error;
mod jacobian;
mod joint;
mod nearby;
mod quaternion;
mod regressor;
mod robot;
mod tree;
mod urdf;
mod world;
mod xml;

#[doc(hidden)]
pub use com::Reference;
#[doc(hidden)]
pub use dynamics::Motion;
#[doc(hidden)]
pub use error::{Error, ErrorKind};
#[doc(hidden)]
pub use joint::{Joint, JointKind, Link, Mimic, Pose};
#[doc(hidden)]
pub use regressor::numeric_rank;
#[doc(hidden)]
pub use robot::Robot;
#[doc(hidden)]
pub use tree::Coordinate;
#[doc(hidden)]
pub use world::{GRAVITY, Place, Reading, Track, World};
