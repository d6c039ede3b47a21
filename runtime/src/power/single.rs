//! Constants for an `f32`: the same algorithm, in `f32` and `u32` arithmetic alone.

use super::kernel::kernel;
use crate::trig::single::{MAGIC, NAN, SIGN};

const MANTISSA: u32 = 23;
const BIAS: f32 = 127.0;
const ONE: u32 = 1.0_f32.to_bits();
const INFINITY: u32 = f32::INFINITY.to_bits();
/// Smallest number with a full mantissa; what is below is scaled by 2^32.
const LEAST: u32 = f32::MIN_POSITIVE.to_bits();
const SCALE: u32 = 4_294_967_296.0_f32.to_bits();
const SCALED_BY: f32 = 32.0;
/// √½, where `m` begins.
const ROOT: u32 = 0x3F35_04F3;
/// 12 bits of a mantissa's 24.
const UPPER: u32 = !0x0FFF;
/// 2^23: an integer added to its bits is added to its value.
const COUNT: f32 = 8_388_608.0;
/// An exponent with which every x but 1 gives zero or infinity: 2^40.
const LARGEST: f32 = 1_099_511_627_776.0;
/// 2^±FAR is infinity and zero.
const FAR: f32 = 200.0;

/// Each of these in two pieces.
const THIRD: (f32, f32) = (0.333_333_34, -9.934_108e-9);
const TWO_OVER_LN_2: (f32, f32) = (2.885_39, 3.851_926e-8);
const LN_2: (f32, f32) = (core::f32::consts::LN_2, -1.904_654_2e-9);

/// `1/(2 i + 5)`: the series of `atanh`; what is left out is below 2^-39 of the sum.
const P: [f32; 5] = [1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0, 1.0 / 11.0, 1.0 / 13.0];

/// `1/(i + 3)!`: the series of the exponential; what is left out is below 2^-32.
const Q: [f32; 6] = [
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
];

kernel!(f32, u32);
