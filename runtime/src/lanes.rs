//! Several postures side by side.
//!
//! ```text
//! (x ∘ y)[i] = x[i] ∘ y[i]        ∘ one of +, -, ·, /     i = 0 .. N
//! ```
//!
//! A generated function evaluated with [`Lanes`] treats `N` postures at once: lane
//! `i` of each joint angle, and of each result, belongs to posture `i`. There is
//! no traffic between lanes, so the compiler maps them on vector registers, and
//! lane `i` holds the very bits that the scalar function would give for posture
//! `i`.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::Real;

/// `N` numbers, one per posture, with elementwise arithmetic; they start at a cache line.
///
/// ```
/// use sesc_runtime::{F64x8, Lanes, Real, pack, unpack};
///
/// /// Forward position of a two-link arm, in metres.
/// fn forward<T: Real>(q: &[T; 2]) -> [T; 1] {
///     let (s_hip, _) = q[0].sin_cos();
///     let (s_both, _) = (q[0] + q[1]).sin_cos();
///     [T::from_f64(0.3) * s_hip + T::from_f64(0.25) * s_both]
/// }
///
/// // Eight postures, a row each.
/// let postures: [[f64; 2]; 8] = core::array::from_fn(|k| [0.1 * k as f64, 0.2]);
/// let q: [F64x8; 2] = pack(&postures);
/// let results: [[f64; 1]; 8] = unpack(&forward(&q));
/// assert_eq!(results[2], forward(&postures[2]));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Lanes<S, const N: usize>(pub [S; N]);

/// Eight postures in double precision: a register of AVX-512, a cache line.
///
/// ```
/// use sesc_runtime::F64x8;
///
/// assert_eq!((F64x8::splat(0.5) + F64x8::splat(0.25)).0, [0.75; 8]);
/// assert_eq!((size_of::<F64x8>(), align_of::<F64x8>()), (64, 64));
/// ```
pub type F64x8 = Lanes<f64, 8>;
/// Sixteen postures in single precision: a register of AVX-512, a cache line.
///
/// ```
/// use sesc_runtime::F32x16;
///
/// assert_eq!((F32x16::splat(0.5) * F32x16::splat(3.0)).0, [1.5; 16]);
/// ```
pub type F32x16 = Lanes<f32, 16>;

impl<S: Real, const N: usize> Lanes<S, N> {
    /// The same number in every lane.
    ///
    /// ```
    /// use sesc_runtime::F64x8;
    ///
    /// assert_eq!(F64x8::splat(0.5).0, [0.5; 8]);
    /// ```
    #[inline(always)]
    pub fn splat(x: S) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(S, S) -> S) -> Self {
        for (a, b) in self.0.iter_mut().zip(&other.0) {
            *a = f(*a, *b);
        }
        self
    }
}

/// From one row per posture to one set of lanes per column.
///
/// ```
/// use sesc_runtime::{Lanes, pack};
///
/// assert_eq!(pack(&[[0.1, 0.2], [0.3, 0.4]]), [Lanes([0.1, 0.3]), Lanes([0.2, 0.4])]);
/// ```
#[inline]
pub fn pack<S: Real, const N: usize, const COLUMNS: usize>(
    rows: &[[S; COLUMNS]; N],
) -> [Lanes<S, N>; COLUMNS] {
    core::array::from_fn(|column| Lanes(core::array::from_fn(|row| rows[row][column])))
}

/// From one set of lanes per column to one row per posture: the inverse of [`pack`].
///
/// ```
/// use sesc_runtime::{Lanes, unpack};
///
/// assert_eq!(unpack(&[Lanes([0.1, 0.3]), Lanes([0.2, 0.4])]), [[0.1, 0.2], [0.3, 0.4]]);
/// ```
#[inline]
pub fn unpack<S: Real, const N: usize, const COLUMNS: usize>(
    columns: &[Lanes<S, N>; COLUMNS],
) -> [[S; COLUMNS]; N] {
    core::array::from_fn(|row| core::array::from_fn(|column| columns[column].0[row]))
}

impl<S, const N: usize> From<[S; N]> for Lanes<S, N> {
    #[inline(always)]
    fn from(lanes: [S; N]) -> Self {
        Self(lanes)
    }
}

impl<S, const N: usize> From<Lanes<S, N>> for [S; N] {
    #[inline(always)]
    fn from(lanes: Lanes<S, N>) -> Self {
        lanes.0
    }
}

impl<S: Real, const N: usize> Add for Lanes<S, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<S: Real, const N: usize> Sub for Lanes<S, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<S: Real, const N: usize> Mul for Lanes<S, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<S: Real, const N: usize> Div for Lanes<S, N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl<S: Real, const N: usize> Neg for Lanes<S, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(mut self) -> Self {
        for a in &mut self.0 {
            *a = -*a;
        }
        self
    }
}

impl<S: Real, const N: usize> Real for Lanes<S, N> {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Self::splat(S::from_f64(x))
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = (self, self);
        // By reference: over an array by value the loop would not become vector code.
        for ((x, sin), cos) in self.0.iter().zip(&mut sin.0).zip(&mut cos.0) {
            (*sin, *cos) = x.sin_cos();
        }
        (sin, cos)
    }

    #[inline(always)]
    fn clamp_unit(mut self) -> Self {
        for a in &mut self.0 {
            *a = a.clamp_unit();
        }
        self
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.zip(other, |a, b| a.larger(b))
    }

    #[inline]
    fn power(self, exponent: Self) -> Self {
        self.zip(exponent, |a, b| a.power(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation once, in an order that would show fused or reordered rounding.
    fn mixed<T: Real>(q: &[T; 2]) -> [T; 6] {
        let (s, c) = q[0].sin_cos();
        let (s_sum, c_sum) = (q[0] + q[1]).sin_cos();
        let third = T::from_f64(1.0 / 3.0);
        [
            s * c_sum + third,
            -(c * s_sum - q[1]),
            s_sum - third * c * s,
            (s - third) / (c_sum * c_sum + third),
            (q[0] * third).clamp_unit(),
            (q[1] * q[1]).power(s + third),
        ]
    }

    fn postures<const N: usize>(seed: usize) -> [[f64; 2]; N] {
        core::array::from_fn(|i| {
            let step = (seed * N + i) as f64;
            [0.37 * step - 4.0, 2.5 - 0.91 * step]
        })
    }

    #[test]
    fn double_lanes_have_the_bits_of_scalars() {
        for seed in 0..400 {
            let rows: [[f64; 2]; 8] = postures(seed);
            let results = unpack(&mixed(&pack(&rows)));
            for (row, result) in rows.iter().zip(results) {
                assert_eq!(mixed(row).map(f64::to_bits), result.map(f64::to_bits));
            }
        }
    }

    #[test]
    fn single_lanes_have_the_bits_of_scalars() {
        for seed in 0..40 {
            let rows = postures::<16>(seed).map(|row| row.map(|x| x as f32));
            let results = unpack(&mixed(&pack(&rows)));
            for (row, result) in rows.iter().zip(results) {
                assert_eq!(mixed(row).map(f32::to_bits), result.map(f32::to_bits));
            }
        }
    }

    #[test]
    fn a_lane_out_of_the_domain_leaves_the_others_alone() {
        let (sin, cos) = Lanes([0.1, f64::NAN, 0.3, 1e9]).sin_cos();
        assert_eq!((sin.0[0], cos.0[0]), Real::sin_cos(0.1));
        assert_eq!((sin.0[2], cos.0[2]), Real::sin_cos(0.3));
        assert!(sin.0[1].is_nan() && cos.0[3].is_nan());
    }

    #[test]
    fn a_nan_stays_in_its_lane() {
        let x = Lanes([-1.0, f64::NAN, 0.0, 9.0]);
        let y = Lanes([0.5, 1.0, 0.0, 0.5]);
        let power = x.power(y).0;
        assert!(power[0].is_nan() && power[1].is_nan());
        assert_eq!(power[2..], [1.0, 3.0]);
        assert!(x.clamp_unit().0[1].is_nan() && (x / y).0[2].is_nan());
        assert_eq!((x / y).0[3], 18.0);
        assert_eq!(x.clamp_unit().0[3], 1.0);
    }

    #[test]
    fn lanes_nest_and_convert() {
        let nested = Lanes([Lanes([0.1, 0.2]), Lanes::splat(0.3)]);
        let (sin, _) = (nested + Real::from_f64(1.0)).sin_cos();
        assert_eq!(sin.0[1].0[0], Real::sin_cos(1.3).0);
        let array: [f64; 2] = F64x2::from([1.0, 2.0]).into();
        assert_eq!(array, [1.0, 2.0]);
    }

    type F64x2 = Lanes<f64, 2>;
}
