//! Masses within their CAD prior, marginalised out of the evidence.
//!
//! ```text
//! y = f(e) + Y δr + noise      δr ~ N(0, C), C = F Fᵀ      K = W Y F   (W: 1/σ)
//! −2 log p(y | e) = ‖W(y − f)‖² − ‖L⁻¹ Kᵀ W(y − f)‖² + log det A + const
//! A = I + Kᵀ K = L Lᵀ
//! ```
//!
//! Y are the regressor rows of the unbent robot: the product of two small
//! things, effect and mass error, is left out.

use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::lsq::solve::Beyond;
use crate::lsq::{transposed_times, without_product};

/// What is known of masses before the logs.
#[derive(Clone)]
pub(super) struct MassPrior {
    /// F: base parameters by directions.
    pub factor: DMatrix<f64>,
    /// Deviation of the robot's total mass over itself, the last direction; none where nothing
    /// weighs it.
    pub total: Option<f64>,
    /// What is known of directions that F has no column for.
    pub beyond: Beyond,
    /// The directions in the rows of all blocks.
    pub nuisance: Arc<Nuisance>,
}

/// Directions of mass error, whitened: rows as readings, a column per direction.
#[derive(Debug, Clone)]
pub(super) struct Nuisance {
    k: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
    /// log det A
    pub log_det: f64,
}

/// L Lᵀ = I + KᵀK without its squares: L is the transposed triangle of [K; I].
fn triangle(k: &DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let (n, m) = k.shape();
    let mut stacked = DMatrix::zeros(n + m, m);
    stacked.rows_mut(0, n).copy_from(k);
    stacked.rows_mut(n, m).fill_with_identity();
    let mut lower = stacked.qr().r().transpose();
    for mut column in lower.column_iter_mut() {
        let first = column.iter().copied().find(|x| *x != 0.0);
        if first.is_some_and(|x| x < 0.0) {
            column.neg_mut();
        }
    }
    Cholesky::pack_dirty(lower)
}

impl Default for Nuisance {
    /// Masses that are known.
    fn default() -> Nuisance {
        Nuisance::of(DMatrix::zeros(0, 0))
    }
}

impl Nuisance {
    /// `k`: whitened regressor rows times F.
    pub(super) fn of(k: DMatrix<f64>) -> Nuisance {
        let mut a = transposed_times(&k, &k);
        for i in 0..a.nrows() {
            a[(i, i)] += 1.0;
        }
        // Squares of very large directions drown the identity; the triangle of [K; I] keeps it.
        let factor = a.cholesky().unwrap_or_else(|| triangle(&k));
        let log_det = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        Nuisance { k, factor, log_det }
    }

    /// The directions, whitened: rows as readings.
    pub(super) fn columns(&self) -> &DMatrix<f64> {
        &self.k
    }

    /// L of A = L Lᵀ.
    pub(super) fn factor(&self) -> &Cholesky<f64, Dyn> {
        &self.factor
    }

    /// The same directions where rows count `weight` times their inverse deviation.
    pub(super) fn reweighted(&self, weight: &[f64]) -> Nuisance {
        let mut k = self.k.clone();
        for (mut row, w) in k.row_iter_mut().zip(weight) {
            row *= *w;
        }
        Nuisance::of(k)
    }

    /// `S x` with `S = I − K A⁻¹ Kᵀ`: what of whitened columns is no mass error.
    pub(super) fn project_out(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let inner = self.factor.solve(&transposed_times(&self.k, x));
        without_product(x, &self.k, &inner)
    }

    /// The same of one whitened column.
    pub(super) fn project_out_one(&self, x: &DVector<f64>) -> DVector<f64> {
        let inner = self.factor.solve(&self.k.tr_mul(x));
        x - &self.k * inner
    }

    /// Whether mass errors move readings by less than a thousandth of the noise.
    pub(super) fn is_negligible(&self) -> bool {
        self.k.amax() < 1e-3
    }

    /// Effective number of directions that the data determine: tr(K A⁻¹ Kᵀ).
    pub(super) fn directions(&self) -> f64 {
        // tr(A⁻¹ KᵀK) = m − tr A⁻¹
        self.k.ncols() as f64 - self.factor.inverse().trace()
    }

    /// Expected mass error given whitened residuals, in the units of F's columns.
    pub(super) fn posterior_mean(&self, residual: &DVector<f64>) -> DVector<f64> {
        self.factor.solve(&self.k.tr_mul(residual))
    }

    /// Their covariance once the data are in: A⁻¹.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        self.factor.inverse()
    }

    /// Whitened shift of readings by mass errors `z`, in units of F's columns.
    pub(super) fn shift(&self, z: &DVector<f64>) -> DVector<f64> {
        &self.k * z
    }
}
