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

/// `Aᵀ B`. The library's own takes a dot product for each entry, which for tall matrices of more
/// than a few columns is several times slower than to turn A over and multiply in blocks.
pub(crate) fn transposed_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    match b.ncols() {
        ..4 => a.tr_mul(b),
        _ => a.transpose() * b,
    }
}
