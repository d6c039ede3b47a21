//! Generated functions on the vector registers of this machine.
//!
//! Generated code is generic over [`Real`], and registers are one kind of it. [`Simd`] names
//! a set of instructions, [`Many`] evaluates any number of postures with it, a row each,
//! [`Batch`] blocks of postures, one posture per lane, and [`Single`] one posture, its sines
//! and cosines side by side.
//!
//! | set      | lanes (f64, f32) | a·b + c | sine and cosine                      |
//! |----------|------------------|---------|--------------------------------------|
//! | portable | as compiled for  | 2 roundings | [`trig`](crate::trig)            |
//! | AVX2     | 4, 8             | fused   | polynomials of [`trig`](crate::trig), fused: see `fused` |
//! | AVX-512  | 8, 16            | fused   | table of 16 (32) angles, see `avx512` |
//!
//! The sets differ in the last bits: each result is within the bound that the head of
//! the generated file states. The portable one gives the same bits on every machine.

mod batch;
mod many;
mod moments;
pub(crate) mod normal;
mod reflect;
mod single;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::lanes::{F32x16, F64x8, Lanes, pack};
use crate::scalar::{Block, Scalar, Set, Simd, sealed};
use crate::trig;
#[cfg(target_arch = "x86_64")]
use x86::{avx2, avx512};

pub use batch::Batch;
pub use many::{Many, UnequalLengths};
pub use single::Single;

impl Simd {
    /// What every machine has: the same bits everywhere.
    ///
    /// ```
    /// use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// use sesc_runtime::{Sesc, Simd, Single};
    ///
    /// let q = [0.2, -0.4];
    /// let com = TwoLinkFoot::com_single(Simd::PORTABLE, &q, &CAD_PARAMS);
    /// assert_eq!(com.map(f64::to_bits), TwoLinkFoot::com(&q, &CAD_PARAMS).map(f64::to_bits));
    /// ```
    pub const PORTABLE: Simd = Simd(Set::Portable);

    /// The widest set of this machine: asked of the processor with the feature `std`, of
    /// the compiler's target without. Ask once and keep the answer.
    ///
    /// ```
    /// use sesc_runtime::Simd;
    ///
    /// assert!(Simd::available().last() == Some(Simd::best()));
    /// ```
    pub fn best() -> Simd {
        let mut best = Simd::PORTABLE;
        for set in Simd::available() {
            best = set;
        }
        best
    }

    /// Every set of this machine, the widest last.
    ///
    /// ```
    /// use sesc_runtime::Simd;
    ///
    /// assert!(Simd::available().next() == Some(Simd::PORTABLE));
    /// ```
    pub fn available() -> impl Iterator<Item = Simd> {
        let sets = [
            (Set::Portable, true),
            #[cfg(target_arch = "x86_64")]
            (Set::Avx2, x86::has_avx2()),
            #[cfg(target_arch = "x86_64")]
            (Set::Avx512, x86::has_avx512() && !x86::prefers_short()),
            #[cfg(target_arch = "x86_64")]
            (Set::Avx512Short, x86::has_avx512() && x86::prefers_short()),
        ];
        sets.into_iter()
            .filter_map(|(set, there)| there.then_some(Simd(set)))
    }

    /// Sines and cosines of angles, rad, within 1.7 units of 2⁻⁵³ (f32: 2⁻²⁴); NaN
    /// beyond the limits of [`trig`].
    ///
    /// ```
    /// use sesc_runtime::Simd;
    ///
    /// let (mut sin, mut cos) = ([0.0_f64; 3], [0.0; 3]);
    /// Simd::best().sin_cos(&[0.0, 0.5, 1.0], &mut sin, &mut cos);
    /// assert!((sin[1] - 0.4794255386042030).abs() < 2e-16 && cos[0] == 1.0);
    /// ```
    pub fn sin_cos<S: Scalar, const N: usize>(
        self,
        angles: &[S; N],
        sin: &mut [S; N],
        cos: &mut [S; N],
    ) {
        S::run(self, Sines { angles, sin, cos });
    }

    /// Its name for a report or a log.
    ///
    /// ```
    /// use sesc_runtime::Simd;
    ///
    /// assert_eq!(Simd::PORTABLE.name(), "portable");
    /// ```
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 | Set::Avx512Short => "AVX-512",
        }
    }
}

/// Sines and cosines side by side.
struct Sines<'a, S, const N: usize> {
    angles: &'a [S; N],
    sin: &'a mut [S; N],
    cos: &'a mut [S; N],
}

impl<S: Scalar, const N: usize> sealed::Task<S> for Sines<'_, S, N> {
    #[inline(always)]
    fn run<M: sealed::Machine<S>>(self) {
        M::sin_cos(self.angles, self.sin, self.cos);
    }
}

/// The set of every processor, without special instructions.
struct Portable;

macro_rules! portable {
    ($scalar:ty, $block:ty, $sin_cos:path) => {
        impl Block for $block {
            type Scalar = $scalar;

            #[inline(always)]
            fn lanes(&self) -> &[$scalar] {
                &self.0
            }

            #[inline(always)]
            fn lanes_mut(&mut self) -> &mut [$scalar] {
                &mut self.0
            }
        }

        impl sealed::Machine<$scalar> for Portable {
            type Vector = $block;
            const PARTS: usize = 1;
            type One = $scalar;
            type Rows = Lanes<$scalar, { sealed::ROWS }>;

            #[inline(always)]
            fn splat(x: $scalar) -> $block {
                <$block>::splat(x)
            }

            #[inline(always)]
            fn load<const N: usize>(blocks: &[$block; N], _: usize) -> [$block; N] {
                *blocks
            }

            #[inline(always)]
            fn columns<const N: usize>(rows: &[[$scalar; N]], _: usize) -> [$block; N] {
                match rows.first_chunk() {
                    Some(rows) => pack(rows),
                    None => [<$block>::splat(0.0); N],
                }
            }

            #[inline(always)]
            fn store(vectors: &[$block], blocks: &mut [$block], _: usize) {
                let len = vectors.len().min(blocks.len());
                blocks[..len].copy_from_slice(&vectors[..len]);
            }

            #[inline(always)]
            fn place<'a, const N: usize, const M: usize>(
                blocks: &'a mut [[$block; N]; M],
                _: &'a mut [[$block; N]; M],
            ) -> &'a mut [[$block; N]; M] {
                blocks
            }

            #[inline(always)]
            fn ones<const N: usize>(scalars: &[$scalar; N]) -> &[$scalar; N] {
                scalars
            }

            #[inline(always)]
            fn scalars(ones: &[$scalar]) -> &[$scalar] {
                ones
            }

            #[inline(always)]
            fn every_row(x: $scalar) -> Self::Rows {
                Lanes::splat(x)
            }

            #[inline(always)]
            fn rows(numbers: [$scalar; sealed::ROWS]) -> Self::Rows {
                Lanes(numbers)
            }

            #[inline(always)]
            fn numbers(rows: Self::Rows) -> [$scalar; sealed::ROWS] {
                rows.0
            }

            #[inline(always)]
            fn sin_cos<const N: usize>(
                angles: &[$scalar; N],
                sin: &mut [$scalar; N],
                cos: &mut [$scalar; N],
            ) {
                for ((x, sin), cos) in angles.iter().zip(sin).zip(cos) {
                    (*sin, *cos) = $sin_cos(*x);
                }
            }
        }

        impl sealed::Dispatch for $scalar {
            #[inline]
            #[allow(unsafe_code)]
            fn run(set: Simd, task: impl sealed::Task<Self>) {
                match set.0 {
                    Set::Portable => task.run::<Portable>(),
                    #[cfg(target_arch = "x86_64")]
                    // SAFETY: only `available` makes one, after it has seen the
                    // processor's features.
                    Set::Avx2 => unsafe { avx2::run::<Self, avx2::Avx2>(task) },
                    #[cfg(target_arch = "x86_64")]
                    // SAFETY: likewise.
                    Set::Avx512 | Set::Avx512Short => unsafe {
                        avx512::run::<Self, avx512::Avx512>(task)
                    },
                }
            }

            #[inline]
            #[allow(unsafe_code)]
            fn run_rows(set: Simd, task: impl sealed::Task<Self>) {
                match set.0 {
                    #[cfg(target_arch = "x86_64")]
                    // SAFETY: likewise.
                    Set::Avx512Short => unsafe { avx512::run::<Self, avx512::Avx512Short>(task) },
                    _ => Self::run(set, task),
                }
            }
        }
    };
}

portable!(f64, F64x8, trig::sin_cos);
portable!(f32, F32x16, trig::sin_cos_f32);
