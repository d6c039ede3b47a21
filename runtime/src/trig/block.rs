//! Sine and cosine of an array of angles.
//!
//! ```text
//! sin[i] = sin x[i],  cos[i] = cos x[i]        i = 0 .. N
//! ```
//!
//! A loop over the scalar kernel, which has no branch: compiled for a machine
//! with vector registers, one round of it treats a register full of angles
//! (two `f64` with SSE2 or NEON, four with AVX2, eight with AVX-512). The bits are
//! those of the scalar functions.

use super::{sin_cos, sin_cos_f32};

/// Sines and cosines of `x`, in radians, written to `sin` and `cos`.
///
/// Each element is what [`sin_cos`] gives; elements out of its domain are NaN and
/// leave the others alone.
///
/// ```
/// use sesc_runtime::trig;
///
/// let (mut sin, mut cos) = ([0.0; 4], [0.0; 4]);
/// trig::sin_cos_block(&[0.0, 0.1, f64::NAN, 0.3], &mut sin, &mut cos);
/// assert_eq!((sin[1], cos[1]), trig::sin_cos(0.1));
/// assert!(sin[2].is_nan());
/// ```
// Always: a caller compiled for wider registers gets the loop in those.
#[inline(always)]
pub fn sin_cos_block<const N: usize>(x: &[f64; N], sin: &mut [f64; N], cos: &mut [f64; N]) {
    for ((x, sin), cos) in x.iter().zip(sin).zip(cos) {
        (*sin, *cos) = sin_cos(*x);
    }
}

/// Sines and cosines of `x`, in radians, written to `sin` and `cos`.
///
/// Each element is what [`sin_cos_f32`] gives.
// Always: a caller compiled for wider registers gets the loop in those.
#[inline(always)]
pub fn sin_cos_block_f32<const N: usize>(x: &[f32; N], sin: &mut [f32; N], cos: &mut [f32; N]) {
    for ((x, sin), cos) in x.iter().zip(sin).zip(cos) {
        (*sin, *cos) = sin_cos_f32(*x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::exact::Random;
    use super::*;

    #[test]
    fn blocks_have_the_bits_of_scalars() {
        let mut random = Random::new(11);
        let (mut sin, mut cos) = ([0.0; 64], [0.0; 64]);
        let (mut sin_f32, mut cos_f32) = ([0.0; 64], [0.0; 64]);
        for _ in 0..200 {
            let x: [f64; 64] = core::array::from_fn(|_| random.within(1100.0));
            let x_f32 = x.map(|x| x as f32);
            sin_cos_block(&x, &mut sin, &mut cos);
            sin_cos_block_f32(&x_f32, &mut sin_f32, &mut cos_f32);
            for i in 0..64 {
                let (s, c) = sin_cos(x[i]);
                assert_eq!(
                    (sin[i].to_bits(), cos[i].to_bits()),
                    (s.to_bits(), c.to_bits())
                );
                let (s, c) = sin_cos_f32(x_f32[i]);
                assert_eq!(sin_f32[i].is_nan(), s.is_nan());
                assert!(s.is_nan() || sin_f32[i].to_bits() == s.to_bits());
                assert!(c.is_nan() || cos_f32[i].to_bits() == c.to_bits());
            }
        }
    }
}
