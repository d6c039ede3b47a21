//! Least-squares problems as triangular factors that can be grown and merged.
//!
//! ```text
//! [Φ y] = Q [R z]        ‖Φ r − y‖² = ‖R r − z‖² + ρ²
//!           [0 ρ]
//! ```
//!
//! Householder reflections fold new rows into the triangle, 64 at a time on the widest
//! registers of the machine ([`Simd::fold_rows`]), so memory does not depend on the number of
//! rows, nothing is squared, and the factors of parts of the data fold into the factor of the
//! whole.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sesc_model::standard::Shift;
use sesc_runtime::{F64x8, Simd};

use crate::observations::row_matrix::RowMatrix;

/// What is left of `rows` rows: everything that least squares needs of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct Factor {
    /// Upper triangle of order p + 1; the last column belongs to the readings.
    triangle: DMatrix<f64>,
    rows: u64,
}

impl Factor {
    /// No rows yet, `params` columns.
    pub fn new(params: usize) -> Factor {
        Factor {
            triangle: DMatrix::zeros(params + 1, params + 1),
            rows: 0,
        }
    }

    /// Number of parameters.
    pub fn params(&self) -> usize {
        self.triangle.ncols() - 1
    }

    /// Number of rows folded in.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Fold in rows, each times its weight (1/standard deviation).
    pub fn push(&mut self, matrix: &DMatrix<f64>, reading: &DVector<f64>, weight: &[f64]) {
        let rows = RowMatrix {
            entries: matrix.transpose().as_slice().to_vec(),
            columns: matrix.ncols(),
        };
        self.push_rows(&rows, reading, weight.iter().copied().enumerate());
    }

    /// Fold in some of the rows, each by its number and its weight.
    pub fn push_rows(
        &mut self,
        matrix: &RowMatrix,
        reading: &DVector<f64>,
        chosen: impl IntoIterator<Item = (usize, f64)>,
    ) {
        let params = self.params();
        let nothing = F64x8::splat(0.0);
        let mut panel = vec![nothing; (params + 1) * BLOCKS];
        let mut chosen = chosen.into_iter();
        loop {
            let mut blocks = 0;
            while blocks < BLOCKS {
                // Rows that are missing weigh nothing.
                let mut eight = [(0, 0.0); 8];
                let places = eight.iter_mut().zip(&mut chosen);
                let count = places.map(|(place, own)| *place = own).count();
                if count == 0 {
                    break;
                }
                let (columns, readings) = panel.split_at_mut(params * BLOCKS);
                if let Some(columns) = columns.get_mut(blocks..) {
                    let rows = eight.map(|(row, _)| matrix.row(row));
                    let weights = eight.map(|(_, weight)| weight);
                    Simd::best().weigh_rows(&rows, &weights, columns, BLOCKS);
                }
                readings[blocks].0 = eight.map(|(row, weight)| weight * reading[row]);
                self.rows += count as u64;
                blocks += 1;
            }
            if blocks == 0 {
                return;
            }
            // Of rows before there may be something left where blocks are missing.
            for column in panel.chunks_exact_mut(BLOCKS) {
                column[blocks..].fill(nothing);
            }
            Simd::best().fold_rows(self.triangle.as_mut_slice(), &mut panel);
        }
    }

    /// Fold in the rows of another factor with the same parameters.
    pub fn merge(&mut self, other: &Factor) {
        fold(&mut self.triangle, other.triangle.clone());
        self.rows += other.rows;
    }

    /// The factor of the same rows, each times `scale`.
    pub fn scaled(&self, scale: f64) -> Factor {
        Factor {
            triangle: &self.triangle * scale,
            rows: self.rows,
        }
    }

    /// The same rows about parameters r' with r = matrix · r' + offset.
    pub fn shifted(&self, shift: &Shift) -> Factor {
        let p = self.params();
        let mut triangle = self.triangle.clone();
        triangle
            .view_mut((0, 0), (p, p))
            .copy_from(&(self.r() * &shift.matrix));
        triangle
            .view_mut((0, p), (p, 1))
            .copy_from(&(self.z() - self.r() * &shift.offset));
        Factor {
            triangle: triangle.qr().r(),
            rows: self.rows,
        }
    }

    /// Its largest entry; NaN where one is no number.
    pub(crate) fn largest(&self) -> f64 {
        let sizes = self.triangle.iter().map(|x| x.abs());
        sizes.fold(0.0, |most, x| if x > most || x.is_nan() { x } else { most })
    }

    /// R, p × p.
    pub fn r(&self) -> DMatrix<f64> {
        let p = self.params();
        self.triangle.view((0, 0), (p, p)).into_owned()
    }

    /// z: p.
    pub fn z(&self) -> DVector<f64> {
        let p = self.params();
        self.triangle.view((0, p), (p, 1)).column(0).into_owned()
    }

    /// Σ of squared (weighted) residuals with parameters `params`.
    pub fn residual_sum(&self, params: &DVector<f64>) -> f64 {
        let p = self.params();
        let rest = self.triangle[(p, p)];
        (self.r() * params - self.z()).norm_squared() + rest * rest
    }
}

/// Blocks of eight rows that are folded in together: they stay in the first cache.
const BLOCKS: usize = 8;

/// Fold the rows of another triangle into a triangle, column by column.
///
/// ```text
/// x = (T_jj, B_·j)    v = x ± ‖x‖ e_1    [T; B] ← [T; B] − v (vᵀ [T; B]) / (‖x‖ (‖x‖ + |x_1|))
/// ```
///
/// Below T_jj the triangle has no entry, so that reflections leave its other rows alone, and
/// need rows 0 to j of the other triangle alone.
fn fold(triangle: &mut DMatrix<f64>, mut below: DMatrix<f64>) {
    let order = triangle.ncols();
    let (top, rows) = (triangle.as_mut_slice(), below.as_mut_slice());
    for j in 0..order {
        let (done, rest) = rows.split_at_mut((j + 1) * order);
        let end = j + 1;
        let v = &done[j * order..j * order + end];
        let first = top[j * order + j];
        let square = first * first + dot(v, v);
        // Nothing is left in this column: of fewer rows than columns each reflection leaves the
        // rounding of the one before, until a float cannot hold one over it.
        if square < 1e-300 {
            continue;
        }
        let size = square.sqrt();
        // Away from the first entry, so that no digits cancel.
        let diagonal = if first > 0.0 { -size } else { size };
        let v_first = first - diagonal;
        let scale = 1.0 / (size * (size + first.abs()));
        top[j * order + j] = diagonal;
        for (k, column) in (j + 1..order).zip(rest.chunks_exact_mut(order)) {
            let (at, column) = (k * order + j, &mut column[..end]);
            let along = scale * (v_first * top[at] + dot(v, column));
            top[at] -= along * v_first;
            column.iter_mut().zip(v).for_each(|(x, v)| *x -= along * v);
        }
        // Each row has a sign of its choice: the diagonal is not negative.
        if diagonal < 0.0 {
            (j..order).for_each(|k| top[k * order + j] = -top[k * order + j]);
        }
    }
}

/// Σ a_i b_i in eight sums, which a processor adds up side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, a_rest) = a.as_chunks::<8>();
    let (b, b_rest) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// A factor as it is written down.
#[derive(Serialize, Deserialize)]
struct Packed {
    /// Rows that were folded in.
    rows: u64,
    /// The upper triangle, row by row.
    triangle: Vec<f64>,
}

/// Entries of an upper triangle, row by row.
fn upper(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..order).flat_map(move |row| (row..order).map(move |k| (row, k)))
}

impl From<Factor> for Packed {
    fn from(factor: Factor) -> Packed {
        let entries = upper(factor.triangle.nrows());
        Packed {
            rows: factor.rows,
            triangle: entries.map(|at| factor.triangle[at]).collect(),
        }
    }
}

impl TryFrom<Packed> for Factor {
    type Error = &'static str;

    fn try_from(packed: Packed) -> Result<Factor, Self::Error> {
        // order (order + 1) / 2 numbers
        let order = (2 * packed.triangle.len()).isqrt();
        if order == 0 || order * (order + 1) / 2 != packed.triangle.len() {
            return Err("numbers that are no triangle");
        }
        let mut factor = Factor::new(order - 1);
        factor.rows = packed.rows;
        for (at, x) in upper(order).zip(packed.triangle) {
            factor.triangle[at] = x;
        }
        Ok(factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(n: usize) -> (DMatrix<f64>, DVector<f64>) {
        let entry = |i: usize, j: usize| ((i * 7 + j * 13 + i * j) as f64 * 0.7).sin();
        let matrix = DMatrix::from_fn(n, 4, entry);
        let reading = DVector::from_fn(n, |i, _| ((i * i) as f64).cos());
        (matrix, reading)
    }

    #[test]
    fn parts_merge_into_the_whole() {
        let (matrix, reading) = problem(60);
        let weight: Vec<f64> = (0..60).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
        let mut whole = Factor::new(4);
        whole.push(&matrix, &reading, &weight);
        let mut parts = Vec::new();
        for range in [0..7, 7..31, 31..60] {
            let mut part = Factor::new(4);
            let (at, len) = (range.start, range.len());
            part.push(
                &matrix.rows(at, len).into_owned(),
                &reading.rows(at, len).into_owned(),
                &weight[range],
            );
            parts.push(part);
        }
        let mut merged = Factor::new(4);
        for part in &parts {
            merged.merge(part);
        }
        assert_eq!(merged.rows(), 60);
        let params = DVector::from_vec(vec![0.3, -0.2, 0.9, 0.1]);
        let direct: f64 = (&matrix * &params - &reading)
            .iter()
            .zip(&weight)
            .map(|(e, w)| (e * w).powi(2))
            .sum();
        for factor in [&whole, &merged] {
            assert!((factor.residual_sum(&params) - direct).abs() < 1e-11 * direct);
        }
        let text = serde_json::to_string(&merged).unwrap();
        let back: Factor = serde_json::from_str(&text).unwrap();
        assert_eq!(back, merged_triangle(&merged));
        for odd in [0, 2, 16] {
            let text = format!("{{\"rows\": 1, \"triangle\": {:?}}}", vec![1.0; odd]);
            assert!(serde_json::from_str::<Factor>(&text).is_err());
        }
    }

    /// In two rows of sixty columns all but two columns are rounding, of rounding, of rounding.
    #[test]
    fn fewer_rows_than_columns_stay_numbers() {
        let entry = |i: usize, j: usize| ((i * 7 + j * 13 + i * j) as f64 * 0.7).sin();
        let mut factor = Factor::new(60);
        let mut direct = 0.0;
        let params = DVector::from_fn(60, |k, _| (k as f64 * 0.3).cos());
        for part in 0..3 {
            let matrix = DMatrix::from_fn(2, 60, |i, j| entry(2 * part + i, j));
            let reading = DVector::from_fn(2, |i, _| i as f64 - part as f64);
            let mut own = Factor::new(60);
            own.push(&matrix, &reading, &[1.0; 2]);
            factor.merge(&own);
            direct += (&matrix * &params - reading).norm_squared();
        }
        let found = factor.residual_sum(&params);
        assert!((found - direct).abs() < 1e-10 * direct, "{found} {direct}");
        assert_eq!(factor.triangle, factor.triangle.upper_triangle());
    }

    /// What a file keeps: the upper triangle alone.
    fn merged_triangle(factor: &Factor) -> Factor {
        Factor {
            triangle: factor.triangle.upper_triangle(),
            rows: factor.rows,
        }
    }
}
