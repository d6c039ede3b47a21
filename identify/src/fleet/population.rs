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

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::Options;
use super::inputs::Group;
use super::row::Row;
use super::summary::ROBOTS;
use crate::Error;
use crate::diagnose::FREE_MASSES;
use crate::fit::population::Population;
use crate::fit::prior::{Prior, PriorChoice};
use crate::robot::Robot;
use crate::svd::svd;

/// What the data of one robot say, prior taken off: J and h.
type Said = (DMatrix<f64>, DVector<f64>);

/// Whether these groups are of enough robots for [`population`], before they are worked on.
///
/// # Errors
/// When they are of fewer than five robots.
pub fn check_population(groups: &[Group]) -> Result<(), Error> {
    let robots: BTreeSet<&str> = groups.iter().map(|group| group.robot.as_str()).collect();
    if robots.len() >= ROBOTS {
        return Ok(());
    }
    Err(Error::request(format!(
        "the logs are of {} robots; a population needs {ROBOTS}",
        robots.len()
    )))
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
            && row.effects.explanation.iter().all(|found| found.effect == FREE_MASSES)
    };
    let mut supports: BTreeMap<&str, BTreeMap<&str, Vec<&Row>>> = BTreeMap::new();
    for row in with_each_log_once(rows.iter().filter(is_told).collect()) {
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
    // S⁺ of a factor with independent columns.
    let inverse = svd(spread.clone(), true, true).pseudo_inverse(0.0);
    let inverse = inverse.map_err(Error::request)?;
    let days = robots.values();
    let said = days.filter_map(|days| said(days, &centre, &inverse));
    let said: Vec<Said> = said.collect();
    if said.len() < ROBOTS {
        return Err(few(said.len()));
    }
    let (mean, covariance) = spread_of(&said, spread.ncols())
        .ok_or_else(|| Error::request("what robots differ by has no covariance"))?;
    let mean = &centre + &spread * mean;
    let covariance = &spread * covariance * spread.transpose();
    let row = |k: usize| covariance.row(k).iter().copied().collect();
    Ok(Population {
        urdf_hash: hash.clone(),
        support: support.to_string(),
        robots: said.len(),
        names: model.base.params.iter().map(|p| p.name.clone()).collect(),
        mean: mean.as_slice().to_vec(),
        covariance: (0..covariance.nrows()).map(row).collect(),
    })
}

/// Rows of which no two have a log in common: its readings are told once, in whatever robot's
/// and day's name it is listed. Of two rows that of more logs stays, then that of the first robot
/// and day.
fn with_each_log_once(mut rows: Vec<&Row>) -> Vec<&Row> {
    rows.sort_by(|a, b| {
        let more = b.inputs.len().cmp(&a.inputs.len());
        let rest = || (&a.support, &a.inputs).cmp(&(&b.support, &b.inputs));
        more.then_with(|| a.order(b)).then_with(rest)
    });
    let mut told: BTreeSet<&str> = BTreeSet::new();
    rows.retain(|row| {
        let is_new = row.inputs.iter().all(|log| !told.contains(log.as_str()));
        if is_new {
            told.extend(row.inputs.iter().map(String::as_str));
        }
        is_new
    });
    // Sums do not depend on which row has the most logs.
    rows.sort_by(|a, b| a.order(b));
    rows
}

/// J = Σ_days (C_u⁻¹ − 1) and h = Σ_days C_u⁻¹ u of the rows of one robot.
fn said(days: &[&Row], centre: &DVector<f64>, inverse: &DMatrix<f64>) -> Option<Said> {
    let of_day = |row: &&Row| {
        let covariance = row.covariance().filter(|own| own.nrows() == centre.len())?;
        let own = inverse * covariance * inverse.transpose();
        let precision = own.cholesky()?.inverse();
        let u = inverse * (DVector::from_column_slice(&row.params) - centre);
        let (m, _) = precision.shape();
        let vector = &precision * u;
        Some((precision - DMatrix::identity(m, m), vector))
    };
    let days = days.iter().filter_map(of_day);
    days.reduce(|sum, day| (sum.0 + day.0, sum.1 + day.1))
}

/// μ and Σ of the next robot.
fn spread_of(robots: &[Said], m: usize) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let count = robots.len() as f64;
    let mut mean = DVector::zeros(m);
    let mut covariance = DMatrix::<f64>::identity(m, m);
    // Each narrows Σ, so that fewer only leave it wider.
    for _ in 0..30 {
        let before = covariance.clone().cholesky()?.inverse();
        let known = &before * &mean;
        let mut told = Vec::with_capacity(robots.len());
        let mut within = DMatrix::zeros(m, m);
        for (information, vector) in robots {
            let own = (&before + information).cholesky()?.inverse();
            told.push(&own * (&known + vector));
            within += own;
        }
        mean = told.iter().fold(DVector::zeros(m), |sum, one| sum + one) / count;
        for one in &told {
            let gap = one - &mean;
            within += &gap * gap.transpose();
        }
        covariance = within / count;
    }
    let learnt = covariance.diagonal();
    let learnt = learnt.map(|value| value * (1.0 - value).max(0.0));
    covariance *= 1.0 + 1.0 / count;
    covariance += DMatrix::from_diagonal(&(learnt * (m as f64 / count)));
    Some((mean, covariance))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::Verdict;
    use crate::robot::ROD;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    /// Deviation of data in units of the prior's, and how robots differ along each axis of it.
    const NOISE: f64 = 0.1;
    const SPREAD: [f64; 2] = [0.5, 0.02];

    /// Robots whose truth is drawn, c + S u, and what their data say of it.
    fn rows(robot: &Arc<Robot>, robots: usize) -> (Vec<Row>, DMatrix<f64>) {
        let model = robot
            .model("foot", Options::default().snapping(), None)
            .unwrap();
        let prior = PriorChoice::from(Prior::DEFAULT).of(&model).unwrap();
        let (centre, spread) = (prior.centre(&model), prior.spread(&model).unwrap());
        let m = spread.ncols();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let own = |k: usize| SPREAD[k.min(1)];
        // Data y = u + noise before a prior u ~ N(0, 1).
        let precision = 1.0 + NOISE.powi(-2);
        let covariance = &spread * spread.transpose() / precision;
        let lower = (0..centre.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let lower: Vec<f64> = lower.map(|at| covariance[at]).collect();
        let row = |k: usize| {
            let y = DVector::from_fn(m, |axis, _| {
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                own(axis) * normal() + NOISE * normal()
            });
            let params = &centre + &spread * (y * NOISE.powi(-2) / precision);
            Row {
                robot: format!("r{k}"),
                urdf_hash: robot.description.hash.clone(),
                support: "foot".into(),
                verdict: Some(Verdict::None),
                params: params.iter().copied().collect(),
                covariance: lower.clone(),
                ..Row::default()
            }
        };
        let rows = (0..robots).map(row).collect();
        let truth = DMatrix::from_diagonal(&DVector::from_fn(m, |k, _| own(k).powi(2)));
        (rows, &spread * truth * spread.transpose())
    }

    /// Along one axis robots differ by five deviations of their data, along the others by less.
    #[test]
    fn the_covariance_between_robots_is_that_without_noise() {
        let robot = Arc::new(Robot::parse(ROD, "rod.urdf").unwrap());
        let (rows, truth) = rows(&robot, 400);
        let found = population(&rows, &robot, &Options::default()).unwrap();
        assert_eq!((found.robots, found.support.as_str()), (400, "foot"));
        let n = found.mean.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| found.covariance[i][j]);
        let (ours, theirs) = (covariance.trace().sqrt(), truth.trace().sqrt());
        assert!((ours / theirs - 1.0).abs() < 0.15, "{ours} {theirs}");
        // No direction is narrower than robots are.
        let gap = covariance - 0.8 * truth;
        assert!(gap.symmetric_eigenvalues().min() > -1e-12, "{gap}");
    }

    /// A log that is listed on two days, or for two robots, is no second measurement.
    #[test]
    fn a_log_counts_once_in_whatever_rows_it_is() {
        let robot = Arc::new(Robot::parse(ROD, "rod.urdf").unwrap());
        let (mut rows, _) = rows(&robot, 8);
        for (k, row) in rows.iter_mut().enumerate() {
            row.day = "1".into();
            row.inputs = vec![format!("log {k}")];
        }
        let of = |rows: &[Row]| population(rows, &robot, &Options::default()).unwrap();
        let once = of(&rows);
        let mut again = rows.clone();
        // One under another day, one under a robot of its own.
        again.push(Row {
            day: "2".into(),
            ..rows[0].clone()
        });
        again.push(Row {
            robot: "z".into(),
            ..rows[1].clone()
        });
        again.reverse();
        assert_eq!(of(&again), once);
    }

    #[test]
    fn rows_with_other_effects_and_without_covariance_are_left_out() {
        let robot = Arc::new(Robot::parse(ROD, "rod.urdf").unwrap());
        let (mut rows, _) = rows(&robot, 6);
        rows[0].covariance.clear();
        rows[1].urdf_hash = "other".into();
        let said = population(&rows, &robot, &Options::default()).unwrap_err();
        assert!(said.to_string().contains("4 robots"), "{said}");
    }
}
