//! What the tests of sines, cosines and powers hold them against.
//!
//! `error_ulp = |got - true| / 2^(e - p)` for a true value in `[2^(e-1), 2^e)` and a
//! format of `p` bits: 53 for `f64`, 24 for `f32`.

use astro_float::{BigFloat, Consts, RoundingMode};

/// Bits of the arbitrary-precision values.
const BITS: usize = 256;

/// Functions to 256 bits.
pub(crate) struct Exact {
    constants: Consts,
}

impl Exact {
    pub(crate) fn new() -> Self {
        let constants = Consts::new().expect("room for the cache of constants");
        Self { constants }
    }

    /// Errors of what an `f64` function gave at `x` for sine and cosine.
    pub(crate) fn errors(&mut self, x: f64, got: (f64, f64)) -> (f64, f64) {
        let angle = BigFloat::from_f64(x, BITS);
        let sin = angle.sin(BITS, RoundingMode::ToEven, &mut self.constants);
        let cos = angle.cos(BITS, RoundingMode::ToEven, &mut self.constants);
        let error = |truth: &BigFloat, got: f64| {
            let got = BigFloat::from_f64(got, BITS);
            let difference = truth.sub(&got, BITS, RoundingMode::ToEven);
            match difference.is_zero() {
                true => 0.0,
                false => {
                    let (mantissa, exponent) = fraction(&difference);
                    mantissa * f64::from(exponent).exp2()
                }
            }
        };
        (error(&sin, got.0), error(&cos, got.1))
    }

    /// Errors, in ulp, of what an `f64` function gave at `x` for sine and cosine.
    pub(crate) fn errors_ulp(&mut self, x: f64, got: (f64, f64)) -> (f64, f64) {
        let angle = BigFloat::from_f64(x, BITS);
        let sin = angle.sin(BITS, RoundingMode::ToEven, &mut self.constants);
        let cos = angle.cos(BITS, RoundingMode::ToEven, &mut self.constants);
        (error_ulp(&sin, got.0), error_ulp(&cos, got.1))
    }

    /// Error, in ulp, of what an `f64` function gave for `x` to the power of `y`.
    pub(crate) fn power_error_ulp(&mut self, x: f64, y: f64, got: f64) -> f64 {
        // Scaled, since the conversion is wrong below the normal numbers.
        let scale = if x < 1.0 { 128_f64.exp2() } else { 1.0 };
        let [base, exponent, scale] = [x * scale, y, scale].map(|x| BigFloat::from_f64(x, BITS));
        let base = base.div(&scale, BITS, RoundingMode::ToEven);
        let truth = base.pow(&exponent, BITS, RoundingMode::ToEven, &mut self.constants);
        error_ulp(&truth, got)
    }
}

fn error_ulp(truth: &BigFloat, got: f64) -> f64 {
    let got = BigFloat::from_f64(got, BITS);
    let (difference, exponent) = fraction(&truth.sub(&got, BITS, RoundingMode::ToEven));
    let (_, unit) = fraction(truth);
    difference * f64::from(exponent - (unit - 53)).exp2()
}

/// `(f, e)` with |value| = f 2^e and f in [1/2, 1), or zero.
fn fraction(value: &BigFloat) -> (f64, i32) {
    let (words, _, _, exponent, _) = value.as_raw_parts().expect("a finite value");
    let top = *words.last().expect("a mantissa has words") as f64;
    (top * (-64_f64).exp2(), exponent)
}

/// Error, in ulp of an `f32`, of `got` where `truth` is true to many more bits.
pub(crate) fn error_ulp_f32(truth: f64, got: f32) -> f64 {
    let exponent = ((truth.to_bits() >> 52) & 0x7FF) as i32 - 1022;
    (truth - f64::from(got)).abs() * f64::from(24 - exponent.max(-125)).exp2()
}

/// SplitMix64: the same numbers in every run.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in `[-limit, limit]`.
    pub(crate) fn within(&mut self, limit: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 * (-53_f64).exp2();
        (2.0 * unit - 1.0) * limit
    }
}
