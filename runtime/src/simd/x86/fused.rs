//! One number, whose products are fused with sums.

use core::arch::x86_64::*;
use core::ops::{Add, Div, Mul, Neg, Sub};

use super::sines;
use crate::real::Real;

macro_rules! fused {
    ($name:ident, $scalar:ty, $set:ident, $fmadd:ident, $get:ident, $sin_cos:ident) => {
        /// A scalar of which only the fused operation is special.
        #[derive(Debug, Clone, Copy)]
        #[repr(transparent)]
        pub struct $name($scalar);

        impl $name {
            #[inline(always)]
            pub(super) fn of(x: $scalar) -> Self {
                Self(x)
            }

            #[inline(always)]
            pub(super) fn number(self) -> $scalar {
                self.0
            }
        }

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
                let (sin, cos) = sines::$sin_cos(self.0);
                (Self(sin), Self(cos))
            }

            #[inline(always)]
            fn clamp_unit(self) -> Self {
                Self(self.0.clamp_unit())
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

fused!(
    FusedF64,
    f64,
    _mm_set_sd,
    _mm_fmadd_sd,
    _mm_cvtsd_f64,
    sin_cos_f64
);
fused!(
    FusedF32,
    f32,
    _mm_set_ss,
    _mm_fmadd_ss,
    _mm_cvtss_f32,
    sin_cos_f32
);
