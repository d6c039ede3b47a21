//! The scalars that a generated function can be evaluated with.
//!
//! Written as a serial chain, every function of a posture is a polynomial in the
//! sines and cosines of the joint angles, in prismatic positions, and in the
//! parameters. A commutative ring with `sin` and `cos` is therefore all it takes:
//! no division, no square root, no comparison. What has these operations can
//! stand for a joint angle: `f64`, `f32`, or a whole row of postures
//! ([`Lanes`](crate::Lanes)).

use core::ops::{Add, Mul, Neg, Sub};

use crate::trig;

/// A number, or several numbers side by side, that generated code computes with.
///
/// Each operation rounds once and is never fused with its neighbour, so that
/// one generated body gives the same bits for a scalar and for every lane.
///
/// In a crate that links `std`, `f64` and `f32` have inherent methods of the name
/// `sin_cos`, and the method syntax on a concrete float finds those first. Write
/// `Real::sin_cos(x)` there, or call [`trig::sin_cos`]; inside a function that is
/// generic over `T: Real` there is no such ambiguity.
///
/// ```
/// use sesc_runtime::{Real, trig};
///
/// let x = 0.75_f64;
/// assert_eq!(Real::sin_cos(x), trig::sin_cos(x));
/// ```
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The constant `x`, rounded to the nearest representable number, in every lane.
    fn from_f64(x: f64) -> Self;

    /// Sine and cosine of an angle in radians, in this order.
    ///
    /// Accuracy and domain are those of [`trig`]: outside the domain, at
    /// infinities and at NaN, both are NaN.
    fn sin_cos(self) -> (Self, Self);
}

impl Real for f64 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        trig::sin_cos(self)
    }
}

impl Real for f32 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        trig::sin_cos_f32(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rotation about z by `q` of the point `(x, y)`, as generated code writes it.
    fn rotate<T: Real>(q: T, x: T, y: T) -> [T; 2] {
        let (sin, cos) = q.sin_cos();
        [cos * x - sin * y, sin * x + cos * y]
    }

    #[test]
    fn one_body_serves_both_scalars() {
        let double = rotate(0.3_f64, 0.25, -0.5);
        let single = rotate(0.3_f32, 0.25, -0.5);
        for (double, single) in double.into_iter().zip(single) {
            assert!((double - f64::from(single)).abs() < 1e-7);
        }
    }

    #[test]
    fn constants_are_rounded_to_nearest() {
        assert_eq!(<f64 as Real>::from_f64(0.1).to_bits(), 0.1_f64.to_bits());
        assert_eq!(<f32 as Real>::from_f64(0.1).to_bits(), 0.1_f32.to_bits());
    }
}
