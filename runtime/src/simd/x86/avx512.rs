//! AVX-512: eight doubles, sixteen singles, and a table of sines in two registers.
//!
//! ```text
//! x = k t + r,    t = π/8 (f32: π/16),    k = round(x / t),    |r| ≤ t/2
//! sin x = S_k + S_k (cos r − 1) + C_k sin r
//! cos x = C_k + C_k (cos r − 1) − S_k sin r
//! ```
//!
//! `S_k = sin k t` and `C_k = cos k t` come from registers by one instruction, whose
//! index wraps around the turn by itself: no quadrants, and polynomials of low degree.
//! Errors are below 1.7 units of 2⁻⁵³, or of 2⁻²⁴: the roundings of
//! the table and of two sums are half a unit each. Angles beyond the limits of
//! [`trig`](crate::trig) give NaN, as there.

use core::arch::x86_64::*;

use super::avx2::{F32x4, F64x4};
use super::fused::{FusedF32, FusedF64};
use super::{align_stack, machine, register};
use crate::scalar::Scalar;
use crate::scalar::sealed::{Machine, ROWS, Task};
use crate::trig::{double, single};
use crate::{pack, power};

/// The set.
pub(crate) struct Avx512;

/// The set, with the rows of one posture in registers of 256 bits (f32: 128).
pub(crate) struct Avx512Short;

/// Run a task on either.
///
/// # Safety
/// The processor and the system must have AVX-512 F, DQ and VL, and what the compiler takes as
/// part of them: AVX2, FMA and F16C.
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
pub(crate) unsafe fn run<S: Scalar, M: Machine<S>>(task: impl Task<S>) {
    align_stack();
    task.run::<M>();
}

register! {
    /// Eight doubles.
    F64x8(__m512d): 8 of f64;
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd
    _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_fmadd_pd
    _mm512_max_pd _mm512_min_pd
    negate |x| _mm512_xor_pd(x, _mm512_set1_pd(-0.0));
    sin_cos |x: F64x8| {
        // SAFETY: see the head of `super`.
        let (sin, cos) = unsafe { sin_cos_f64(x.0) };
        (F64x8(sin), F64x8(cos))
    };
    power power::power;
}

register! {
    /// Sixteen singles.
    F32x16(__m512): 16 of f32;
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_fmadd_ps
    _mm512_max_ps _mm512_min_ps
    negate |x| _mm512_xor_ps(x, _mm512_set1_ps(-0.0));
    sin_cos |x: F32x16| {
        // SAFETY: see the head of `super`.
        let (sin, cos) = unsafe { sin_cos_f32(x.0) };
        (F32x16(sin), F32x16(cos))
    };
    power power::power_f32;
}

/// Over all angles, a register at a time.
macro_rules! each {
    ($each:ident, $scalar:ty, $lanes:literal, $mask:ty, $load:ident, $store:ident, $sin_cos:ident) => {
        #[inline(always)]
        fn $each<const N: usize>(
            angles: &[$scalar; N],
            sin: &mut [$scalar; N],
            cos: &mut [$scalar; N],
        ) {
            let beyond = $lanes - N.min($lanes);
            let mask = <$mask>::MAX.checked_shr(beyond as u32).unwrap_or(0);
            for step in 0..N.div_ceil($lanes) {
                // The last register ends with the arrays, and does some twice: what is
                // stored under a mask cannot be loaded again at once.
                let start = (step * $lanes).min(N.saturating_sub($lanes));
                // SAFETY: see the head of `super`; `$lanes` numbers from `start`, or all
                // N under the mask, are in the arrays, and a lane outside the mask is neither
                // read nor written. Without angles there is no step.
                unsafe {
                    let (s, c) = $sin_cos($load(mask, angles.as_ptr().add(start)));
                    $store(sin.as_mut_ptr().add(start), mask, s);
                    $store(cos.as_mut_ptr().add(start), mask, c);
                }
            }
        }
    };
}
each! {
    each_f64, f64, 8, __mmask8, _mm512_maskz_loadu_pd, _mm512_mask_storeu_pd, sin_cos_f64
}
each! {
    each_f32, f32, 16, __mmask16, _mm512_maskz_loadu_ps, _mm512_mask_storeu_ps, sin_cos_f32
}

#[inline(always)]
fn columns_f32<const N: usize>(rows: &[[f32; N]; 16], part: usize) -> [F32x16; N] {
    <Avx512 as Machine<f32>>::load(&pack(rows), part)
}

/// Squares of 8 × 8 transposed in registers: through memory the stores of single numbers
/// would hold up the loads of whole lines.
#[inline(always)]
fn columns_f64<const N: usize>(rows: &[[f64; N]; 8], _: usize) -> [F64x8; N] {
    let mut columns = [F64x8::splat(0.0); N];
    for start in (0..N).step_by(8) {
        let mask = __mmask8::MAX >> (8 - (N - start).min(8));
        // SAFETY: see the head of `super`; the mask ends with the row, and a lane outside it is
        // not read.
        let square = unsafe {
            transposed(core::array::from_fn(|k| {
                _mm512_maskz_loadu_pd(mask, rows[k].as_ptr().add(start))
            }))
        };
        for (column, line) in columns.iter_mut().skip(start).zip(square) {
            *column = F64x8(line);
        }
    }
    columns
}

/// # Safety
/// The processor must have AVX-512 F.
#[inline(always)]
unsafe fn transposed(r: [__m512d; 8]) -> [__m512d; 8] {
    // Columns 0 and 4, 2 and 6 of four pairs of rows.
    #[inline(always)]
    unsafe fn four(pairs: [__m512d; 4]) -> [__m512d; 4] {
        // SAFETY: as for `transposed`.
        unsafe {
            let even = |a, b| _mm512_shuffle_f64x2::<0x88>(a, b);
            let odd = |a, b| _mm512_shuffle_f64x2::<0xDD>(a, b);
            let [a, b, c, d] = pairs;
            let (ab, cd) = (even(a, b), even(c, d));
            let (ba, dc) = (odd(a, b), odd(c, d));
            [even(ab, cd), even(ba, dc), odd(ab, cd), odd(ba, dc)]
        }
    }
    // SAFETY: the caller has seen that the processor has AVX-512 F.
    unsafe {
        let low = core::array::from_fn(|k| _mm512_unpacklo_pd(r[2 * k], r[2 * k + 1]));
        let high = core::array::from_fn(|k| _mm512_unpackhi_pd(r[2 * k], r[2 * k + 1]));
        let [c0, c2, c4, c6] = four(low);
        let [c1, c3, c5, c7] = four(high);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
}

machine! {
    F64x8, 8 of f64, 8 a block, FusedF64, rows Avx512: F64x8, Avx512Short: F64x4;
    columns columns_f64;
    sin_cos each_f64;
}
machine! {
    F32x16, 16 of f32, 16 a block, FusedF32, rows Avx512: F32x16, Avx512Short: F32x4;
    columns columns_f32;
    sin_cos each_f32;
}

/// `sin k π/8`; a quarter turn on, the cosines.
const TABLE: [f64; 20] = {
    const S1: f64 = 0.382_683_432_365_089_8;
    const S2: f64 = core::f64::consts::FRAC_1_SQRT_2;
    const S3: f64 = 0.923_879_532_511_286_7;
    [
        0.0, S1, S2, S3, 1.0, S3, S2, S1, 0.0, -S1, -S2, -S3, -1.0, -S3, -S2, -S1, 0.0, S1, S2, S3,
    ]
};

/// π/8 in two pieces.
const STEP: [f64; 2] = [core::f64::consts::FRAC_PI_8, 1.530_808_498_934_191_5e-17];

/// `(sin r − r) / r³` in `r²`: minimax, error of the sine below 6e-19.
const SIN: [f64; 4] = [
    -0.166_666_666_666_660_66,
    0.008_333_333_332_069_795,
    -0.000_198_412_610_357_313_73,
    2.753_228_697_618_134_6e-6,
];

/// `(cos r − 1 + r²/2) / r⁴` in `r²`: minimax, error of the cosine below 7e-21.
const COS: [f64; 4] = [
    0.041_666_666_666_665_984,
    -0.001_388_888_888_761_665_2,
    2.480_157_913_208_039_4e-5,
    -2.753_546_000_923_134_6e-7,
];

/// Sines and cosines of eight doubles.
///
/// # Safety
/// The processor must have AVX-512 F and DQ.
#[inline(always)]
unsafe fn sin_cos_f64(x: __m512d) -> (__m512d, __m512d) {
    // SAFETY: the caller has seen that the processor has AVX-512 F and DQ; rows of eight end
    // within the table of 20.
    unsafe {
        let all = |value: f64| _mm512_set1_pd(value);
        let known = _mm512_cmp_pd_mask::<_CMP_LE_OQ>(_mm512_abs_pd(x), all(double::LIMIT_RAD));

        let shifted = _mm512_fmadd_pd(
            x,
            all(8.0 * core::f64::consts::FRAC_1_PI),
            all(double::MAGIC),
        );
        let index = _mm512_castpd_si512(shifted);
        let k = _mm512_sub_pd(shifted, all(double::MAGIC));
        let r = _mm512_fnmadd_pd(k, all(STEP[0]), x);
        let r = _mm512_fnmadd_pd(k, all(STEP[1]), r);
        // From here a NaN spreads to both results.
        let z = _mm512_mask_mul_pd(all(f64::NAN), known, r, r);

        let s = _mm512_fmadd_pd(z, all(SIN[3]), all(SIN[2]));
        let s = _mm512_fmadd_pd(z, s, all(SIN[1]));
        let s = _mm512_fmadd_pd(z, s, all(SIN[0]));
        let sin_r = _mm512_fmadd_pd(_mm512_mul_pd(z, r), s, r);
        let c = _mm512_fmadd_pd(z, all(COS[3]), all(COS[2]));
        let c = _mm512_fmadd_pd(z, c, all(COS[1]));
        let c = _mm512_fmadd_pd(z, c, all(COS[0]));
        let c = _mm512_fmadd_pd(z, c, all(-0.5));
        let cos_r_less_1 = _mm512_mul_pd(z, c);

        let row = |start: usize| _mm512_loadu_pd(TABLE.as_ptr().add(start));
        let sin_k = _mm512_permutex2var_pd(row(0), index, row(8));
        let cos_k = _mm512_permutex2var_pd(row(4), index, row(12));
        let sin = _mm512_fmadd_pd(cos_k, sin_r, sin_k);
        let cos = _mm512_fnmadd_pd(sin_k, sin_r, cos_k);
        (
            _mm512_fmadd_pd(sin_k, cos_r_less_1, sin),
            _mm512_fmadd_pd(cos_k, cos_r_less_1, cos),
        )
    }
}

/// `sin k π/16`; a quarter turn on, the cosines.
const TABLE_F32: [f32; 40] = {
    const S: [f32; 9] = [
        0.0,
        0.195_090_32,
        0.382_683_43,
        0.555_570_24,
        core::f32::consts::FRAC_1_SQRT_2,
        0.831_469_6,
        0.923_879_5,
        0.980_785_25,
        1.0,
    ];
    let mut table = [0.0; 40];
    let mut k = 0;
    while k < 40 {
        let (half, within) = (k / 16 % 2, k % 16);
        let sine = S[if within <= 8 { within } else { 16 - within }];
        table[k] = if half == 0 { sine } else { -sine };
        k += 1;
    }
    table
};

/// π/16 in two pieces.
const STEP_F32: [f32; 2] = [f32::from_bits(0x3E49_0FDB), f32::from_bits(0xB1BB_BD2E)];

/// `(sin r − r) / r³` in `r²`: minimax, error of the sine below 5e-13.
const SIN_F32: [f32; 2] = [f32::from_bits(0xBE2A_AAAA), f32::from_bits(0x3C08_7C92)];

/// `(cos r − 1) / r²` in `r²`: minimax, error of the cosine below 5e-11.
const COS_F32: [f32; 2] = [f32::from_bits(0xBEFF_FFFE), f32::from_bits(0x3D2A_9717)];

/// Sines and cosines of sixteen singles.
///
/// # Safety
/// The processor must have AVX-512 F and DQ.
#[inline(always)]
unsafe fn sin_cos_f32(x: __m512) -> (__m512, __m512) {
    // SAFETY: the caller has seen that the processor has AVX-512 F and DQ; rows of sixteen end
    // within the table of 40.
    unsafe {
        let all = |value: f32| _mm512_set1_ps(value);
        let known = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(_mm512_abs_ps(x), all(single::LIMIT_RAD));

        let shifted = _mm512_fmadd_ps(
            x,
            all(16.0 * core::f32::consts::FRAC_1_PI),
            all(single::MAGIC),
        );
        let index = _mm512_castps_si512(shifted);
        let k = _mm512_sub_ps(shifted, all(single::MAGIC));
        let r = _mm512_fnmadd_ps(k, all(STEP_F32[0]), x);
        let r = _mm512_fnmadd_ps(k, all(STEP_F32[1]), r);
        // From here a NaN spreads to both results.
        let z = _mm512_mask_mul_ps(all(f32::NAN), known, r, r);

        let s = _mm512_fmadd_ps(z, all(SIN_F32[1]), all(SIN_F32[0]));
        let sin_r = _mm512_fmadd_ps(_mm512_mul_ps(z, r), s, r);
        let c = _mm512_fmadd_ps(z, all(COS_F32[1]), all(COS_F32[0]));
        let cos_r_less_1 = _mm512_mul_ps(z, c);

        let row = |start: usize| _mm512_loadu_ps(TABLE_F32.as_ptr().add(start));
        let sin_k = _mm512_permutex2var_ps(row(0), index, row(16));
        let cos_k = _mm512_permutex2var_ps(row(8), index, row(24));
        let sin = _mm512_fmadd_ps(cos_k, sin_r, sin_k);
        let cos = _mm512_fnmadd_ps(sin_k, sin_r, cos_k);
        (
            _mm512_fmadd_ps(sin_k, cos_r_less_1, sin),
            _mm512_fmadd_ps(cos_k, cos_r_less_1, cos),
        )
    }
}
