//! Both feet on one floor: what the joints alone say before any CoP is read.
//!
//! ```text
//! (p_z, R_zy, −R_zx)(φ) = 0        p, R: origin and axes of the other sole's frame, seen from
//!                                  the support's, whose plane z = 0 is the floor
//! ```
//!
//! Three equations per posture, whatever the floor's slope and the masses: height (m), roll and
//! pitch (rad) of the other sole. What an encoder is off by shows in them.

mod closure;
mod other;
#[cfg(test)]
mod tests;

pub(crate) use closure::{Closure, ROWS};
pub use closure::{ClosureFound, Lies, Offset};
pub use other::Feet;
#[doc(hidden)]
pub use other::OtherFoot;
pub(crate) use other::{Places, of_many, of_one_foot, tell_contacts};
