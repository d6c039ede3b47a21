//! Sine and cosine of an `f64`.
//!
//! ```text
//! π/2 = P1 + P2 + P3 + P4 + 2^-159.9        33, 33, 33 and 53 bits
//! r   = (((|x| - k P1) - k P2) - k P3) - k P4
//! ```
//!
//! Within the domain `k < 2^20`, so the first three products have at most 53 bits
//! and are exact. `|x| - k P1` is exact (both terms are neighbours on one grid).
//! The next two differences round; their errors are recovered exactly: where the
//! subtrahend is the larger of the two, everything lies on a grid coarse enough
//! for the difference to be exact, and elsewhere `(a - (a - b)) - b` is the error.
//! The head of `r` and the sum of what was rounded off together hold `r` to about
//! 2^-100 absolute and 2^-70 relative, even at the doubles nearest to multiples
//! of π/2, where `r` falls to 2^-60.

use core::f64::consts::FRAC_2_PI;

use super::kernel::kernel;

/// The largest angle, in radians and of either sign, that [`sin_cos`](super::sin_cos) accepts: 2^20.
///
/// ```
/// use sesc_runtime::trig;
///
/// assert!(trig::sin_cos(trig::LIMIT_RAD).0.is_finite());
/// assert!(trig::sin_cos(trig::LIMIT_RAD + 1.0).0.is_nan());
/// ```
pub const LIMIT_RAD: f64 = 1_048_576.0;

pub(crate) const SIGN: u64 = 1 << 63;
pub(crate) const NAN: u64 = 0x7FF8_0000_0000_0000;

/// 1.5 · 2^52: a sum with it is rounded to an integer, which its low bits show.
pub(crate) const MAGIC: f64 = 6_755_399_441_055_744.0;

/// π/2 in four pieces, each the truncated remainder of those before (the last rounded).
const P1: f64 = f64::from_bits(0x3FF9_21FB_5440_0000);
const P2: f64 = f64::from_bits(0x3DD0_B461_1A60_0000);
const P3: f64 = f64::from_bits(0x3BA3_198A_2E00_0000);
const P4: f64 = f64::from_bits(0x397B_839A_2520_49C1);

/// `(sin r - r) / r^3` as a polynomial in `r^2`: minimax on |r| <= π/4 + 2^-30 for the
/// relative error of the sine, which is 2^-57.9 with these rounded coefficients.
pub(crate) const SIN: [f64; 6] = [
    f64::from_bits(0xBFC5_5555_5555_5548), // -1.6666666666666630e-1
    f64::from_bits(0x3F81_1111_1110_F730), //  8.3333333333218400e-3
    f64::from_bits(0xBF2A_01A0_19BE_9215), // -1.9841269829358522e-4
    f64::from_bits(0x3EC7_1DE3_5552_B247), //  2.7557313538511096e-6
    f64::from_bits(0xBE5A_E5E4_B83B_6635), // -2.5050734388633495e-8
    f64::from_bits(0x3DE5_D8B5_584A_F560), //  1.5895433246246603e-10
];

/// `(cos r - 1 + r^2/2) / r^4` likewise; the relative error of the cosine is 2^-63.9.
pub(crate) const COS: [f64; 6] = [
    f64::from_bits(0x3FA5_5555_5555_554B), //  4.1666666666666595e-2
    f64::from_bits(0xBF56_C16C_16C1_5015), // -1.3888888888873342e-3
    f64::from_bits(0x3EFA_01A0_19C8_F25A), //  2.4801587289002100e-5
    f64::from_bits(0xBE92_7E4F_7F19_1DEF), // -2.7557314217051587e-7
    f64::from_bits(0x3E21_EE9D_BCF9_7A1E), //  2.0875705398667983e-9
    f64::from_bits(0xBDA8_FA68_4F1D_4190), // -1.1358749420488109e-11
];

/// `Σ c_i z^i` by pairs: as many products as Horner's rule, half the latency.
#[inline(always)]
fn polynomial(c: &[f64; 6], z: f64, z2: f64) -> f64 {
    (c[0] + c[1] * z) + z2 * ((c[2] + c[3] * z) + z2 * (c[4] + c[5] * z))
}

kernel!(f64, u64);

#[cfg(test)]
mod tests {
    use std::println;

    use super::super::tests::{Exact, Random};
    use super::*;
    use core::f64::consts::{PI, TAU};

    /// The documented error for any angle of the domain.
    const LIMIT_ULP: f64 = 0.9;

    /// Largest errors over `points`, in ulp, of sine and cosine.
    fn worst(points: impl Iterator<Item = f64>) -> (f64, f64) {
        let mut exact = Exact::new();
        points.fold((0.0, 0.0), |worst: (f64, f64), x| {
            let errors = exact.errors_ulp(x, sin_cos(x));
            (worst.0.max(errors.0), worst.1.max(errors.1))
        })
    }

    #[track_caller]
    fn assert_accurate(what: &str, errors: (f64, f64)) {
        println!("{what}: sin {:.4} ulp, cos {:.4} ulp", errors.0, errors.1);
        assert!(errors.0 <= LIMIT_ULP && errors.1 <= LIMIT_ULP);
    }

    #[test]
    fn accurate_over_two_turns() {
        let mut random = Random::new(1);
        let points = (0..24_000).map(|_| random.within(TAU));
        assert_accurate("|x| <= 2 pi", worst(points));
    }

    /// Where the polynomials and the change of quadrant are at their worst.
    #[test]
    fn accurate_where_quadrants_change() {
        let mut random = Random::new(2);
        let points = (0..8_000).map(|i| {
            let edge = f64::from(2 * (i % 8) - 7) * (PI / 4.0);
            edge + random.within(0.02)
        });
        assert_accurate("near odd multiples of pi/4", worst(points));
    }

    #[test]
    fn accurate_over_every_magnitude() {
        let mut random = Random::new(3);
        let points = (0..8_000).map(|i| {
            // 2^-300 .. 2^20, evenly in the exponent.
            let exponent = f64::from(i % 320 - 300);
            exponent.exp2() * (0.75 + random.within(0.25))
        });
        assert_accurate("2^-300 .. 2^20", worst(points));
    }

    #[test]
    fn accurate_over_the_whole_domain() {
        let mut random = Random::new(4);
        let points = (0..12_000)
            .map(|_| random.within(LIMIT_RAD))
            .chain([LIMIT_RAD, -LIMIT_RAD]);
        assert_accurate("|x| <= 2^20", worst(points));
    }

    #[test]
    fn accurate_beside_multiples_of_a_right_angle() {
        let points = (-8..=8).flat_map(|k| {
            let x = f64::from(k) * (PI / 2.0);
            (-40..=40_i64).map(move |step| {
                f64::from_bits(x.to_bits().wrapping_add_signed(step * i64::from(k != 0)))
            })
        });
        assert_accurate("neighbours of k pi/2, |k| <= 8", worst(points));
    }

    /// Both doubles around every multiple of π/2 in the domain, against integer
    /// arithmetic: in units of 2^-150, and modulo 2^128, `x - k π/2` is exact but
    /// for `k` times half a unit, and its sine is itself to 66 bits.
    #[test]
    fn accurate_beside_every_multiple_of_a_right_angle() {
        const RIGHT_ANGLE: u128 = 0x5110_B461_1A62_6331_45C0_6E0E_6894_8127;
        const LEADING_BIT: u64 = 1 << 52;
        let unit = |power: i32| f64::from(power).exp2();
        let (mut worst, mut closest) = (0.0_f64, 1.0_f64);
        for k in 1..=667_543_u32 {
            let near = f64::from(k) * (PI / 2.0);
            for bits in near.to_bits() - 1..=near.to_bits() + 1 {
                let x = f64::from_bits(bits);
                let (mantissa, exponent) =
                    (bits & (LEADING_BIT - 1) | LEADING_BIT, (bits >> 52) as i32);
                let fixed = u128::from(mantissa) << (exponent - 1075 + 150);
                let rest = fixed.wrapping_sub(RIGHT_ANGLE.wrapping_mul(u128::from(k))) as i128;
                let (s, c) = sin_cos(x);
                let [small, large] = match k % 4 {
                    0 => [s, c],
                    1 => [-c, s],
                    2 => [-s, -c],
                    _ => [c, -s],
                };
                // What a double cannot hold of the rest is compared as an integer.
                let ulp = unit((128 - rest.unsigned_abs().leading_zeros()) as i32 - 150 - 53);
                let got = (small * unit(75) * unit(75)) as i128;
                worst = worst.max((rest - got) as f64 * unit(-150) / ulp);
                worst = worst.max((got - rest) as f64 * unit(-150) / ulp);
                closest = closest.min(rest.unsigned_abs() as f64 * unit(-150));
                assert_eq!(large, 1.0);
            }
        }
        println!(
            "beside k pi/2: {worst:.4} ulp; closest 2^{:.2}",
            closest.log2()
        );
        assert!(worst <= LIMIT_ULP);
    }

    #[test]
    fn tiny_angles_are_their_own_sine() {
        let mut random = Random::new(5);
        let subnormal = (0..2_000).map(|_| f64::from_bits(random.bits() >> 12));
        let named = [
            0.0,
            f64::from_bits(1),
            f64::MIN_POSITIVE,
            1e-300,
            1e-160,
            1e-20,
            1e-9,
        ];
        for x in named.into_iter().chain(subnormal) {
            for x in [x, -x] {
                let (s, c) = sin_cos(x);
                assert_eq!((s.to_bits(), c.to_bits()), (x.to_bits(), 1.0_f64.to_bits()));
            }
        }
    }

    #[test]
    fn out_of_domain_is_nan() {
        let past = f64::from_bits(LIMIT_RAD.to_bits() + 1);
        let mut random = Random::new(6);
        let spread = (0..2_000).map(|_| {
            let x = f64::from_bits(random.bits());
            if x.abs() <= LIMIT_RAD { past } else { x }
        });
        let named = [past, 1e9, 1e22, 1e300, f64::MAX, f64::INFINITY, f64::NAN];
        for x in named.into_iter().chain(spread) {
            for x in [x, -x] {
                let (s, c) = sin_cos(x);
                assert!(s.is_nan() && c.is_nan(), "{x:e} gave {s}, {c}");
            }
        }
        let (s, c) = sin_cos(LIMIT_RAD);
        assert!(s.is_finite() && c.is_finite());
    }

    #[test]
    fn odd_and_even_to_the_bit_and_on_the_circle() {
        let mut random = Random::new(7);
        for i in 0..40_000 {
            let x = random.within(if i % 2 == 0 { TAU } else { LIMIT_RAD });
            let ((s, c), (s_minus, c_minus)) = (sin_cos(x), sin_cos(-x));
            assert_eq!((-s).to_bits(), s_minus.to_bits());
            assert_eq!(c.to_bits(), c_minus.to_bits());
            assert!((s * s + c * c - 1.0).abs() <= 4.0 * f64::EPSILON);
        }
        assert_eq!(sin_cos(-0.0).0.to_bits(), (-0.0_f64).to_bits());
    }
}
