//! What a fleet says of the next robot: mean and covariance of the base parameters.
//!
//! ```text
//! r_i = c + S u_i      u_i ~ N(μ, Σ)      data of robot i:  J_i, h_i, added up over its days
//! W_i = (Σ⁻¹ + J_i)⁻¹  m_i = W_i (Σ⁻¹ μ + h_i)          what is known of robot i
//! μ ← mean m_i         Σ ← mean ((m_i − μ)(m_i − μ)ᵀ + W_i)
//! ```
//!
//! c and S are centre and factor of the prior that rows were fitted with, CAD's tolerances as a
//! rule. From there (μ = 0, Σ = 1) the steps (expectation and maximisation, Dempster, Laird and
//! Rubin 1977) narrow Σ in directions that robots' data tell; where no data tell anything Σ
//! stays CAD's. What few robots leave open of μ and Σ is added: Σ (1 + 1/N), and on the diagonal
//! n/N of what was learnt, since n parameters of N robots have axes along which these happen to
//! be alike.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::options::Options;
use super::row::Row;
use super::summary::criteria::ROBOTS;
use crate::Error;
use crate::diagnose::FREE_MASSES;
use crate::fit::population::Population;
use crate::fit::prior::{Prior, PriorChoice};
use crate::health::Kind;
use crate::robot::Robot;
use crate::svd::svd;

/// Steps; each narrows Σ, so that fewer only leave it wider.
const STEPS: usize = 30;

/// What the data of one robot say, prior taken off.
struct Said {
    information: DMatrix<f64>,
    vector: DVector<f64>,
}

/// The population of all rows of `robot`'s URDF that were made with these options, which have
/// `information`.
///
/// # Errors
/// When rows have no covariances, were fitted without a prior, or are of fewer than five robots.
pub fn population(
    rows: &[Row],
    robot: &Arc<Robot>,
    options: &Options,
) -> Result<Population, Error> {
    let hash = &robot.description.hash;
    let is_told = |row: &&Row| {
        row.urdf_hash == *hash
            && !row.covariance.is_empty()
            && row.is_usable()
            // With another effect, its parameters make up for that.
            && row.effects.iter().all(|found| found.effect == FREE_MASSES)
            && !row
                .health
                .iter()
                .any(|finding| finding.kind == Kind::EncoderStuck)
    };
    let mut supports: BTreeMap<&str, BTreeMap<&str, Vec<&Row>>> = BTreeMap::new();
    for row in rows.iter().filter(is_told) {
        let robots = supports.entry(&row.support).or_default();
        robots.entry(&row.robot).or_default().push(row);
    }
    let most = supports.into_iter().max_by_key(|(_, robots)| robots.len());
    let few = |count: usize| {
        Error::request(format!(
            "{count} robots of the fleet's URDF have parameters and no effects; a population \
             needs {ROBOTS}"
        ))
    };
    let (support, robots) = most.ok_or_else(|| few(0))?;
    let model = robot.model(support, options.snapping(), None)?;
    let choice = options.prior.as_deref().unwrap_or(Prior::DEFAULT);
    let prior = PriorChoice::from(choice).of(&model)?;
    let spread = prior.spread(&model).ok_or_else(|| {
        Error::request("a population begins with tolerances of CAD, and these fits had no prior")
    })?;
    let centre = prior.centre(&model);
    let inverse = pseudo_inverse(&spread);
    let said: Vec<Said> = robots
        .values()
        .filter_map(|days| said(days, &centre, &inverse))
        .collect();
    if said.len() < ROBOTS {
        return Err(few(said.len()));
    }
    let (mean, covariance) = spread_of(&said, spread.ncols())
        .ok_or_else(|| Error::request("what robots differ by has no covariance"))?;
    let mean = &centre + &spread * mean;
    let covariance = &spread * covariance * spread.transpose();
    Ok(Population {
        urdf_hash: hash.clone(),
        support: support.to_string(),
        robots: said.len(),
        names: model.base.params.iter().map(|p| p.name.clone()).collect(),
        mean: mean.iter().copied().collect(),
        covariance: covariance
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
    })
}

/// S⁺ of a factor with independent columns.
fn pseudo_inverse(factor: &DMatrix<f64>) -> DMatrix<f64> {
    let found = svd(factor.clone(), true, true);
    let (Some(u), Some(v_t)) = (found.u, found.v_t) else {
        return DMatrix::zeros(factor.ncols(), factor.nrows());
    };
    let scaled = DMatrix::from_diagonal(&found.singular_values.map(|value| 1.0 / value));
    v_t.transpose() * scaled * u.transpose()
}

/// J = Σ_days (C_u⁻¹ − 1) and h = Σ_days C_u⁻¹ u of the rows of one robot.
fn said(days: &[&Row], centre: &DVector<f64>, inverse: &DMatrix<f64>) -> Option<Said> {
    let m = inverse.nrows();
    let mut all: Option<Said> = None;
    for row in days {
        let n = row.params.len();
        if n != centre.len() || row.covariance.len() != n * (n + 1) / 2 {
            continue;
        }
        let at = |i: usize, j: usize| row.covariance[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
        let covariance = DMatrix::from_fn(n, n, at);
        let own = inverse * covariance * inverse.transpose();
        let Some(precision) = own.cholesky().map(|factor| factor.inverse()) else {
            continue;
        };
        let u = inverse * (DVector::from_column_slice(&row.params) - centre);
        let all = all.get_or_insert_with(|| Said {
            information: DMatrix::zeros(m, m),
            vector: DVector::zeros(m),
        });
        all.vector += &precision * u;
        all.information += precision - DMatrix::identity(m, m);
    }
    all
}

/// μ and Σ of the next robot.
fn spread_of(robots: &[Said], m: usize) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let count = robots.len() as f64;
    let mut mean = DVector::zeros(m);
    let mut covariance = DMatrix::<f64>::identity(m, m);
    for _ in 0..STEPS {
        let before = covariance.clone().cholesky()?.inverse();
        let known = &before * &mean;
        let mut told = Vec::with_capacity(robots.len());
        let mut within = DMatrix::zeros(m, m);
        for robot in robots {
            let own = (&before + &robot.information).cholesky()?.inverse();
            told.push(&own * (&known + &robot.vector));
            within += own;
        }
        mean = told.iter().fold(DVector::zeros(m), |sum, one| sum + one) / count;
        for one in &told {
            let gap = one - &mean;
            within += &gap * gap.transpose();
        }
        covariance = within / count;
    }
    let learnt = covariance
        .diagonal()
        .map(|value| value * (1.0 - value).max(0.0));
    covariance *= 1.0 + 1.0 / count;
    covariance += DMatrix::from_diagonal(&(learnt * (m as f64 / count)));
    Some((mean, covariance))
}
