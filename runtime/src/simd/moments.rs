//! Weighted sums of rows that lie side by side.
//!
//! ```text
//! S_m = Σ_i w_im (x_i − x_0)        Q = Σ_i (x_i − x_0)²        for each column of x
//! ```

use crate::lanes::F64x8;
use crate::scalar::Simd;
use crate::scalar::sealed::{Dispatch, Machine, Task};

impl Simd {
    /// Sums of rows from `origin`, each times its `weights`, and of their squares.
    ///
    /// Rows have as many blocks of eight columns as the origin; `sums` has M times as many, and
    /// `squares` as many. Products and sums are rounded one by one: the same bits on every set.
    ///
    /// ```
    /// use sesc_runtime::{F64x8, Simd};
    ///
    /// let rows = [1.0, 2.0, 4.0].map(F64x8::splat);
    /// let (mut sums, mut squares) = ([F64x8::splat(0.0); 2], [F64x8::splat(0.0)]);
    /// let weights = [[1.0, -1.0], [1.0, 0.0], [1.0, 1.0]];
    /// Simd::best().moments(&weights, &rows, &[F64x8::splat(1.0)], &mut sums, &mut squares);
    /// assert_eq!((sums[0].0[3], sums[1].0[3], squares[0].0[3]), (4.0, 3.0, 10.0));
    /// ```
    pub fn moments<const M: usize>(
        self,
        weights: &[[f64; M]],
        rows: &[F64x8],
        origin: &[F64x8],
        sums: &mut [F64x8],
        squares: &mut [F64x8],
    ) {
        f64::run(
            self,
            Moments {
                weights,
                rows,
                origin,
                sums,
                squares,
            },
        );
    }
}

struct Moments<'a, const M: usize> {
    weights: &'a [[f64; M]],
    rows: &'a [F64x8],
    origin: &'a [F64x8],
    sums: &'a mut [F64x8],
    squares: &'a mut [F64x8],
}

impl<const M: usize> Task<f64> for Moments<'_, M> {
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let width = self.origin.len();
        for (column, origin) in self.origin.iter().enumerate() {
            for part in 0..X::PARTS {
                let [origin] = X::load(&[*origin], part);
                let (mut own, mut square) = ([X::splat(0.0); M], X::splat(0.0));
                let rows = self.rows.iter().skip(column).step_by(width);
                for (weights, x) in self.weights.iter().zip(rows) {
                    let [x] = X::load(core::array::from_ref(x), part);
                    let x = x - origin;
                    for (sum, weight) in own.iter_mut().zip(weights) {
                        *sum = *sum + x * X::splat(*weight);
                    }
                    square = square + x * x;
                }
                let sums = self.sums.iter_mut().skip(column).step_by(width);
                for (to, sum) in sums.zip(own) {
                    X::store(&[sum], core::slice::from_mut(to), part);
                }
                if let Some(to) = self.squares.get_mut(column) {
                    X::store(&[square], core::slice::from_mut(to), part);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;
    use crate::trig::tests::Random;

    #[test]
    fn every_set_has_the_bits_of_plain_sums() {
        let (rows, width) = (13, 3);
        let mut random = Random::new(5);
        let weights: Vec<[f64; 5]> = (0..rows)
            .map(|_| core::array::from_fn(|_| random.within(2.0)))
            .collect();
        let mut block = || F64x8::from(core::array::from_fn(|_| random.within(1.0)));
        let x: Vec<F64x8> = (0..rows * width).map(|_| block()).collect();
        let origin: Vec<F64x8> = (0..width).map(|_| block()).collect();
        for simd in Simd::available() {
            let mut sums = vec![F64x8::splat(f64::NAN); 5 * width];
            let mut squares = vec![F64x8::splat(f64::NAN); width];
            simd.moments(&weights, &x, &origin, &mut sums, &mut squares);
            for at in 0..8 * width {
                let (block, lane) = (at / 8, at % 8);
                let from = |row: usize| x[row * width + block].0[lane] - origin[block].0[lane];
                let mut square = 0.0;
                (0..rows).for_each(|row| square += from(row) * from(row));
                assert_eq!(squares[block].0[lane].to_bits(), square.to_bits());
                for m in 0..5 {
                    let mut sum = 0.0;
                    (0..rows).for_each(|row| sum += from(row) * weights[row][m]);
                    let found = sums[m * width + block].0[lane];
                    assert_eq!(found.to_bits(), f64::to_bits(sum), "{} {m}", simd.name());
                }
            }
        }
    }
}
