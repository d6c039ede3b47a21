//! Rows of a regressor as a tape writes them: one after the other.
//!
//! ```text
//! entries[row · columns + column]
//! ```
//!
//! Matrices of nalgebra lie column by column; a million rows are not turned for nothing.

use std::ops::Index;

use nalgebra::{DMatrix, DVector};

/// A matrix whose rows lie one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RowMatrix {
    /// Row after row.
    pub entries: Vec<f64>,
    /// Entries of a row.
    pub columns: usize,
}

impl RowMatrix {
    /// Zeros.
    pub fn zeros(rows: usize, columns: usize) -> RowMatrix {
        RowMatrix {
            entries: vec![0.0; rows * columns],
            columns,
        }
    }

    /// One of the rows.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.columns..(row + 1) * self.columns]
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.entries.len() / self.columns.max(1)
    }

    /// Each row times `x`.
    pub fn times(&self, x: &DVector<f64>) -> DVector<f64> {
        let product = |row: usize| -> f64 { self.row(row).iter().zip(x).map(|(a, b)| a * b).sum() };
        DVector::from_fn(self.rows(), |row, _| product(row))
    }

    /// The same matrix column by column.
    pub fn dense(&self) -> DMatrix<f64> {
        DMatrix::from_row_slice(self.rows(), self.columns, &self.entries)
    }
}

impl Index<(usize, usize)> for RowMatrix {
    type Output = f64;

    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.row(row)[column]
    }
}
