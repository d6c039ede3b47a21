//! The robots of a fleet as knowledge of the next one, which takes the place of CAD's tolerances.
//!
//! ```text
//! r ~ N(μ, Σ)      μ mean over robots, Σ = S Sᵀ covariance between robots and of μ
//! about CAD:  Σ + (μ − r_CAD)(μ − r_CAD)ᵀ, for those who linearise about CAD
//! ```
//!
//! The file is TOML: a table `population` with `urdf_hash`, `support`, `robots`, `names`, `mean`
//! (m) and `covariance` (m², row by row).

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sesc_model::{Model, ModelFile, files};

use super::offset;
use crate::Error;
use crate::tolerances::from_columns;

/// The newest format of files of tolerances and populations that is read.
pub(super) const FORMAT: u32 = 1;

/// Eigenvalues below this, relative to the largest, are rounding.
const ROUNDING: f64 = 1e-14;

/// Mean and covariance of the base parameters of robots of one URDF on one support.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Population {
    /// Hash of the URDF.
    pub urdf_hash: String,
    /// Link on the ground.
    pub support: String,
    /// Robots that it is of.
    pub robots: usize,
    /// Names of the base parameters.
    pub names: Vec<String>,
    /// Means over robots, m.
    pub mean: Vec<f64>,
    /// Covariance of the next robot, m²; about the mean, row by row.
    pub covariance: Vec<Vec<f64>>,
}

/// A file with a table of that name.
#[derive(Serialize, Deserialize)]
struct File<T> {
    /// What a fleet knows of the next robot.
    population: T,
}

impl Population {
    /// What the text of `file` knows of the next robot.
    ///
    /// # Errors
    /// When it is no population, or that of another robot or support than `model`'s.
    pub(super) fn read(text: &str, file: &str, model: &Model) -> Result<Fitted, Error> {
        let bad = |reason: String| Error::prior(file, reason);
        let found: File<Population> =
            files::parse_toml(text, FORMAT).map_err(|fault| Error::prior_toml(file, fault))?;
        let found = found.population;
        let support = &model.tree.links[model.tree.support].name;
        if (&found.urdf_hash, &found.support) != (&model.tree.hash, support) {
            return Err(bad(format!(
                "it is of URDF {} on `{}`, and the robot is URDF {} on `{support}`",
                found.urdf_hash, found.support, model.tree.hash
            )));
        }
        let names: Vec<&String> = model.base.params.iter().map(|p| &p.name).collect();
        let n = names.len();
        let is_square =
            found.covariance.len() == n && found.covariance.iter().all(|r| r.len() == n);
        if !found.names.iter().eq(names) || found.mean.len() != n || !is_square {
            return Err(bad(format!(
                "it has other than the {n} base parameters of the robot; make it anew by a fleet \
                 with the same options"
            )));
        }
        let all = found.covariance.iter().flatten().chain(&found.mean);
        if !all.copied().all(f64::is_finite) {
            return Err(bad("its numbers are not all finite".to_string()));
        }
        let factor = found.factor();
        Ok(Fitted {
            source: found.robots.to_string(),
            centre: found.mean.into(),
            factor: factor
                .ok_or_else(|| bad("its covariance has a negative eigenvalue".to_string()))?,
            logs: Vec::new(),
        })
    }

    /// The text of its file.
    ///
    /// # Errors
    /// When it cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, Error> {
        let text = toml::to_string(&File { population: self }).map_err(Error::serialise)?;
        Ok(format!(
            "# How base parameters are spread between {} robots: a prior for `fit` and `diagnose`.\n{text}",
            self.robots
        ))
    }

    /// S with S Sᵀ = Σ; none where Σ is no covariance.
    fn factor(&self) -> Option<DMatrix<f64>> {
        let n = self.mean.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| self.covariance[i][j]);
        let even = (&covariance + covariance.transpose()) * 0.5;
        let axes = even.try_symmetric_eigen(f64::EPSILON, 10_000)?;
        let largest = axes.eigenvalues.max();
        let least = ROUNDING * largest * n as f64;
        if largest < 0.0 || axes.eigenvalues.iter().any(|value| *value < -1e3 * least) {
            return None;
        }
        let kept: Vec<DVector<f64>> = axes
            .eigenvalues
            .iter()
            .zip(axes.eigenvectors.column_iter())
            .filter(|(value, _)| **value > least)
            .map(|(value, axis)| axis * value.sqrt())
            .collect();
        Some(from_columns(n, &kept))
    }
}

/// Base parameters of one robot, or of the next one of a fleet, and how well they are known, with the
/// logs that they are from.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// File of the parameters, names of the logs of the healthy robot, or how many robots they are of.
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
