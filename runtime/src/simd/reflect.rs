//! Rows of a least-squares problem folded into its triangle.
//!
//! ```text
//! [T; B] ← H_p … H_1 [T; B]        H_j = 1 − v vᵀ / (‖x‖ (‖x‖ + |x_1|))
//! x = (T_jj, B_·j)                 v = x ± ‖x‖ e_1
//! ```
//!
//! Householder reflections: nothing is squared, so that the condition number enters once. Below
//! T_jj the triangle has no entry, and a reflection leaves its other rows alone.

use crate::lanes::F64x8;
use crate::real::Real;
use crate::scalar::Simd;
use crate::scalar::sealed::{Dispatch, Machine, Task};

/// Blocks of eight rows that are worked through together.
const STRIDE: usize = 4;
/// Blocks of a column that stay in registers, where a register fills a block: as many again hold
/// the column that is reflected.
const HELD: usize = 2 * STRIDE;
/// Squares below this are of no reading; one over them is still a number.
const NOTHING: f64 = 1e-300;

impl Simd {
    /// Fold rows into an upper triangle, so that both have the same least-squares solution.
    ///
    /// `triangle` is a square matrix column by column, what is below its diagonal is not looked
    /// at; the last of its columns may be that of the readings. `rows` has as many columns, each
    /// of the same number of blocks of eight rows, rows of zeros where there are fewer; it is
    /// left without a meaning. Some 64 rows at a time stay in the first cache.
    ///
    /// ```
    /// use sesc_runtime::{F64x8, Simd};
    ///
    /// // x = 1, 2, …, 8 seen eight times: their mean is 4.5, and 42 is left of their squares.
    /// let mut triangle = [0.0; 4];
    /// let readings = F64x8::from([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    /// Simd::best().fold_rows(&mut triangle, &mut [F64x8::splat(1.0), readings]);
    /// assert!((triangle[2] / triangle[0] - 4.5).abs() < 1e-14);
    /// assert!((triangle[3] * triangle[3] - 42.0).abs() < 1e-13);
    /// ```
    pub fn fold_rows(self, triangle: &mut [f64], rows: &mut [F64x8]) {
        f64::run(self, FoldRows { triangle, rows });
    }

    /// Eight rows, each times its weight, as [`Simd::fold_rows`] takes them: entry k of all of
    /// them is the first block of the k-th `blocks` of `columns`. What one of the two has more of
    /// is left out.
    ///
    /// ```
    /// use sesc_runtime::{F64x8, Simd};
    ///
    /// let rows: [[f64; 3]; 8] = core::array::from_fn(|row| [row as f64, 1.0, 2.0]);
    /// let mut columns = [F64x8::splat(0.0); 6];
    /// Simd::best().weigh_rows(&rows.each_ref().map(|row| &row[..]), &[0.5; 8], &mut columns, 2);
    /// assert_eq!(columns[0].0, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5]);
    /// assert_eq!((columns[2], columns[4]), (F64x8::splat(0.5), F64x8::splat(1.0)));
    /// ```
    pub fn weigh_rows(
        self,
        rows: &[&[f64]; 8],
        weights: &[f64; 8],
        columns: &mut [F64x8],
        blocks: usize,
    ) {
        let weights = F64x8::from(*weights);
        f64::run(
            self,
            WeighRows {
                rows,
                weights,
                columns,
                blocks,
            },
        );
    }
}

struct WeighRows<'a> {
    rows: &'a [&'a [f64]; 8],
    weights: F64x8,
    columns: &'a mut [F64x8],
    blocks: usize,
}

impl Task<f64> for WeighRows<'_> {
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let columns = self.columns.chunks_mut(self.blocks.max(1) * 8);
        for (square, columns) in columns.enumerate() {
            let mut entries = [[0.0; 8]; 8];
            let mut count = 8;
            for (to, row) in entries.iter_mut().zip(self.rows) {
                let row = row.get(8 * square..).unwrap_or_default();
                match row.first_chunk() {
                    Some(row) => *to = *row,
                    None => {
                        to.iter_mut().zip(row).for_each(|(to, x)| *to = *x);
                        count = count.min(row.len());
                    }
                }
            }
            for part in 0..X::PARTS {
                let [weight] = X::load(&[self.weights], part);
                let own = X::columns(&entries, part);
                let places = columns.iter_mut().step_by(self.blocks.max(1));
                for (to, x) in places.take(count).zip(own) {
                    X::store(&[x * weight], core::slice::from_mut(to), part);
                }
            }
        }
    }
}

struct FoldRows<'a> {
    triangle: &'a mut [f64],
    rows: &'a mut [F64x8],
}

impl Task<f64> for FoldRows<'_> {
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let FoldRows { triangle, rows } = self;
        let order = root_of(triangle.len());
        let blocks = rows.len() / order.max(1);
        if blocks == 0 {
            return;
        }
        let mut rest = rows;
        let mut j = 0;
        while j < order {
            let Some((v, columns)) = rest.split_at_mut_checked(blocks) else {
                return;
            };
            rest = columns;
            let Some(first) = Reflection::of::<X>(triangle, (j, order), v) else {
                j += 1;
                continue;
            };
            if let (1, Ok(v)) = (X::PARTS, <&[F64x8; HELD]>::try_from(&*v)) {
                rest = two::<X>(triangle, (j, order), (first, v), rest);
                j += 2;
                continue;
            }
            let tops = triangle.iter_mut().skip(j * order + j).step_by(order);
            for (top, column) in tops.skip(1).zip(rest.chunks_exact_mut(blocks)) {
                let share = first.share(*top, along::<X>(v, column));
                *top = first.top(*top, share);
                reflect::<X>(v, share, column);
            }
            j += 1;
        }
    }
}

/// One reflection: what it does to the row of the triangle that it changes.
#[derive(Clone, Copy)]
struct Reflection {
    /// First entry of v.
    first: f64,
    /// 1 / (‖x‖ (‖x‖ + |x_1|))
    scale: f64,
    /// Each row has a sign of its choice: the diagonal is not negative.
    sign: f64,
}

impl Reflection {
    /// It leaves the others alone.
    const NONE: Reflection = Reflection {
        first: 0.0,
        scale: 0.0,
        sign: 1.0,
    };

    /// That which takes column `j` of the rows into the triangle; none where nothing is left in
    /// the column.
    #[inline(always)]
    fn of<X: Machine<f64>>(
        triangle: &mut [f64],
        (j, order): (usize, usize),
        column: &[F64x8],
    ) -> Option<Reflection> {
        let top = triangle.get_mut(j * order + j)?;
        let square = *top * *top + along::<X>(column, column);
        // Of fewer rows than columns each reflection leaves the rounding of the one before,
        // until a float cannot hold it.
        if square < NOTHING {
            return None;
        }
        let size = root(square);
        // Away from the first entry, so that no digits cancel.
        let diagonal = if *top > 0.0 { -size } else { size };
        let sign = if diagonal < 0.0 { -1.0 } else { 1.0 };
        let reflection = Reflection {
            first: *top - diagonal,
            scale: 1.0 / (size * (size + top.abs())),
            sign,
        };
        *top = sign * diagonal;
        Some(reflection)
    }

    /// How much of v is taken from a column with `top` in the triangle.
    #[inline(always)]
    fn share(self, top: f64, along: f64) -> f64 {
        self.scale * (self.first * top + along)
    }

    /// What becomes of the column's entry in the triangle.
    #[inline(always)]
    fn top(self, top: f64, share: f64) -> f64 {
        self.sign * (top - share * self.first)
    }
}

/// Two reflections at once, so that each column is read and written once for both: that of
/// column `j`, which is known, and that of the next one.
///
/// ```text
/// B ← B − v s − w t,    s = v_scale (v_1 T_j + vᵀ B),    t = w_scale (w_1 T_j+1 + wᵀ B − wᵀv s)
/// ```
///
/// What is left are the columns behind both.
#[inline(always)]
fn two<'a, X: Machine<f64>>(
    triangle: &mut [f64],
    (j, order): (usize, usize),
    (one, v): (Reflection, &[F64x8; HELD]),
    rest: &'a mut [F64x8],
) -> &'a mut [F64x8] {
    let v = X::load(v, 0);
    let Some((next, rest)) = rest.split_first_chunk_mut::<HELD>() else {
        return &mut [];
    };
    if let Some(top) = triangle.get_mut((j + 1) * order + j) {
        let mut own = X::load(next, 0);
        let share = one.share(*top, sum(lanes::<X>(held_along::<X>(&v, &own))));
        *top = one.top(*top, share);
        less::<X>(&mut own, &v, share);
        X::store(&own, next, 0);
    }
    let other = Reflection::of::<X>(triangle, (j + 1, order), next).unwrap_or(Reflection::NONE);
    let w = X::load(next, 0);
    let both = sum(lanes::<X>(held_along::<X>(&v, &w)));
    let tops = triangle.chunks_exact_mut(order).skip(j + 2);
    for (tops, column) in tops.zip(rest.as_chunks_mut::<HELD>().0) {
        let Some([top, below]) = tops.get_mut(j..j + 2) else {
            break;
        };
        let mut own = X::load(column, 0);
        let along_v = held_along::<X>(&v, &own);
        let along_w = held_along::<X>(&w, &own);
        let share = one.share(*top, sum(lanes::<X>(along_v)));
        *top = one.top(*top, share);
        let after = other.share(*below, sum(lanes::<X>(along_w)) - share * both);
        *below = other.top(*below, after);
        less::<X>(&mut own, &v, share);
        less::<X>(&mut own, &w, after);
        X::store(&own, column, 0);
    }
    rest
}

/// column −= share · v
#[inline(always)]
fn less<X: Machine<f64>>(column: &mut [X::Vector; HELD], v: &[X::Vector; HELD], share: f64) {
    let less = X::splat(-share);
    for (x, v) in column.iter_mut().zip(v) {
        *x = v.mul_plus(less, *x);
    }
}

/// Σ a_i b_i.
#[inline(always)]
fn along<X: Machine<f64>>(a: &[F64x8], b: &[F64x8]) -> f64 {
    let mut sums = [F64x8::splat(0.0); STRIDE];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<STRIDE>(), b.as_chunks::<STRIDE>());
    for part in 0..X::PARTS {
        let mut own = [X::splat(0.0); STRIDE];
        for (a, b) in a.iter().zip(b) {
            let (a, b) = (X::load(a, part), X::load(b, part));
            for (sum, (a, b)) in own.iter_mut().zip(a.iter().zip(&b)) {
                *sum = a.mul_plus(*b, *sum);
            }
        }
        for (a, b) in a_rest.iter().zip(b_rest) {
            let [a, b] = X::load(&[*a, *b], part);
            own[0] = a.mul_plus(b, own[0]);
        }
        let [a, b, c, d] = own;
        X::store(&[(a + b) + (c + d)], &mut sums, part);
    }
    sum(sums[0])
}

/// Sums of a_i b_i of columns in registers, lane by lane.
#[inline(always)]
fn held_along<X: Machine<f64>>(a: &[X::Vector; HELD], b: &[X::Vector; HELD]) -> X::Vector {
    let mut own = [X::splat(0.0); 2];
    for (a, b) in a.chunks_exact(2).zip(b.chunks_exact(2)) {
        for (sum, (a, b)) in own.iter_mut().zip(a.iter().zip(b)) {
            *sum = a.mul_plus(*b, *sum);
        }
    }
    let [a, b] = own;
    a + b
}

#[inline(always)]
fn lanes<X: Machine<f64>>(vector: X::Vector) -> F64x8 {
    let mut lanes = [F64x8::splat(0.0)];
    X::store(&[vector], &mut lanes, 0);
    lanes[0]
}

/// Σ of the lanes.
#[inline(always)]
fn sum(lanes: F64x8) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes.0;
    let [a, b, c, d] = [a + e, b + f, c + g, d + h];
    let [a, b] = [a + c, b + d];
    a + b
}

/// column −= share · v
#[inline(always)]
fn reflect<X: Machine<f64>>(v: &[F64x8], share: f64, column: &mut [F64x8]) {
    let less = X::splat(-share);
    let (v, v_rest) = v.as_chunks::<STRIDE>();
    let (column, column_rest) = column.as_chunks_mut::<STRIDE>();
    for part in 0..X::PARTS {
        for (v, x) in v.iter().zip(column.iter_mut()) {
            let (v, mut own) = (X::load(v, part), X::load(x, part));
            for (x, v) in own.iter_mut().zip(&v) {
                *x = v.mul_plus(less, *x);
            }
            X::store(&own, x, part);
        }
        for (v, x) in v_rest.iter().zip(column_rest.iter_mut()) {
            let [v, own] = X::load(&[*v, *x], part);
            X::store(&[v.mul_plus(less, own)], core::slice::from_mut(x), part);
        }
    }
}

/// √x: one instruction of most processors, which `core` alone does not have.
#[inline(always)]
fn root(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    crate::scalar::Scalar::root(x)
}

/// The order of a square matrix of so many numbers.
fn root_of(numbers: usize) -> usize {
    let mut order = 0;
    while (order + 1) * (order + 1) <= numbers {
        order += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;
    use crate::trig::tests::Random;

    /// Products of columns are what reflections leave alone.
    #[test]
    fn the_triangle_has_the_products_of_all_rows() {
        for simd in Simd::available() {
            for (order, panels) in [
                (1, vec![1]),
                (3, vec![1, 5]),
                (7, vec![4, 1, 9]),
                (44, vec![8; 3]),
            ] {
                let mut random = Random::new(order as u64);
                let mut triangle = vec![0.0; order * order];
                let mut products = vec![0.0; order * order];
                for blocks in panels {
                    let mut column = || F64x8::from(core::array::from_fn(|_| random.within(1.0)));
                    let mut rows: Vec<F64x8> = (0..order * blocks).map(|_| column()).collect();
                    // A column that no row sees.
                    rows[(order / 2) * blocks..(order / 2 + 1) * blocks].fill(F64x8::splat(0.0));
                    let flat: Vec<&[F64x8]> = rows.chunks_exact(blocks).collect();
                    for (at, product) in products.iter_mut().enumerate() {
                        let (a, b) = (flat[at / order], flat[at % order]);
                        let pairs = a.iter().flat_map(|a| a.0).zip(b.iter().flat_map(|b| b.0));
                        *product += pairs.map(|(a, b)| a * b).sum::<f64>();
                    }
                    simd.fold_rows(&mut triangle, &mut rows);
                }
                for (at, product) in products.iter().enumerate() {
                    let column = |k: usize| &triangle[k * order..k * order + k + 1];
                    let (a, b) = (column(at / order), column(at % order));
                    let found: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                    let off = (found - product).abs();
                    assert!(off < 1e-11, "{} {order}: {off}", simd.name());
                }
                assert!((0..order).all(|k| triangle[k * order + k] >= 0.0));
            }
        }
    }

    #[test]
    fn every_set_weighs_rows_of_any_length() {
        for (width, wanted, blocks) in [(0, 1, 1), (1, 1, 3), (5, 9, 1), (8, 8, 2), (19, 18, 8)] {
            let mut random = Random::new(width as u64);
            let flat: Vec<f64> = (0..8 * width).map(|_| random.within(1.0)).collect();
            let rows = core::array::from_fn(|row| &flat[row * width..(row + 1) * width]);
            let weights = core::array::from_fn(|_| random.within(2.0));
            for simd in Simd::available() {
                let mut columns = vec![F64x8::splat(7.0); wanted * blocks];
                simd.weigh_rows(&rows, &weights, &mut columns, blocks);
                for (at, column) in columns.iter().enumerate() {
                    let k = at / blocks;
                    let expected = match at % blocks == 0 && k < width {
                        true => core::array::from_fn(|row| weights[row] * rows[row][k]),
                        false => [7.0; 8],
                    };
                    assert_eq!(column.0, expected, "{} {width} {at}", simd.name());
                }
            }
        }
    }

    #[test]
    fn rows_that_are_no_numbers_leave_none() {
        let mut triangle = [1.0, 0.0, 2.0, 3.0];
        let mut rows = [F64x8::splat(f64::NAN), F64x8::splat(1.0)];
        Simd::PORTABLE.fold_rows(&mut triangle, &mut rows);
        assert!(triangle[0].is_nan() && triangle[3].is_nan());
    }
}
