//! The scalars that a generated function can be evaluated with.
//!
//! Written as a serial chain, every function of a posture is a polynomial in the
//! sines and cosines of the joint angles, in prismatic positions, and in the
//! parameters. A commutative ring with `sin` and `cos` is therefore all that the
//! CoM, its Jacobian, gravity moments and regressors take: no division, no square
//! root, no comparison.
//!
//! The effects of a model file reach further. Gains of foot cells weigh their mean,
//!
//! ```text
//! CoP = Σ g_k f_k p_k / Σ g_k f_k
//! ```
//!
//! a cell saturates, or answers with a power of its load; backlash follows the sign
//! of a gravity moment. They take division, [`Real::clamp_unit`], [`Real::larger`]
//! and [`Real::power`].
//! What has all these operations can stand for a joint angle: `f64`, `f32`, or a
//! whole row of postures ([`Lanes`](crate::Lanes)).

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::{power, trig};

/// A number, or several numbers side by side, that generated code computes with.
///
/// With floats and [`Lanes`](crate::Lanes) each operation rounds once and is never
/// fused with its neighbour, so that one generated body gives the same bits for a
/// scalar and for every lane, on every machine. The registers behind
/// [`Simd`](crate::Simd) fuse products with sums where the processor can. Nothing panics: a
/// NaN among the inputs makes the results that depend on it NaN.
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
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The constant `x`, rounded to the nearest representable number, in every lane.
    ///
    /// ```
    /// use sesc_runtime::Real;
    ///
    /// assert_eq!(<f32 as Real>::from_f64(0.1), 0.1_f32);
    /// ```
    fn from_f64(x: f64) -> Self;

    /// `self · factor + term`: by one rounding in registers that fuse the two operations,
    /// by two roundings in floats and [`Lanes`](crate::Lanes), unlike [`f64::mul_add`].
    ///
    /// ```
    /// use sesc_runtime::Real;
    ///
    /// let x = 1.0 + 1.0 / f64::from(1 << 27);
    /// assert_eq!(x.mul_plus(x, -1.0), x * x - 1.0);
    /// assert_ne!(x.mul_plus(x, -1.0), x.mul_add(x, -1.0));
    /// ```
    #[inline(always)]
    fn mul_plus(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }

    /// Sine and cosine of an angle in radians, in this order.
    ///
    /// Accuracy and domain are those of [`trig`]: outside the domain, at
    /// infinities and at NaN, both are NaN.
    ///
    /// ```
    /// use sesc_runtime::{Lanes, Real};
    ///
    /// let (sin, cos) = Lanes([0.0, f64::NAN]).sin_cos();
    /// assert_eq!((sin.0[0], cos.0[0]), (0.0, 1.0));
    /// assert!(sin.0[1].is_nan() && cos.0[1].is_nan());
    /// ```
    fn sin_cos(self) -> (Self, Self);

    /// The nearest number in [-1, 1]; NaN for NaN.
    ///
    /// ```
    /// use sesc_runtime::Real;
    ///
    /// assert_eq!([-3.0, 0.25].map(Real::clamp_unit), [-1.0, 0.25]);
    /// ```
    fn clamp_unit(self) -> Self;

    /// The larger of two numbers, this one where neither is: NaN where this one is.
    ///
    /// ```
    /// use sesc_runtime::Real;
    ///
    /// assert_eq!([-3.0, 0.25].map(|x| Real::larger(x, 0.0)), [0.0, 0.25]);
    /// ```
    fn larger(self, other: Self) -> Self;

    /// This number, not negative, to the power of `exponent`.
    ///
    /// Accuracy and edges are those of [`power`]: NaN for negative numbers.
    ///
    /// ```
    /// use sesc_runtime::Real;
    ///
    /// assert_eq!(Real::power(4.0_f64, 1.5), 8.0);
    /// ```
    fn power(self, exponent: Self) -> Self;
}

macro_rules! real {
    ($scalar:ty, $sin_cos:path, $power:path) => {
        impl Real for $scalar {
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $scalar
            }

            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }

            #[inline(always)]
            fn clamp_unit(self) -> Self {
                self.clamp(-1.0, 1.0)
            }

            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                if self < other { other } else { self }
            }

            #[inline]
            fn power(self, exponent: Self) -> Self {
                $power(self, exponent)
            }
        }
    };
}

real!(f64, trig::sin_cos, power::power);
real!(f32, trig::sin_cos_f32, power::power_f32);

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

    /// An expression as effects write them: a mean weighed by powers, and a sign.
    fn weighed<T: Real>(x: T, y: T) -> [T; 2] {
        let (a, b) = (x.power(T::from_f64(1.5)), y.power(T::from_f64(0.5)));
        let sign = (T::from_f64(1e9) * (x - y)).clamp_unit();
        [(a - b) / (a + b), sign]
    }

    #[test]
    fn effects_serve_both_scalars() {
        assert_eq!(weighed(4.0_f64, 9.0), [5.0 / 11.0, -1.0]);
        assert_eq!(weighed(4.0_f32, 4.0), [6.0 / 10.0, 0.0]);
        // 0/0 and a negative load.
        assert!(weighed(0.0_f64, 0.0)[0].is_nan());
        assert!(weighed(-4.0_f32, 9.0)[0].is_nan());
    }

    #[test]
    fn a_clamp_is_the_nearest_and_keeps_nan() {
        for (x, nearest) in [
            (0.5, 0.5),
            (-0.25, -0.25),
            (1.0, 1.0),
            (7.0, 1.0),
            (-7.0, -1.0),
            (f64::INFINITY, 1.0),
            (f64::NEG_INFINITY, -1.0),
        ] {
            assert_eq!(Real::clamp_unit(x), nearest);
            assert_eq!(Real::clamp_unit(x as f32), nearest as f32);
        }
        assert_eq!((-0.0_f64).clamp_unit().to_bits(), (-0.0_f64).to_bits());
        // The first where neither is larger.
        assert_eq!((-0.0_f64).larger(0.0).to_bits(), (-0.0_f64).to_bits());
        assert_eq!((7.0_f32.larger(8.0), 8.0_f64.larger(7.0)), (8.0, 8.0));
        assert!(f64::NAN.larger(0.0).is_nan() && f32::NAN.larger(0.0).is_nan());
        assert!(f64::NAN.clamp_unit().is_nan() && f32::NAN.clamp_unit().is_nan());
    }

    #[test]
    fn constants_are_rounded_to_nearest() {
        assert_eq!(<f64 as Real>::from_f64(0.1).to_bits(), 0.1_f64.to_bits());
        assert_eq!(<f32 as Real>::from_f64(0.1).to_bits(), 0.1_f32.to_bits());
    }
}
