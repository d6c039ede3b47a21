//! The run-time part of generated centre-of-mass code: what a controller ships.
//!
//! A statically equivalent serial chain writes the centre of mass of a robot as
//!
//! ```text
//! CoM(q) = r_0 + Σ B_i(q) r_i
//! ```
//!
//! so its code consists of sums, products, and one sine and cosine per joint; what
//! a sensor makes of it may take quotients and powers too.
//! This crate supplies these for one posture or for many at once:
//!
//! * [`Sesc`] and [`SescFromSinCos`]: the functions that every generated unit
//!   struct has. A controller for any robot takes `R: Sesc`, joint positions as
//!   [`Posture<R>`](Posture) and parameters as [`Params<R>`](Params), and no array length;
//! * [`Real`]: the scalars that these functions accept: `f64` and `f32` ([`Scalar`]), and
//!   [`Lanes`] of either, one posture per lane;
//! * [`Many`], [`Batch`] and [`Single`]: the same functions on the widest registers
//!   that [`Simd`] finds, of any number of postures, of blocks of them and of one;
//! * [`trig`]: the sine and cosine behind [`Real::sin_cos`], free of branches
//!   and tables, the same to the last bit on every machine and in every lane;
//! * [`power`]: the powers behind [`Real::power`], by the same rules;
//! * [`fit`]: the parameters themselves, estimated posture by posture in fixed
//!   memory.
//!
//! No allocation, no dependency, no panic: it runs inside a control loop and on
//! a microcontroller. With the feature `std`, [`Simd`] asks the processor which
//! instructions it has; without, it is what the crate is compiled for.
//!
//! ```
//! use sesc_runtime::{F64x8, Lanes, Real};
//!
//! // A link of 0.4 m, leaning by q: how far forward is its end?
//! fn reach<T: Real>(q: T) -> T {
//!     let (sin, _cos) = q.sin_cos();
//!     T::from_f64(0.4) * sin
//! }
//!
//! let one = reach(0.5_f64);
//! let many: F64x8 = reach(Lanes([0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2]));
//! assert_eq!(one.to_bits(), many.0[0].to_bits());
//! ```

#![no_std]
#![deny(unsafe_code)]

#[cfg(any(test, feature = "std"))]
extern crate std;

#[doc(hidden)]
pub mod __private;
mod dim;
pub mod fit;
mod from_sin_cos;
mod lanes;
mod model;
pub mod power;
mod real;
mod scalar;
pub(crate) mod simd;
pub mod trig;

pub use dim::{Const, Dim};
pub use from_sin_cos::SescFromSinCos;
pub use lanes::{F32x16, F64x8, Lanes, pack, unpack};
pub use model::{CorrectCop, FullParams, Params, Posture, Sesc};
pub use real::Real;
pub use scalar::{Block, Scalar, Simd};
pub use simd::{Batch, Many, Single, UnequalLengths};
