//! Constants for an `f64`.

use super::kernel::kernel;
use crate::trig::double::{MAGIC, NAN, SIGN};

const MANTISSA: u32 = 52;
const BIAS: f64 = 1023.0;
const ONE: u64 = 1.0_f64.to_bits();
const INFINITY: u64 = f64::INFINITY.to_bits();
/// Smallest number with a full mantissa; what is below is scaled by 2^64.
const LEAST: u64 = f64::MIN_POSITIVE.to_bits();
const SCALE: u64 = 18_446_744_073_709_551_616.0_f64.to_bits();
const SCALED_BY: f64 = 64.0;
/// √½, where `m` begins.
const ROOT: u64 = 0x3FE6_A09E_667F_3BCD;
/// 26 bits of a mantissa's 53.
const UPPER: u64 = !0x07FF_FFFF;
/// 2^52: an integer added to its bits is added to its value.
const COUNT: f64 = 4_503_599_627_370_496.0;
/// An exponent with which every x but 1 gives zero or infinity: 2^64.
const LARGEST: f64 = 18_446_744_073_709_551_616.0;
/// 2^±FAR is infinity and zero.
const FAR: f64 = 1100.0;

/// Each of these in two pieces.
const THIRD: (f64, f64) = (0.333_333_333_333_333_3, 1.850_371_707_708_594e-17);
const TWO_OVER_LN_2: (f64, f64) = (2.885_390_081_777_926_8, 4.071_054_748_186_206_6e-17);
const LN_2: (f64, f64) = (core::f64::consts::LN_2, 2.319_046_813_846_299_6e-17);

/// `1/(2 i + 5)`: the series of `atanh`; what is left out is below 2^-70 of the sum.
const P: [f64; 11] = [
    1.0 / 5.0,
    1.0 / 7.0,
    1.0 / 9.0,
    1.0 / 11.0,
    1.0 / 13.0,
    1.0 / 15.0,
    1.0 / 17.0,
    1.0 / 19.0,
    1.0 / 21.0,
    1.0 / 23.0,
    1.0 / 25.0,
];

/// `1/(i + 3)!`: the series of the exponential; what is left out is below 2^-63.
const Q: [f64; 12] = [
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
    1.0 / 87_178_291_200.0,
];

kernel!(f64, u64);
