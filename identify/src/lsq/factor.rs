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
        let order = other.triangle.ncols();
        let blocks = order.div_ceil(8);
        let mut rows = vec![F64x8::splat(0.0); order * blocks];
        let columns = other.triangle.column_iter();
        for (column, own) in columns.zip(rows.chunks_exact_mut(blocks)) {
            let places = own.iter_mut().flat_map(|block| &mut block.0);
            places.zip(&column).for_each(|(place, x)| *place = *x);
        }
        Simd::best().fold_rows(self.triangle.as_mut_slice(), &mut rows);
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
