//! Robust weights: postures that no noise explains count less.
//!
//! ```text
//! x = ‖residual / σ‖ / s        Huber: min(1, c / x)        Tukey: (1 − (x / c)²)², 0 beyond c
//! ```
//!
//! of a posture's two residuals together: a foot that slipped is wrong on both
//! axes. `s` is the scale that the residuals' median shows.

use super::criteria::{HUBER, TUKEY};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use crate::observations::rows::Rows;

/// Kind of robust loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Loss {
    /// Linear in large residuals.
    Huber,
    /// Constant in large residuals, which then have no weight.
    Tukey,
}

/// A loss with the scale of its residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Robust {
    /// The loss.
    pub loss: Loss,
    /// Scale of the residuals, in units of their stated deviations (m where none are stated).
    pub scale: f64,
}

/// Median of the length of a pair of unit normals: √(2 ln 2).
pub(super) const MEDIAN_OF_PAIRS: f64 = 1.177_410_022_515_474_6;

impl Robust {
    /// Mean square of weighted residuals over that of the weights, of normal noise:
    /// what weighting alone takes away.
    pub fn consistency(&self) -> f64 {
        // E[w x²] / 2 E[w] with x the length of a pair of unit normals.
        match self.loss {
            Loss::Huber => 0.9297,
            Loss::Tukey => 0.8424,
        }
    }

    /// Weight of every posture in `rows`, 0 to 1.
    pub fn weights(&self, rows: &Rows, std: &[[f64; 2]], params: &DVector<f64>) -> Vec<f64> {
        lengths(rows, std, params)
            .map(|length| self.weight(length / self.scale))
            .collect()
    }

    fn weight(&self, x: f64) -> f64 {
        match self.loss {
            Loss::Huber => (HUBER / x).min(1.0),
            Loss::Tukey if x >= TUKEY => 0.0,
            Loss::Tukey => (1.0 - (x / TUKEY).powi(2)).powi(2),
        }
    }
}

/// ‖residual / σ‖ of every posture.
pub(super) fn lengths<'a>(
    rows: &'a Rows,
    std: &'a [[f64; 2]],
    params: &DVector<f64>,
) -> impl Iterator<Item = f64> + 'a {
    let residual = rows.residual(params);
    (0..std.len()).map(move |k| {
        let [x, y] = [0, 1].map(|axis| residual[2 * k + axis] / std[k][axis]);
        x.hypot(y)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observations::row_matrix::RowMatrix;

    /// Postures 0, 2, 5 and 30 deviations off at a scale of 2: x is 0, 1, 2.5 and 15.
    #[test]
    fn weights_fall_with_the_residual_over_the_scale() {
        let rows = Rows {
            matrix: RowMatrix::zeros(8, 1),
            reading: DVector::from_column_slice(&[0.0, 0.0, 0.0, 4e-3, 3e-3, 8e-3, -6e-2, 0.0]),
            motion: Vec::new(),
        };
        let weights = |loss| {
            let robust = Robust { loss, scale: 2.0 };
            robust.weights(
                &rows,
                &[[1e-3, 2e-3], [1e-3, 2e-3], [1e-3, 2e-3], [2e-3, 1e-3]],
                &DVector::zeros(1),
            )
        };
        let near = |found: Vec<f64>, expected: [f64; 4]| {
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?}");
        };
        near(weights(Loss::Huber), [1.0, 1.0, HUBER / 2.5, HUBER / 15.0]);
        let tukey = |x: f64| (1.0 - (x / TUKEY).powi(2)).powi(2);
        near(weights(Loss::Tukey), [1.0, tukey(1.0), tukey(2.5), 0.0]);
    }
}
