//! What masses explain of the readings within the usual tolerances of CAD.
//!
//! ```text
//! min over r   ‖(y − X r) / σ‖² + ‖S⁻¹ (r − r_CAD)‖²        S Sᵀ: covariance of `tolerances`
//! ```

use nalgebra::{DMatrix, DVector};

use super::Look;
use crate::observations::rows::CopRows;
use crate::tolerances::Tolerances;

/// Postures that masses are fitted to, at most.
const FITTED: usize = 500;

/// What such masses leave of a reading, squared, in units of the look's deviations, the penalty
/// of the tolerances included; `noise`: variance of the noise in the same units.
pub(super) fn left(look: &Look, noise: f64) -> Option<f64> {
    let (model, data) = (look.model, look.data);
    let dof = model.dof();
    let chosen: Vec<usize> = (0..data.len())
        .step_by(data.len().div_ceil(FITTED).max(1))
        .collect();
    let q = chosen.iter().flat_map(|&k| &data.q[k * dof..(k + 1) * dof]);
    let q: Vec<f64> = q.copied().collect();
    let rows = CopRows::new(model).fastest().of(&q, chosen.len(), None);
    let tolerances = Tolerances::usual().factor(model);
    let reading = |row: usize| 2 * chosen[row / 2] + row % 2;
    let weight = |row: usize| 1.0 / (noise.sqrt() * look.std[reading(row)]);
    let gap = DVector::from_fn(rows.nrows(), |row, _| {
        (data.reading[reading(row)] - look.predicted[reading(row)]) * weight(row)
    });
    let mut free = rows * tolerances;
    for (row, mut columns) in free.row_iter_mut().enumerate() {
        columns *= weight(row);
    }
    let inner = free.tr_mul(&free) + DMatrix::identity(free.ncols(), free.ncols());
    let along = free.tr_mul(&gap);
    let explained = along.dot(&inner.cholesky()?.solve(&along));
    Some(noise * (gap.norm_squared() - explained) / gap.len() as f64)
}
