//! How the parameters of robots are spread: what is known of the next robot before it stands.
//!
//! ```text
//! x_i = μ + b_i + e_i      Cov b = Cov x − diag(mean s²), without its negative eigenvalues
//! ```
//!
//! x_i are the parameters of robot i, weighted over its days. Robots with effects are left
//! out: their parameters as fitted without effects are not those of their links.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::criteria::ROBOTS;
use super::history::History;
use crate::fleet::row::Row;

/// Parameters over robots of one URDF on one support.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// Standard deviations of one robot's estimate, m.
    pub estimate_std: Vec<f64>,
    /// Covariance between robots, what estimates scatter taken off, m²; row by row.
    pub covariance: Vec<Vec<f64>>,
}

pub(super) fn population(
    histories: &[History],
    names: &BTreeMap<(String, String), Vec<String>>,
) -> Option<Population> {
    let mut all: BTreeMap<(&str, &str), Vec<Vec<&Row>>> = BTreeMap::new();
    for stretch in histories.iter().flat_map(History::stretches) {
        let plain = |row: &&Row| row.effects.is_empty() && row.std.iter().all(Option::is_some);
        let rows: Vec<&Row> = stretch
            .into_iter()
            .filter(plain)
            .filter(|row| !row.params.is_empty())
            .collect();
        if let Some(first) = rows.first() {
            all.entry((&first.urdf_hash, &first.support))
                .or_default()
                .push(rows);
        }
    }
    let ((urdf_hash, support), robots) = all.into_iter().max_by_key(|(_, robots)| robots.len())?;
    let n = robots.first()?.first()?.params.len();
    let robots: Vec<Vec<[f64; 2]>> = robots.iter().filter_map(|rows| estimate(rows, n)).collect();
    if robots.len() < ROBOTS {
        return None;
    }
    let count = robots.len() as f64;
    let mean = DVector::from_fn(n, |k, _| {
        robots.iter().map(|r| r[k][0]).sum::<f64>() / count
    });
    let variance = DVector::from_fn(n, |k, _| {
        robots.iter().map(|r| r[k][1]).sum::<f64>() / count
    });
    let mut covariance = DMatrix::from_diagonal(&-&variance);
    for robot in &robots {
        let gap = DVector::from_fn(n, |k, _| robot[k][0] - mean[k]);
        covariance += &gap * gap.transpose() / (count - 1.0);
    }
    let mut axes = covariance.try_symmetric_eigen(f64::EPSILON, 10_000)?;
    axes.eigenvalues
        .iter_mut()
        .for_each(|value| *value = value.max(0.0));
    let covariance = axes.recompose();
    let key = (urdf_hash.to_string(), support.to_string());
    let numbered = || (1..=n).map(|k| format!("parameter {k}")).collect();
    Some(Population {
        urdf_hash: key.0.clone(),
        support: key.1.clone(),
        robots: robots.len(),
        names: names.get(&key).cloned().unwrap_or_else(numbered),
        mean: mean.iter().copied().collect(),
        estimate_std: variance.iter().map(|v| v.sqrt()).collect(),
        covariance: covariance
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
    })
}

/// Parameters of a robot over its days with the variances of these.
fn estimate(rows: &[&Row], n: usize) -> Option<Vec<[f64; 2]>> {
    let of = |k: usize| {
        let known = rows.iter().filter_map(|row| {
            let std = (*row.std.get(k)?)?;
            (std > 0.0).then_some((*row.params.get(k)?, std.powi(-2)))
        });
        let (sum, weight) = known.fold((0.0, 0.0), |(s, w), (x, own)| (s + own * x, w + own));
        (weight > 0.0).then_some([sum / weight, 1.0 / weight])
    };
    (0..n).map(of).collect()
}
