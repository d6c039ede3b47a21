//! AVX2 with FMA: four doubles, eight singles.

use core::arch::x86_64::*;

use super::fused::{FusedF32, FusedF64};
use super::{align_stack, fused, machine, register};
use crate::scalar::Scalar;
use crate::scalar::sealed::{Machine, ROWS, Task};
use crate::{pack, power};

/// The set.
pub(crate) struct Avx2;

/// Run a task.
///
/// # Safety
/// The processor and the system must have AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
pub(crate) unsafe fn run<S: Scalar, M: Machine<S>>(task: impl Task<S>) {
    align_stack();
    task.run::<M>();
}

register! {
    /// Four doubles.
    F64x4(__m256d): 4 of f64;
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd
    _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_fmadd_pd
    _mm256_max_pd _mm256_min_pd
    negate |x| _mm256_xor_pd(x, _mm256_set1_pd(-0.0));
    sin_cos lanes_f64x4;
    power power::power;
}

register! {
    /// Eight singles.
    F32x8(__m256): 8 of f32;
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_fmadd_ps
    _mm256_max_ps _mm256_min_ps
    negate |x| _mm256_xor_ps(x, _mm256_set1_ps(-0.0));
    sin_cos lanes_f32x8;
    power power::power_f32;
}

register! {
    /// Four singles.
    F32x4(__m128): 4 of f32;
    _mm_set1_ps _mm_loadu_ps _mm_storeu_ps
    _mm_add_ps _mm_sub_ps _mm_mul_ps _mm_div_ps _mm_fmadd_ps
    _mm_max_ps _mm_min_ps
    negate |x| _mm_xor_ps(x, _mm_set1_ps(-0.0));
    sin_cos lanes_f32x4;
    power power::power_f32;
}

/// Sines and cosines of the lanes of a register.
macro_rules! lanes {
    ($name:ident, $register:ident, $sin_cos:ident, $lanes:literal) => {
        #[inline(always)]
        fn $name(x: $register) -> ($register, $register) {
            let (mut sin, mut cos) = ([0.0; $lanes], [0.0; $lanes]);
            $sin_cos(&x.array(), &mut sin, &mut cos);
            ($register::of(&sin), $register::of(&cos))
        }
    };
}
lanes!(lanes_f64x4, F64x4, sin_cos_f64, 4);
lanes!(lanes_f32x8, F32x8, sin_cos_f32, 8);
lanes!(lanes_f32x4, F32x4, sin_cos_f32, 4);

/// The kernel of [`fused`], as the compiler vectorises it inside the entries above.
#[inline(always)]
fn sin_cos_f64<const N: usize>(angles: &[f64; N], sin: &mut [f64; N], cos: &mut [f64; N]) {
    for ((x, sin), cos) in angles.iter().zip(sin).zip(cos) {
        (*sin, *cos) = fused::sin_cos_f64(*x);
    }
}

/// The kernel of [`fused`], likewise.
#[inline(always)]
fn sin_cos_f32<const N: usize>(angles: &[f32; N], sin: &mut [f32; N], cos: &mut [f32; N]) {
    for ((x, sin), cos) in angles.iter().zip(sin).zip(cos) {
        (*sin, *cos) = fused::sin_cos_f32(*x);
    }
}

#[inline(always)]
fn columns_f64<const N: usize>(rows: &[[f64; N]; 8], part: usize) -> [F64x4; N] {
    <Avx2 as Machine<f64>>::load(&pack(rows), part)
}

#[inline(always)]
fn columns_f32<const N: usize>(rows: &[[f32; N]; 16], part: usize) -> [F32x8; N] {
    <Avx2 as Machine<f32>>::load(&pack(rows), part)
}

machine! {
    F64x4, 4 of f64, 8 a block, FusedF64, rows Avx2: F64x4;
    columns columns_f64;
    sin_cos sin_cos_f64;
}
machine! {
    F32x8, 8 of f32, 16 a block, FusedF32, rows Avx2: F32x4;
    columns columns_f32;
    sin_cos sin_cos_f32;
}
