//! One robot as an earlier fit knows it, in the place of CAD and its tolerances.
//!
//! ```text
//! r ~ N(r̂, C)      C = (RᵀR)⁻¹ = S Sᵀ, S = R⁻¹      R: `information.factor` of a model file
//! ```
//!
//! Of a direction that neither data nor prior say anything about, R has a row of zeros; there r stays
//! at r̂.

use nalgebra::{DMatrix, DVector};
use sesc_model::{Model, ModelFile};

use super::offset;
use crate::Error;

/// Base parameters of one robot and how well they are known, with the logs that they are from.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// File of the parameters, or names of the logs of the healthy robot.
    pub source: String,
    /// r̂, m.
    pub(super) centre: DVector<f64>,
    /// S.
    pub(super) factor: DMatrix<f64>,
    /// Hashes of the logs that they were fitted to.
    pub(super) logs: Vec<String>,
}

/// S with S Sᵀ the covariance, of an information `factor`. Rows of zeros know nothing of their
/// parameter: the others are taken given it.
pub(crate) fn inverse(factor: &[Vec<f64>]) -> DMatrix<f64> {
    let n = factor.len();
    let mut inverse = DMatrix::zeros(n, n);
    for k in 0..n {
        // R x = e_k, from below.
        for i in (0..=k).rev() {
            let own = &factor[i];
            let known = (i + 1..=k).map(|j| own[j - i] * inverse[(j, k)]);
            let known = known.sum::<f64>();
            let one = if i == k { 1.0 } else { 0.0 };
            if own[0] > 0.0 {
                inverse[(i, k)] = (one - known) / own[0];
            }
        }
    }
    inverse
}

impl Fitted {
    /// What `file` knows of the robot of `model`.
    ///
    /// # Errors
    /// A file of another robot or support, with effects, or that does not say how well it knows
    /// its parameters.
    pub fn new(file: &ModelFile, model: &Model, source: &str) -> Result<Fitted, Error> {
        let bad = |reason: &str| Error::prior(source, reason);
        model.clone().with_file(file.clone())?;
        if let Some(reason) = file.invalid_reason() {
            return Err(bad(&reason));
        }
        // An offset belongs to the log, not to the robot.
        if file.effects.iter().any(|own| own.effect != offset::OFFSET) {
            return Err(bad(
                "it has effects, so that it is not of a healthy robot; give the file that `fit` \
                 wrote of one",
            ));
        }
        let information = file.information.as_ref().ok_or_else(|| {
            bad("it has no `information.factor`: how well its parameters are known; fit again")
        })?;
        Ok(Fitted {
            source: source.to_string(),
            centre: file.values().into(),
            factor: inverse(&information.factor),
            logs: file.data.iter().map(|log| log.hash.clone()).collect(),
        })
    }
}
