//! What the estimator asks of a number beyond sums and products.

use core::ops::Div;

use crate::real::Real;

/// A scalar with division and order: `f64` and `f32`, and no other.
///
/// The constants bound what an estimator in this scalar takes in. They leave
/// enough of the exponent that no product inside overflows (see
/// [`fit`](crate::fit)).
pub trait Scalar: Real + Div<Output = Self> + PartialOrd + sealed::Sealed {
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// +∞: the variance of what no reading has shown.
    const INFINITY: Self;
    /// Largest entry of a row, and largest distance of a reading from the nominal
    /// parameters' prediction, in standard deviations: 2¹⁰⁰ and 2²⁰.
    const LIMIT: Self;
    /// Least information that is kept, (standard deviations per unit of the
    /// parameter)²: 2⁻²⁰⁰ and 2⁻⁴⁰.
    const LEAST: Self;
    /// Most information that a column can hold: `LIMIT²`, times the number of equal
    /// terms at which a sum stops growing.
    const MOST: Self;
    /// A column is seen when more than this share of it, as a length, is
    /// independent of the columns before it: 2⁻³⁶ ≈ 1.5e-11 and 2⁻¹⁷ ≈ 7.6e-6.
    const UNSEEN: Self;
    /// Below this weight a row is rewritten with a larger one.
    #[doc(hidden)]
    const LIGHT: Self;

    /// |x|.
    fn abs(self) -> Self;

    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;

    /// The same number in double precision.
    fn to_f64(self) -> f64;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f64 {}
    impl Sealed for f32 {}
}

macro_rules! scalar {
    ($t:ident, limit: $limit:expr, least: $least:expr, most: $most:expr, unseen: $unseen:expr, light: $light:expr) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $t::INFINITY;
            const LIMIT: Self = power($limit) as $t;
            const LEAST: Self = power($least) as $t;
            const MOST: Self = power($most) as $t;
            const UNSEEN: Self = power($unseen) as $t;
            const LIGHT: Self = power($light) as $t;

            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }

            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }
    };
}

scalar!(f64, limit: 100, least: -200, most: 200 + 54, unseen: -36, light: -100);
scalar!(f32, limit: 20, least: -40, most: 40 + 25, unseen: -17, light: -20);

/// 2ⁿ for a normal number.
const fn power(n: i64) -> f64 {
    f64::from_bits(((1023 + n) as u64) << 52)
}
