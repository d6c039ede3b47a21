//! What each posture of a plan teaches, one after the other.
//!
//! ```text
//! K = C Aᵀ (A C Aᵀ + σ² I)⁻¹        C ← C − K A C        σ_p = √C_pp
//! ```
//!
//! A are the two CoP rows of a posture, C is the covariance of the base parameters before it, at
//! first that of the prior. The lesson of a posture is the parameter whose σ_p falls by the
//! largest part.

use nalgebra::DMatrix;
use serde::Serialize;
use sesc_model::Model;
use sesc_model::base::Column;

/// The parameter that a posture tells most of.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Lesson {
    /// Name of the base parameter.
    pub parameter: String,
    /// `m`; `1` for a mass fraction.
    pub unit: &'static str,
    /// Standard deviation before it.
    pub before: f64,
    /// Standard deviation after it.
    pub after: f64,
}

/// The lessons of postures in their `order`: `regressor` is φᵀ as columns, two per candidate,
/// `prior` a factor of the covariance that is known beforehand, `noise` that of a reading, m.
pub(super) fn lessons(
    model: &Model,
    regressor: &DMatrix<f64>,
    prior: &DMatrix<f64>,
    noise: f64,
    order: &[usize],
) -> Vec<Lesson> {
    let steps = deviations(regressor, prior, noise, order);
    let params = &model.base.params;
    let lesson = |pair: &[Vec<f64>]| {
        let part = |k: &usize| pair[1][*k] / pair[0][*k];
        let known = (0..params.len()).filter(|k| part(k).is_finite());
        let best = known.min_by(|a, b| part(a).total_cmp(&part(b)))?;
        Some(Lesson {
            parameter: params[best].name.clone(),
            unit: match params[best].column {
                Column::Prismatic { .. } => "1",
                Column::Axis { .. } => "m",
            },
            before: pair[0][best],
            after: pair[1][best],
        })
    };
    steps.windows(2).filter_map(lesson).collect()
}

/// Deviations of all parameters before the first posture and after each.
fn deviations(
    regressor: &DMatrix<f64>,
    prior: &DMatrix<f64>,
    noise: f64,
    order: &[usize],
) -> Vec<Vec<f64>> {
    let mut covariance = prior * prior.transpose();
    let of = |covariance: &DMatrix<f64>| -> Vec<f64> {
        let variances = covariance.diagonal();
        variances.iter().map(|x| x.max(0.0).sqrt()).collect()
    };
    let mut all = vec![of(&covariance)];
    for &k in order {
        let rows = regressor.columns(2 * k, 2);
        let spread = &covariance * rows;
        let reading = rows.tr_mul(&spread) + DMatrix::identity(2, 2) * noise.powi(2);
        if let Some(inverse) = reading.try_inverse() {
            covariance -= &spread * inverse * spread.transpose();
        }
        all.push(of(&covariance));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the inverse of the whole information.
    #[test]
    fn deviations_after_all_postures_are_those_of_one_fit() {
        let regressor = DMatrix::from_fn(4, 12, |i, j| ((i * 31 + j * j * 7) as f64 * 0.61).sin());
        let entry = |i: usize, j: usize| if i == j { 0.5 } else { 0.05 * (i + j) as f64 };
        let prior = DMatrix::from_fn(4, 4, entry);
        let (noise, order) = (0.2, [4, 0, 3]);
        let steps = deviations(&regressor, &prior, noise, &order);
        assert_eq!(steps.len(), 4);
        let own = |count: usize| {
            let columns = order[..count].iter().flat_map(|k| [2 * k, 2 * k + 1]);
            let columns: Vec<usize> = columns.collect();
            let rows = regressor.select_columns(&columns) / noise;
            let information =
                (&prior * prior.transpose()).try_inverse().unwrap() + &rows * rows.transpose();
            information.try_inverse().unwrap()
        };
        for (count, step) in steps.iter().enumerate() {
            let expected = own(count);
            for (k, std) in step.iter().enumerate() {
                let off = std / expected[(k, k)].sqrt() - 1.0;
                assert!(off.abs() < 1e-9, "{count} {k}: {off}");
            }
        }
    }
}
