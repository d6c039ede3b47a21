//! The two plain scalars, and what an estimator and the registers ask of them.

use crate::lanes::{F32x16, F64x8};
use crate::real::Real;
use crate::simd::{Block, sealed::Dispatch};

/// A plain number, `f64` or `f32` and no other: with order, in blocks of a cache line.
///
/// The constants bound what an [`Estimator`](crate::fit::Estimator) in this scalar takes
/// in. They leave enough of the exponent that no product inside overflows (see
/// [`fit`](crate::fit)).
///
/// ```
/// use sesc_runtime::Scalar;
///
/// /// Largest distance of a column from zero.
/// fn largest<T: Scalar>(column: &[T]) -> T {
///     column.iter().fold(T::ZERO, |most, x| if x.abs() > most { x.abs() } else { most })
/// }
///
/// assert_eq!(largest(&[0.1, -0.3]), 0.3);
/// assert_eq!(f64::LIMIT, 2_f64.powi(100));
/// ```
pub trait Scalar: Real + Default + PartialOrd + Dispatch {
    /// A number of each posture of a block.
    type Block: Block<Scalar = Self>;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// +∞: the variance of a parameter that no reading has shown.
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
    /// A column is observable when more than this share of it, as a length, is
    /// independent of the columns before it: 2⁻³⁶ ≈ 1.5e-11 and 2⁻¹⁷ ≈ 7.6e-6.
    const INDEPENDENT: Self;
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

macro_rules! scalar {
    (
        $t:ident in $block:ident, limit: $limit:expr, least: $least:expr, most: $most:expr,
        independent: $independent:expr, light: $light:expr
    ) => {
        impl Scalar for $t {
            type Block = $block;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $t::INFINITY;
            const LIMIT: Self = power($limit) as $t;
            const LEAST: Self = power($least) as $t;
            const MOST: Self = power($most) as $t;
            const INDEPENDENT: Self = power($independent) as $t;
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

scalar!(f64 in F64x8, limit: 100, least: -200, most: 200 + 54, independent: -36, light: -100);
scalar!(f32 in F32x16, limit: 20, least: -40, most: 40 + 25, independent: -17, light: -20);

/// 2ⁿ for a normal number.
const fn power(n: i64) -> f64 {
    f64::from_bits(((1023 + n) as u64) << 52)
}
