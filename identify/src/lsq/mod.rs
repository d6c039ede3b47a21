//! Least squares, for fits, plans and diagnoses alike.
//!
//! ```text
//! min ‖Φ r − y‖²                     rows in bounded memory         factor, solve
//! … with u ≥ 0, E v = e, G v ≤ h     masses that can exist          inequality
//! … of a nonlinear model             effects                        damped
//! RᵀR = C⁻¹ of what was found        what a recursive fit goes on from    solve
//! ```

pub(crate) mod damped;
pub(crate) mod factor;
pub(crate) mod inequality;
pub(crate) mod solve;

pub use factor::Factor;
pub use solve::{Estimate, solve};

use nalgebra::{Cholesky, DMatrix, Dyn};

/// What is added to the diagonal of normal equations, relative and absolute: columns
/// that copy each other then share what one of them would take.
const RIDGE: (f64, f64) = (1e-9, 1e-12);

/// Factor of normal equations of whitened columns; `None` where they are not finite.
pub(crate) fn factor_normal(mut normal: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    for k in 0..normal.nrows() {
        normal[(k, k)] = normal[(k, k)] * (1.0 + RIDGE.0) + RIDGE.1;
    }
    normal.cholesky()
}

/// Rows of a tall matrix that a processor's own cache holds.
const NEAR: usize = 256;

/// `Aᵀ B` of tall matrices. The library's own takes a dot product for each entry, and so fetches
/// A as often as B has columns.
pub(crate) fn transposed_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.ncols(), b.ncols());
    for from in (0..a.nrows()).step_by(NEAR) {
        let rows = NEAR.min(a.nrows() - from);
        let (a, b) = (a.rows(from, rows), b.rows(from, rows));
        match b.ncols() {
            ..4 => product += a.tr_mul(&b),
            _ => product.gemm(1.0, &a.transpose(), &b, 1.0),
        }
    }
    product
}

/// `B − A C` of tall matrices A and B, which are fetched once.
pub(crate) fn without_product(
    b: &DMatrix<f64>,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
) -> DMatrix<f64> {
    let mut left = b.clone();
    for from in (0..a.nrows()).step_by(NEAR) {
        let rows = NEAR.min(a.nrows() - from);
        left.rows_mut(from, rows)
            .gemm(-1.0, &a.rows(from, rows), c, 1.0);
    }
    left
}
