//! The widest registers of the processor, with the bits of the narrowest.
//!
//! A loop that is compiled for every set of instructions and chosen at run time: none of them
//! fuses a product with a sum, so that all give the same bits.

pub(crate) mod tiles;

/// Loops over plain numbers. What `run` calls is compiled with it where it is
/// `#[inline(always)]`.
pub trait Loops {
    /// Do them; `#[inline(always)]`.
    fn run(self);
}

/// Run loops in the widest registers that this processor has.
///
/// ```
/// use sesc_model::wide::{Loops, widest};
///
/// struct Double<'a>(&'a mut [f64]);
/// impl Loops for Double<'_> {
///     #[inline(always)]
///     fn run(self) {
///         for x in self.0 {
///             *x *= 2.0;
///         }
///     }
/// }
/// let mut numbers = [0.5, 1.5];
/// widest(Double(&mut numbers));
/// assert_eq!(numbers, [1.0, 3.0]);
/// ```
#[inline]
#[allow(unsafe_code)]
pub fn widest(loops: impl Loops) {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
        fn avx512(loops: impl Loops) {
            loops.run();
        }
        #[target_feature(enable = "avx2")]
        fn avx2(loops: impl Loops) {
            loops.run();
        }
        use std::arch::is_x86_feature_detected as has;
        // The compiler takes AVX2, FMA and F16C as parts of AVX-512; a virtual machine may hide
        // them one by one.
        let narrower = has!("avx2") && has!("fma") && has!("f16c");
        if narrower && has!("avx512f") && has!("avx512vl") && has!("avx512dq") {
            // SAFETY: the processor and the system have the sets that the function is compiled
            // for, and those that these imply.
            return unsafe { avx512(loops) };
        }
        if has!("avx2") {
            // SAFETY: the processor and the system have AVX2, and AVX with it.
            return unsafe { avx2(loops) };
        }
    }
    loops.run();
}
