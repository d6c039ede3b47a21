//! One number, whose products are fused with sums, and its sine and cosine.
//!
//! ```text
//! x = k π/2 + r,    r = (x − k P1) − k P2,    |r| ≤ π/4
//! ```
//!
//! `P1` and `P2` are π/2 to twice the digits of the scalar. Both `x` and `k P1` are multiples of
//! half the last digit of `P1`, and their difference is below one: the first step is exact, so
//! that `r` is off by half a unit of 2⁻⁵³ (f32: 2⁻²⁴). Polynomials are those of
//! [`trig`](crate::trig), and quadrants are chosen as there; angles beyond its limits give NaN.
//! The rounding of `r`, of the last sum and of what goes into it adds up to less than 1.4 units.
//!
//! Half the operations of [`trig`](crate::trig), which carries along what is rounded off, so
//! that it is accurate relative to sines near zero.

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;
use crate::trig::{double, single};

macro_rules! fused {
    ($name:ident, $scalar:ty, $set:ident, $fmadd:ident, $get:ident, $sin_cos:ident) => {
        /// A scalar of which only the fused operation is special.
        #[derive(Debug, Clone, Copy)]
        #[repr(transparent)]
        pub(crate) struct $name($scalar);

        fused!(@operator $name Add add +);
        fused!(@operator $name Sub sub -);
        fused!(@operator $name Mul mul *);
        fused!(@operator $name Div div /);

        impl Neg for $name {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Real for $name {
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                Self(x as $scalar)
            }

            #[inline(always)]
            fn mul_plus(self, factor: Self, term: Self) -> Self {
                // SAFETY: only code that is compiled for FMA makes one, see `super`.
                Self(unsafe { $get($fmadd($set(self.0), $set(factor.0), $set(term.0))) })
            }

            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (sin, cos) = $sin_cos(self.0);
                (Self(sin), Self(cos))
            }

            #[inline(always)]
            fn clamp_unit(self) -> Self {
                Self(self.0.clamp_unit())
            }

            #[inline(always)]
            fn larger(self, other: Self) -> Self {
                Self(self.0.larger(other.0))
            }

            #[inline(always)]
            fn power(self, exponent: Self) -> Self {
                Self(self.0.power(exponent.0))
            }
        }
    };
    (@operator $name:ident $trait:ident $method:ident $symbol:tt) => {
        impl $trait for $name {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $symbol other.0)
            }
        }
    };
}

fused! { FusedF64, f64, _mm_set_sd, _mm_fmadd_sd, _mm_cvtsd_f64, sin_cos_f64 }
fused! { FusedF32, f32, _mm_set_ss, _mm_fmadd_ss, _mm_cvtss_f32, sin_cos_f32 }

/// π/2 in two pieces.
const QUARTER: [f64; 2] = [core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17];

/// π/2 in two pieces.
const QUARTER_F32: [f32; 2] = [core::f32::consts::FRAC_PI_2, -4.371_139e-8];

/// Kernels of a scalar and its bits.
macro_rules! sines {
    (
        $name:ident, $scalar:ident, $bits:ty, $fused:ident, $quarter:ident,
        $polynomial:ident of $module:ident
    ) => {
        /// Sine and cosine of `x` radians; for code that is compiled for FMA.
        #[inline(always)]
        pub(super) fn $name(x: $scalar) -> ($scalar, $scalar) {
            use core::$scalar::consts::FRAC_2_PI;
            use $module::{COS, LIMIT_RAD, MAGIC, SIGN, SIN};
            let shifted = $fused(x).mul_plus($fused(FRAC_2_PI), $fused(MAGIC));
            let quadrant = shifted.0.to_bits();
            let k = -(shifted - $fused(MAGIC));
            let r = k.mul_plus($fused($quarter[0]), $fused(x));
            let r = k.mul_plus($fused($quarter[1]), r);
            // From here a NaN spreads to both results.
            let known = x.abs() <= LIMIT_RAD;
            let outside = <$bits>::from(known).wrapping_sub(1);
            let z = $fused(<$scalar>::from_bits((r * r).0.to_bits() | outside));

            let sin = (z * r).mul_plus($polynomial(&SIN, z), r);
            let cos = z.mul_plus($polynomial(&COS, z), $fused(-0.5));
            let cos = z.mul_plus(cos, $fused(1.0));

            // Odd quadrants swap the two; sin < 0 in 2 and 3, cos < 0 in 1 and 2.
            let (sin, cos) = (sin.0.to_bits(), cos.0.to_bits());
            let odd = (0 as $bits).wrapping_sub(quadrant & 1);
            let swap = (sin ^ cos) & odd;
            let sin_sign = (quadrant << (<$bits>::BITS - 2)) & SIGN;
            let cos_sign = (quadrant.wrapping_add(1) << (<$bits>::BITS - 2)) & SIGN;
            (
                <$scalar>::from_bits(sin ^ swap ^ sin_sign),
                <$scalar>::from_bits(cos ^ swap ^ cos_sign),
            )
        }
    };
}

sines! { sin_cos_f64, f64, u64, FusedF64, QUARTER, by_pairs of double }
sines! { sin_cos_f32, f32, u32, FusedF32, QUARTER_F32, in_turn of single }

/// `Σ c_i z^i` by pairs: as many operations as one after the other, half the latency.
#[inline(always)]
fn by_pairs(c: &[f64; 6], z: FusedF64) -> FusedF64 {
    let [low, middle, high] = [
        z.mul_plus(FusedF64(c[1]), FusedF64(c[0])),
        z.mul_plus(FusedF64(c[3]), FusedF64(c[2])),
        z.mul_plus(FusedF64(c[5]), FusedF64(c[4])),
    ];
    let z2 = z * z;
    z2.mul_plus(z2.mul_plus(high, middle), low)
}

/// `Σ c_i z^i`, one term after the other.
#[inline(always)]
fn in_turn(c: &[f32; 3], z: FusedF32) -> FusedF32 {
    let high = z.mul_plus(FusedF32(c[2]), FusedF32(c[1]));
    z.mul_plus(high, FusedF32(c[0]))
}
