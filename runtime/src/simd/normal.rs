//! Sums of products over many postures: what least squares needs of them.
//!
//! ```text
//! G = Σ w² Yᵀ Y      g = Σ w² Yᵀ cop             in one pass
//! g = Σ w² Yᵀ e      Σ w² e²                    e = cop − Y r, in another
//! ```
//!
//! Regressor rows of 192 postures lie in the second cache, in strips of five columns; tiles
//! of 5 × 5 sums, each in a register, run over two strips at a time. Strips i and i + 1 stay
//! in the first cache while all strips before them pass.

use core::marker::PhantomData;

use crate::__private::v1::{Array, Robot};
use crate::dim::{Const, Dim};
use crate::lanes::F64x8;
use crate::real::Real;
use crate::scalar::sealed::{Machine, Task};

/// Postures of a block.
const LANES: usize = 8;
/// Rows of blocks that are worked through together: x and y of 192 postures.
const PANEL: usize = 48;
/// Columns of a strip: 25 sums and 6 factors fill the registers of AVX-512.
const STRIP: usize = 5;

/// Postures, readings, and what to hold them against.
pub(crate) struct Data<'a, M: Robot> {
    pub q: &'a [Array<M::Dof, f64>],
    pub cop: &'a [[f64; 2]],
    /// 1/std of x and y.
    pub weight: [f64; 2],
    pub model: PhantomData<M>,
}

/// The sums of a range of postures.
pub(crate) struct Sums<const N: usize> {
    /// Lower triangle and more.
    pub gram: [[f64; N]; N],
    pub right: [f64; N],
    pub square: f64,
}

impl<const N: usize> Sums<N> {
    pub(crate) fn zero() -> Self {
        Self {
            gram: [[0.0; N]; N],
            right: [0.0; N],
            square: 0.0,
        }
    }

    pub(crate) fn is_finite(&self) -> bool {
        let lines = self.gram.iter().zip(0..);
        lines
            .flat_map(|(line, i)| &line[..=i])
            .chain(&self.right)
            .all(|x| x.is_finite())
    }
}

/// The first pass, over whole blocks of the data.
pub(crate) struct Products<'a, 'd, M: Robot, const BASE: usize> {
    pub data: &'a Data<'d, M>,
    pub sums: &'a mut Sums<BASE>,
}

/// The second, over whole blocks: residuals of `params`.
pub(crate) struct Residuals<'a, 'd, M: Robot, const BASE: usize> {
    pub data: &'a Data<'d, M>,
    pub params: [f64; BASE],
    pub sums: &'a mut Sums<BASE>,
}

impl<M, const BASE: usize> Task<f64> for Products<'_, '_, M, BASE>
where
    M: Robot<Base = Const<BASE>>,
{
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let zero = F64x8::splat(0.0);
        let mut gram = [[zero; BASE]; BASE];
        let mut right = [zero; BASE];
        let mut panel = [[zero; BASE]; PANEL];
        let panel = panel.as_flattened_mut();
        let mut rows = [[X::splat(0.0); BASE]; 2];
        let weight = self.data.weight.map(X::splat);
        let (q, _) = self.data.q.as_chunks::<LANES>();
        let (cop, _) = self.data.cop.as_chunks::<LANES>();
        for (q, cop) in q.chunks(PANEL / 2).zip(cop.chunks(PANEL / 2)) {
            for (block, (q, cop)) in q.iter().zip(cop).enumerate() {
                for part in 0..X::PARTS {
                    M::regressor_cop_into(&<M::Dof as Dim>::columns::<f64, X>(q, part), &mut rows);
                    let readings = X::columns(cop, part);
                    for axis in 0..2 {
                        let reading = readings[axis] * weight[axis];
                        let line = 2 * block + axis;
                        let (strips, rest) = rows[axis].as_chunks::<STRIP>();
                        let (rights, right_rest) = right.as_chunks_mut::<STRIP>();
                        for (k, (y, right)) in strips.iter().zip(rights).enumerate() {
                            let place = panel.get_mut((k * PANEL + line) * STRIP..);
                            if let Some(place) = place.and_then(|p| p.first_chunk_mut::<STRIP>()) {
                                let y = y.map(|y| y * weight[axis]);
                                X::store(&y, place, part);
                                let mut sums = X::load(right, part);
                                for (sum, y) in sums.iter_mut().zip(&y) {
                                    *sum = y.mul_plus(reading, *sum);
                                }
                                X::store(&sums, right, part);
                            }
                        }
                        let place =
                            panel.get_mut(strips.len() * PANEL * STRIP + line * rest.len()..);
                        let places = place.unwrap_or(&mut []).iter_mut();
                        for ((y, place), right) in rest.iter().zip(places).zip(right_rest) {
                            let y = *y * weight[axis];
                            X::store(&[y], core::slice::from_mut(place), part);
                            let [sum] = X::load(&[*right], part);
                            let sum = y.mul_plus(reading, sum);
                            X::store(&[sum], core::slice::from_mut(right), part);
                        }
                    }
                }
            }
            tiles::<X, BASE>(panel, 2 * q.len(), &mut gram);
        }
        for (line, lanes) in self.sums.gram.iter_mut().zip(&gram) {
            for (sum, lanes) in line.iter_mut().zip(lanes) {
                *sum += total(lanes);
            }
        }
        for (sum, lanes) in self.sums.right.iter_mut().zip(&right) {
            *sum += total(lanes);
        }
    }
}

impl<M, const BASE: usize> Task<f64> for Residuals<'_, '_, M, BASE>
where
    M: Robot<Base = Const<BASE>>,
{
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let zero = F64x8::splat(0.0);
        let (mut right, mut square) = ([zero; BASE], [zero]);
        let mut rows = [[X::splat(0.0); BASE]; 2];
        let params: [X::Vector; BASE] = core::array::from_fn(|k| X::splat(self.params[k]));
        let weight = self.data.weight.map(X::splat);
        let (q, _) = self.data.q.as_chunks::<LANES>();
        let (cop, _) = self.data.cop.as_chunks::<LANES>();
        for (q, cop) in q.iter().zip(cop) {
            for part in 0..X::PARTS {
                M::regressor_cop_into(&<M::Dof as Dim>::columns::<f64, X>(q, part), &mut rows);
                let readings = X::columns(cop, part);
                let [mut squares] = X::load(&square, part);
                let mut weighed = [X::splat(0.0); 2];
                for axis in 0..2 {
                    // Four sums, of which none waits for another.
                    let mut predicted = [X::splat(0.0); 4];
                    for (k, (y, r)) in rows[axis].iter().zip(&params).enumerate() {
                        predicted[k % 4] = y.mul_plus(*r, predicted[k % 4]);
                    }
                    let [a, b, c, d] = predicted;
                    let e = (readings[axis] - ((a + b) + (c + d))) * weight[axis];
                    weighed[axis] = e * weight[axis];
                    squares = e.mul_plus(e, squares);
                }
                for ((right, x), y) in right.iter_mut().zip(&rows[0]).zip(&rows[1]) {
                    let [sum] = X::load(core::array::from_ref(right), part);
                    let sum = y.mul_plus(weighed[1], x.mul_plus(weighed[0], sum));
                    X::store(&[sum], core::slice::from_mut(right), part);
                }
                X::store(&[squares], &mut square, part);
            }
        }
        for (sum, lanes) in self.sums.right.iter_mut().zip(&right) {
            *sum += total(lanes);
        }
        self.sums.square += total(&square[0]);
    }
}

/// Pairwise.
fn total(lanes: &F64x8) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes.0;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

/// `gram += panelᵀ panel` in its lower triangle, over the first `rows` of every strip.
#[inline(always)]
fn tiles<X: Machine<f64>, const N: usize>(
    panel: &[F64x8],
    rows: usize,
    gram: &mut [[F64x8; N]; N],
) {
    let strips = N.div_ceil(STRIP);
    for first in (0..strips).step_by(2) {
        for j in 0..strips.min(first + 2) {
            for i in first.max(j)..strips.min(first + 2) {
                let (a, b) = (strip(panel, i, N), strip(panel, j, N));
                let at = (i * STRIP, j * STRIP);
                // Only the last strip is narrower.
                match ((N - at.0).min(STRIP), i == j) {
                    (1, true) => tile::<X, N, 1, 1>(a, b, rows, gram, at),
                    (2, true) => tile::<X, N, 2, 2>(a, b, rows, gram, at),
                    (3, true) => tile::<X, N, 3, 3>(a, b, rows, gram, at),
                    (4, true) => tile::<X, N, 4, 4>(a, b, rows, gram, at),
                    (1, false) => tile::<X, N, 1, STRIP>(a, b, rows, gram, at),
                    (2, false) => tile::<X, N, 2, STRIP>(a, b, rows, gram, at),
                    (3, false) => tile::<X, N, 3, STRIP>(a, b, rows, gram, at),
                    (4, false) => tile::<X, N, 4, STRIP>(a, b, rows, gram, at),
                    _ => tile::<X, N, STRIP, STRIP>(a, b, rows, gram, at),
                }
            }
        }
    }
}

/// Columns of strip k, line after line.
#[inline(always)]
fn strip(panel: &[F64x8], k: usize, columns: usize) -> &[F64x8] {
    let end = ((k + 1) * STRIP).min(columns);
    panel.get(k * STRIP * PANEL..end * PANEL).unwrap_or(&[])
}

/// A × B sums, from line and column `at` on.
#[inline(always)]
fn tile<X: Machine<f64>, const N: usize, const A: usize, const B: usize>(
    a: &[F64x8],
    b: &[F64x8],
    rows: usize,
    gram: &mut [[F64x8; N]; N],
    at: (usize, usize),
) {
    for part in 0..X::PARTS {
        let mut sums = [[X::splat(0.0); B]; A];
        let (a, b) = (a.as_chunks::<A>().0, b.as_chunks::<B>().0);
        for (a, b) in a.iter().zip(b).take(rows) {
            let (a, b) = (X::load(a, part), X::load(b, part));
            for (sums, a) in sums.iter_mut().zip(&a) {
                for (sum, b) in sums.iter_mut().zip(&b) {
                    *sum = a.mul_plus(*b, *sum);
                }
            }
        }
        for (line, sums) in gram.iter_mut().skip(at.0).zip(&sums) {
            let line = line
                .get_mut(at.1..)
                .and_then(|line| line.first_chunk_mut::<B>());
            if let Some(line) = line {
                let mut before = X::load(line, part);
                for (before, sum) in before.iter_mut().zip(sums) {
                    *before = *before + *sum;
                }
                X::store(&before, line, part);
            }
        }
    }
}
