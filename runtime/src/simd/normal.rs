//! Sums of products over many postures: what least squares needs of them.
//!
//! ```text
//! G = Σ w² Yᵀ Y      g = Σ w² Yᵀ cop             in one pass
//! g = Σ w² Yᵀ e      Σ w² e²                    e = cop − Y r, in another
//! ```
//!
//! Regressor rows of 64 postures stay in the first cache while tiles of 5 × 5 sums, each
//! in a register, run over them.

use core::marker::PhantomData;

use super::sealed::{Machine, Task};
use crate::lanes::{F64x8, pack};
use crate::model::Sesc;
use crate::real::Real;

/// Postures of a block.
const LANES: usize = 8;
/// Rows of blocks that are worked through together: x and y of 64 postures.
const PANEL: usize = 16;
/// Columns and lines of a tile: 25 sums and 10 factors fill the registers of AVX-512.
const TILE: usize = 5;

/// Postures, readings, and what to hold them against.
pub(crate) struct Data<'a, M, const DOF: usize, const BASE: usize, const FULL: usize> {
    pub q: &'a [[f64; DOF]],
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
    pub fn zero() -> Self {
        Self {
            gram: [[0.0; N]; N],
            right: [0.0; N],
            square: 0.0,
        }
    }

    pub fn is_finite(&self) -> bool {
        let lines = self.gram.iter().zip(0..);
        lines
            .flat_map(|(line, i)| &line[..=i])
            .chain(&self.right)
            .all(|x| x.is_finite())
    }
}

/// The first pass, over whole blocks of the data.
pub(crate) struct Products<'a, 'd, M, const DOF: usize, const BASE: usize, const FULL: usize> {
    pub data: &'a Data<'d, M, DOF, BASE, FULL>,
    pub sums: &'a mut Sums<BASE>,
}

/// The second, over whole blocks: residuals of `params`.
pub(crate) struct Residuals<'a, 'd, M, const DOF: usize, const BASE: usize, const FULL: usize> {
    pub data: &'a Data<'d, M, DOF, BASE, FULL>,
    pub params: [f64; BASE],
    pub sums: &'a mut Sums<BASE>,
}

impl<M, const DOF: usize, const BASE: usize, const FULL: usize> Task<f64>
    for Products<'_, '_, M, DOF, BASE, FULL>
where
    M: Sesc<DOF, BASE, FULL>,
{
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let zero = F64x8::splat(0.0);
        let mut gram = [[zero; BASE]; BASE];
        let mut right = [zero; BASE];
        let mut panel = [[zero; BASE]; PANEL];
        let weight = self.data.weight.map(X::splat);
        let (q, _) = self.data.q.as_chunks::<LANES>();
        let (cop, _) = self.data.cop.as_chunks::<LANES>();
        for (q, cop) in q.chunks(PANEL / 2).zip(cop.chunks(PANEL / 2)) {
            let (lines, _) = panel.as_chunks_mut::<2>();
            for ((q, cop), lines) in q.iter().zip(cop).zip(lines) {
                let (q, cop): ([F64x8; DOF], [F64x8; 2]) = (pack(q), pack(cop));
                for part in 0..X::PARTS {
                    let rows = M::regressor_cop(&X::load(&q, part));
                    let readings = X::load(&cop, part);
                    let mut sums = X::load(&right, part);
                    for axis in 0..2 {
                        let reading = readings[axis] * weight[axis];
                        let row = rows[axis].map(|y| y * weight[axis]);
                        for (sum, y) in sums.iter_mut().zip(&row) {
                            *sum = y.mul_add(reading, *sum);
                        }
                        X::store(&row, &mut lines[axis], part);
                    }
                    X::store(&sums, &mut right, part);
                }
            }
            tiles::<X, BASE>(&panel[..2 * q.len()], &mut gram);
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

impl<M, const DOF: usize, const BASE: usize, const FULL: usize> Task<f64>
    for Residuals<'_, '_, M, DOF, BASE, FULL>
where
    M: Sesc<DOF, BASE, FULL>,
{
    #[inline(always)]
    fn run<X: Machine<f64>>(self) {
        let zero = F64x8::splat(0.0);
        let (mut right, mut square) = ([zero; BASE], [zero]);
        let params: [X::Vector; BASE] = core::array::from_fn(|k| X::splat(self.params[k]));
        let weight = self.data.weight.map(X::splat);
        let (q, _) = self.data.q.as_chunks::<LANES>();
        let (cop, _) = self.data.cop.as_chunks::<LANES>();
        for (q, cop) in q.iter().zip(cop) {
            let (q, cop): ([F64x8; DOF], [F64x8; 2]) = (pack(q), pack(cop));
            for part in 0..X::PARTS {
                let rows = M::regressor_cop(&X::load(&q, part));
                let readings = X::load(&cop, part);
                let [mut squares] = X::load(&square, part);
                let mut sums = X::load(&right, part);
                for axis in 0..2 {
                    // Four sums, of which none waits for another.
                    let mut foretold = [X::splat(0.0); 4];
                    for (k, (y, r)) in rows[axis].iter().zip(&params).enumerate() {
                        foretold[k % 4] = y.mul_add(*r, foretold[k % 4]);
                    }
                    let [a, b, c, d] = foretold;
                    let e = (readings[axis] - ((a + b) + (c + d))) * weight[axis];
                    let weighed = e * weight[axis];
                    for (sum, y) in sums.iter_mut().zip(&rows[axis]) {
                        *sum = y.mul_add(weighed, *sum);
                    }
                    squares = e.mul_add(e, squares);
                }
                X::store(&sums, &mut right, part);
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

/// `gram += panelᵀ panel` in its lower triangle.
#[inline(always)]
fn tiles<X: Machine<f64>, const N: usize>(panel: &[[F64x8; N]], gram: &mut [[F64x8; N]; N]) {
    let whole = N - N % TILE;
    for i in (0..whole).step_by(TILE) {
        for j in (0..=i).step_by(TILE) {
            tile::<X, N, TILE, TILE>(panel, gram, i, j);
        }
    }
    // The last lines are fewer than a tile has.
    for j in (0..whole).step_by(TILE) {
        match N % TILE {
            1 => tile::<X, N, 1, TILE>(panel, gram, whole, j),
            2 => tile::<X, N, 2, TILE>(panel, gram, whole, j),
            3 => tile::<X, N, 3, TILE>(panel, gram, whole, j),
            4 => tile::<X, N, 4, TILE>(panel, gram, whole, j),
            _ => (),
        }
    }
    match N % TILE {
        1 => tile::<X, N, 1, 1>(panel, gram, whole, whole),
        2 => tile::<X, N, 2, 2>(panel, gram, whole, whole),
        3 => tile::<X, N, 3, 3>(panel, gram, whole, whole),
        4 => tile::<X, N, 4, 4>(panel, gram, whole, whole),
        _ => (),
    }
}

/// Lines `i`, columns `j` onwards, A × B of them.
#[inline(always)]
fn tile<X: Machine<f64>, const N: usize, const A: usize, const B: usize>(
    panel: &[[F64x8; N]],
    gram: &mut [[F64x8; N]; N],
    i: usize,
    j: usize,
) {
    for part in 0..X::PARTS {
        let mut sums = [[X::splat(0.0); B]; A];
        for row in panel {
            let (Some(a), Some(b)) = (
                row.get(i..).and_then(|row| row.first_chunk::<A>()),
                row.get(j..).and_then(|row| row.first_chunk::<B>()),
            ) else {
                return;
            };
            let (a, b) = (X::load(a, part), X::load(b, part));
            for (sums, a) in sums.iter_mut().zip(&a) {
                for (sum, b) in sums.iter_mut().zip(&b) {
                    *sum = a.mul_add(*b, *sum);
                }
            }
        }
        for (line, sums) in gram.iter_mut().skip(i).zip(&sums) {
            if let Some(line) = line
                .get_mut(j..)
                .and_then(|line| line.first_chunk_mut::<B>())
            {
                let mut before = X::load(line, part);
                for (before, sum) in before.iter_mut().zip(sums) {
                    *before = *before + *sum;
                }
                X::store(&before, line, part);
            }
        }
    }
}
