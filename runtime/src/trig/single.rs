//! Sine and cosine of an `f32`, in `f32` and `u32` arithmetic alone.
//!
//! ```text
//! π/2 = P1 + P2 + P3 + P4 + 2^-68.7         14, 14, 14 and 24 bits
//! r   = (((|x| - k P1) - k P2) - k P3) - k P4
//! ```
//!
//! Within the domain `k < 2^10`, so the first three products have at most 24 bits
//! and are exact. The rest is the argument of the `f64` kernel on a smaller grid.
//! A unit without double precision (Cortex-M4F) runs it as it stands.

use core::f32::consts::FRAC_2_PI;

use super::kernel::kernel;

/// The largest angle, in radians and of either sign, that [`sin_cos_f32`](super::sin_cos_f32) accepts: 2^10.
///
/// ```
/// use sesc_runtime::trig;
///
/// assert!(trig::sin_cos_f32(trig::LIMIT_RAD_F32).0.is_finite());
/// assert!(trig::sin_cos_f32(trig::LIMIT_RAD_F32 + 1.0).0.is_nan());
/// ```
pub const LIMIT_RAD: f32 = 1024.0;

pub(crate) const SIGN: u32 = 1 << 31;
pub(crate) const NAN: u32 = 0x7FC0_0000;

/// 1.5 · 2^23: a sum with it is rounded to an integer, which its low bits show.
pub(crate) const MAGIC: f32 = 12_582_912.0;

/// π/2 in four pieces, each the truncated remainder of those before (the last rounded).
const P1: f32 = f32::from_bits(0x3FC9_0C00);
const P2: f32 = f32::from_bits(0x38F6_A800);
const P3: f32 = f32::from_bits(0x3088_5800);
const P4: f32 = f32::from_bits(0x298C_234C);

/// `(sin r - r) / r^3` as a polynomial in `r^2`: minimax on |r| <= π/4 + 2^-12 for the
/// relative error of the sine, which is 2^-27.9 with these rounded coefficients.
pub(crate) const SIN: [f32; 3] = [
    f32::from_bits(0xBE2A_AAA3), // -1.666665524e-1
    f32::from_bits(0x3C08_83BB), //  8.332188241e-3
    f32::from_bits(0xB94C_A97D), // -1.951809536e-4
];

/// `(cos r - 1 + r^2/2) / r^4` likewise; the relative error of the cosine is 2^-33.0.
pub(crate) const COS: [f32; 3] = [
    f32::from_bits(0x3D2A_AAA5), //  4.166664556e-2
    f32::from_bits(0xBAB6_0614), // -1.388730947e-3
    f32::from_bits(0x37CC_F406), //  2.443232734e-5
];

/// `Σ c_i z^i`, the two lower terms first.
#[inline(always)]
fn polynomial(c: &[f32; 3], z: f32, z2: f32) -> f32 {
    (c[0] + c[1] * z) + z2 * c[2]
}

kernel!(f32, u32);

#[cfg(test)]
mod tests {
    use std::println;

    use super::super::double;
    use super::super::tests::{Random, error_ulp_f32};
    use super::*;

    /// The documented error for any angle of the domain.
    const LIMIT_ULP: f64 = 0.85;

    /// Largest error over the `f32` of these bit patterns, in ulp, against the `f64`
    /// functions, which are exact at this scale.
    fn worst(bits: impl Iterator<Item = u32>) -> f64 {
        bits.map(f32::from_bits).fold(0.0, |worst, x| {
            let (truth, got) = (double::sin_cos(f64::from(x)), sin_cos(x));
            let (s, c) = (error_ulp_f32(truth.0, got.0), error_ulp_f32(truth.1, got.1));
            worst.max(s).max(c)
        })
    }

    #[track_caller]
    fn assert_accurate(what: &str, error_ulp: f64) {
        println!("{what}: {error_ulp:.4} ulp");
        assert!(error_ulp <= LIMIT_ULP);
    }

    #[test]
    fn accurate_all_over_the_domain() {
        // With SESC_EXHAUSTIVE set while compiling: every f32, two minutes in release.
        let step = match option_env!("SESC_EXHAUSTIVE") {
            Some(_) => 1,
            None => 1009,
        };
        let two_turns = core::f32::consts::TAU.to_bits();
        assert_accurate("|x| <= 2 pi", worst((0..=two_turns).step_by(step)));
        let beyond = two_turns..=LIMIT_RAD.to_bits();
        assert_accurate("|x| <= 2^10", worst(beyond.step_by(step.min(101))));
    }

    #[test]
    fn accurate_beside_every_multiple_of_a_right_angle() {
        let near = |k: u32| (f64::from(k) * core::f64::consts::FRAC_PI_2) as f32;
        let beside = (1..=651).flat_map(|k| near(k).to_bits() - 8..=near(k).to_bits() + 8);
        assert_accurate("neighbours of k pi/2", worst(beside));
    }

    #[test]
    fn tiny_angles_are_their_own_sine() {
        for x in [
            0.0,
            f32::from_bits(1),
            f32::from_bits(77),
            f32::MIN_POSITIVE,
            1e-30,
            1e-5,
        ] {
            for x in [x, -x] {
                let (s, c) = sin_cos(x);
                assert_eq!((s.to_bits(), c.to_bits()), (x.to_bits(), 1.0_f32.to_bits()));
            }
        }
    }

    #[test]
    fn out_of_domain_is_nan() {
        let past = LIMIT_RAD.to_bits() + 1;
        let beyond = (past..=i32::MAX as u32).step_by(4099).map(f32::from_bits);
        for x in [f32::from_bits(past), f32::MAX, f32::INFINITY]
            .into_iter()
            .chain(beyond)
        {
            for x in [x, -x] {
                let (s, c) = sin_cos(x);
                assert!(s.is_nan() && c.is_nan(), "{x:e} gave {s}, {c}");
            }
        }
        let (s, c) = sin_cos(-LIMIT_RAD);
        assert!(s.is_finite() && c.is_finite());
    }

    #[test]
    fn odd_and_even_to_the_bit_and_on_the_circle() {
        let mut random = Random::new(8);
        for _ in 0..40_000 {
            let x = random.within(1024.0) as f32;
            let ((s, c), (s_minus, c_minus)) = (sin_cos(x), sin_cos(-x));
            assert_eq!((-s).to_bits(), s_minus.to_bits());
            assert_eq!(c.to_bits(), c_minus.to_bits());
            assert!((s * s + c * c - 1.0).abs() <= 4.0 * f32::EPSILON);
        }
    }
}
