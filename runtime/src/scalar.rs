//! The two plain scalars, and what an estimator and the registers ask of them.

use crate::lanes::{F32x16, F64x8};
use crate::real::Real;

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
pub trait Scalar: Real + Default + PartialOrd + sealed::Dispatch {
    /// A number of each posture of a block.
    type Block: Block<Scalar = Self>;
    /// 0.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(<f64 as Scalar>::ZERO, 0.0);
    /// ```
    const ZERO: Self;
    /// 1.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(<f32 as Scalar>::ONE, 1.0);
    /// ```
    const ONE: Self;
    /// +∞: the variance of a parameter that no reading has shown.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// use sesc_runtime::fit::Estimator;
    ///
    /// let nothing_shown = Estimator::<f64, 1>::with_nominal(&[0.1])?;
    /// assert_eq!(nothing_shown.variance(0), Some(<f64 as Scalar>::INFINITY));
    /// # Ok::<(), sesc_runtime::fit::Error>(())
    /// ```
    const INFINITY: Self;
    /// Largest entry of a row, and largest distance of a reading from the nominal
    /// parameters' prediction, in standard deviations: 2¹⁰⁰ and 2²⁰.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(<f32 as Scalar>::LIMIT, 1_048_576.0);
    /// ```
    const LIMIT: Self;
    /// Least information that is kept, (standard deviations per unit of the
    /// parameter)²: 2⁻²⁰⁰ and 2⁻⁴⁰.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(f64::LEAST * f64::LIMIT * f64::LIMIT, 1.0);
    /// ```
    const LEAST: Self;
    /// Most information that a column can hold: `LIMIT²`, times the number of equal
    /// terms at which a sum stops growing.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert!(f64::MOST > f64::LIMIT * f64::LIMIT && f64::MOST.is_finite());
    /// ```
    const MOST: Self;
    /// A column is observable when more than this share of it, as a length, is
    /// independent of the columns before it: 2⁻³⁶ ≈ 1.5e-11 and 2⁻¹⁷ ≈ 7.6e-6.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert!(f64::INDEPENDENT < 1e-10 && f32::INDEPENDENT < 1e-5);
    /// ```
    const INDEPENDENT: Self;
    /// Below this weight a row is rewritten with a larger one.
    #[doc(hidden)]
    const LIGHT: Self;

    /// |x|.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(Scalar::abs(-0.25_f32), 0.25);
    /// ```
    fn abs(self) -> Self;

    /// Neither NaN nor infinite.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert!(Scalar::is_finite(0.5_f64) && !Scalar::is_finite(f64::NAN));
    /// ```
    fn is_finite(self) -> bool;

    /// The same number in double precision.
    ///
    /// ```
    /// # use sesc_runtime::Scalar;
    /// assert_eq!(Scalar::to_f64(0.1_f32), f64::from(0.1_f32));
    /// ```
    fn to_f64(self) -> f64;

    /// √x of a normal number, within one unit in the last place: half the exponent, then
    /// Newton's method. The generated C takes the same steps.
    #[doc(hidden)]
    fn root(self) -> Self;
}

/// A number of each of several postures, together a cache line: [`F64x8`] or [`F32x16`].
///
/// ```
/// use sesc_runtime::{Batch, Block, Params, Posture, Sesc, Simd};
///
/// /// Centres of mass, metres, in either scalar.
/// fn centres<R: Sesc, B: Block>(q: &[Posture<R, B>], r: &Params<R, B::Scalar>, com: &mut [[B; 3]]) {
///     R::com_batch(Simd::best(), q, r, com);
/// }
/// ```
pub trait Block: Real {
    /// Its numbers.
    type Scalar: Scalar<Block = Self>;

    /// The numbers of its postures.
    #[doc(hidden)]
    fn lanes(&self) -> &[Self::Scalar];

    /// The same, to be written.
    #[doc(hidden)]
    fn lanes_mut(&mut self) -> &mut [Self::Scalar];
}

pub(crate) mod sealed {
    use super::{Scalar, Simd};
    use crate::real::Real;

    /// Rows side by side: three, and a lane to spare.
    pub(crate) const ROWS: usize = 4;

    /// Registers of one set, and how they meet memory.
    pub trait Machine<S: Scalar> {
        /// Postures side by side.
        type Vector: Real;
        /// Registers in a block.
        const PARTS: usize;
        /// One number, its products fused with its sums.
        type One: Real;
        /// Rows of one posture side by side, fused likewise.
        type Rows: Real;

        /// The same number in every lane.
        fn splat(x: S) -> Self::Vector;

        /// A register of each block.
        fn load<const N: usize>(blocks: &[S::Block; N], part: usize) -> [Self::Vector; N];

        /// The same from postures as rows, a block of them.
        fn columns<const N: usize>(rows: &[[S; N]], part: usize) -> [Self::Vector; N];

        /// The inverse of `load`; of the longer slice the rest is left out.
        fn store(vectors: &[Self::Vector], blocks: &mut [S::Block], part: usize);

        /// Where to write registers for the blocks: they themselves, where one register
        /// fills a block, else `room`, from where they are stored then.
        fn place<'a, const N: usize, const M: usize>(
            blocks: &'a mut [[S::Block; N]; M],
            room: &'a mut [[Self::Vector; N]; M],
        ) -> &'a mut [[Self::Vector; N]; M];

        /// The same numbers as scalars of the set.
        fn ones<const N: usize>(scalars: &[S; N]) -> &[Self::One; N];

        /// The inverse of `ones`.
        fn scalars(ones: &[Self::One]) -> &[S];

        /// The same number in every row.
        fn every_row(x: S) -> Self::Rows;

        /// A number of each row.
        fn rows(numbers: [S; ROWS]) -> Self::Rows;

        /// The inverse of `rows`.
        fn numbers(rows: Self::Rows) -> [S; ROWS];

        fn sin_cos<const N: usize>(angles: &[S; N], sin: &mut [S; N], cos: &mut [S; N]);
    }

    /// What is to be done, on any set.
    pub trait Task<S: Scalar> {
        fn run<M: Machine<S>>(self);
    }

    /// Run a task, compiled for a set.
    pub trait Dispatch: Sized {
        fn run(set: Simd, task: impl Task<Self>)
        where
            Self: Scalar;

        /// Run one of [`Machine::Rows`], whose width may be chosen by the processor.
        fn run_rows(set: Simd, task: impl Task<Self>)
        where
            Self: Scalar;
    }
}

/// A set of instructions that this machine has.
///
/// ```
/// use sesc_runtime::Simd;
///
/// let best = Simd::best();
/// assert!(Simd::available().any(|set| set == best));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Simd(pub(crate) Set);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// With the rows of one posture in registers of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512Short,
}

macro_rules! scalar {
    (
        $t:ident in $block:ident, limit: $limit:expr, least: $least:expr, most: $most:expr,
        independent: $independent:expr, light: $light:expr,
        root: $half:expr, $steps:expr
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

            #[inline]
            fn root(self) -> Self {
                let mut root = $t::from_bits((self.to_bits() >> 1) + $half);
                for _ in 0..$steps {
                    root = 0.5 * (root + self / root);
                }
                root
            }
        }
    };
}

scalar!(f64 in F64x8, limit: 100, least: -200, most: 200 + 54, independent: -36, light: -100,
    root: 0x1ff7_a3be_a91d_9b1b, 4);
scalar!(f32 in F32x16, limit: 20, least: -40, most: 40 + 25, independent: -17, light: -20,
    root: 0x1fbd_1df5, 3);

/// 2ⁿ for a normal number.
const fn power(n: i64) -> f64 {
    f64::from_bits(((1023 + n) as u64) << 52)
}
