//! Postures to take: balanced, clear, and the ones that tell most.
//!
//! ```text
//! limits → candidates (balance, ground, collisions) → design → order → posture file
//! ```
//!
//! One foot on the ground, N postures: which? Those whose readings leave the
//! least volume to the parameters' uncertainty, max log det(C⁻¹ + Σ φᵀφ / σ²),
//! among many in which the robot stands surely, given what CAD does not know.

pub mod balance;
pub mod candidates;
pub mod clearance;
#[cfg(feature = "collision")]
pub mod collision;
pub mod design;
pub mod geometry;
pub mod joint_use;
pub mod limits;
mod mesh;
pub mod order;
pub mod poses;
pub mod worth;

use std::path::Path;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_model::{Function, Model};

use crate::evaluate::Evaluator;
use crate::fit::prior::{Prior, Tolerances};
use crate::lsq::factor::Factor;
use crate::lsq::solve::UNSEEN;
use crate::robot::Robot;
use crate::{Error, Message, Setting, message};
use balance::Region;
use candidates::{Counts, Demands, Sampler};
use clearance::Clearance;
use design::Rows;
use geometry::Geometry;
use joint_use::JointUse;
use limits::Limits;
use worth::Worth;

/// What is asked for.
pub struct Request<'a> {
    /// N
    pub poses: usize,
    /// K; a default by N and the number of parameters.
    pub candidates: Option<usize>,
    /// Where the CoP may be.
    pub region: Region,
    /// Standard deviations of the predicted CoP kept from the edge.
    pub sigmas: f64,
    pub limits: Limits,
    /// What the later fit will know beforehand.
    pub prior: Prior,
    /// Standard deviation of a reading as it enters the fit, m.
    pub noise: f64,
    /// Least height of everything but the support body, m.
    pub clearance: f64,
    pub seed: u64,
    /// Where meshes may be.
    pub folder: Option<&'a Path>,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    pub robot: String,
    pub support: String,
    pub poses: usize,
    /// Where the CoP stays, in words.
    pub cop_region: String,
    pub sigmas: f64,
    pub draws: Counts,
    pub candidates: usize,
    pub prior: String,
    pub noise: f64,
    /// Directions that the candidates can tell, and that the chosen ones do.
    pub directions: usize,
    pub rank: usize,
    pub condition_number: f64,
    /// RMS error of the CoP over all candidates that a fit will have, m.
    pub expected_error: Option<f64>,
    /// The same for random choices of as many candidates, on average.
    pub expected_error_random: Option<f64>,
    /// Both over the number of postures.
    pub curve: Vec<Worth>,
    /// log det of the information over the prior's: greedy, then per round of exchanges.
    pub log_det: Vec<f64>,
    pub exchanges: usize,
    pub motion: Motion,
    pub clearance: String,
    pub collision: String,
    /// Pairs of bodies that touch at rest and are not watched.
    pub collision_exempt: Vec<[String; 2]>,
    pub notes: Vec<String>,
    /// Corners of where the CoP may be, counter-clockwise, m, and how far from their
    /// edges it is kept.
    pub corners: Vec<[f64; 2]>,
    pub margin: f64,
    /// Predicted CoP of the chosen postures, m, in their order.
    pub cop: Vec<[f64; 2]>,
    /// What the chosen postures ask of every joint.
    pub joints: Vec<JointUse>,
    /// The chosen candidates in their order.
    #[serde(skip)]
    pub chosen: Vec<usize>,
    /// All candidates, `q[k * dof + joint]`, rad or m.
    #[serde(skip)]
    pub q: Vec<f64>,
}

/// The largest joint displacement from posture to posture, summed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motion {
    /// In the order of choice, rad (m for sliding joints).
    pub as_chosen: f64,
    pub ordered: f64,
}

/// Hears how far planning is: what, done, of how many.
pub type Progress<'p> = &'p dyn Fn(&'static str, u64, u64);

/// Draws per candidate asked for, before giving up.
const DRAWS: usize = 100;

/// Candidates unless told: twenty per posture, within what is quickly worked on.
fn default_candidates(poses: usize, params: usize) -> usize {
    let quick = 2_000_000_000 / (params * params).max(1);
    (20 * poses).clamp(2_000, 20_000).min(quick).max(2 * poses)
}

/// Plan postures.
///
/// # Errors
/// When fewer candidates are found than postures asked for; the message says why.
pub fn plan(
    robot: &Robot,
    model: &Model,
    request: &Request,
    progress: Progress,
) -> Result<Plan, Error> {
    let dof = model.dof();
    if dof == 0 {
        return Err(Error::request(
            "no joint of this robot moves: there is only one posture",
        ));
    }
    let geometry = Geometry::read(robot.text(), request.folder);
    let clearance = Clearance::new(model, &geometry, request.clearance);
    let prior = request.prior.factor(model);
    if prior.as_ref().is_some_and(|s| s.ncols() == 0) {
        return Err(Error::request(
            "the prior leaves nothing to learn: its tolerances are zero",
        ));
    }
    let usual = || Prior::Cad(Tolerances::usual()).factor(model);
    let uncertainty = prior.clone().or_else(usual);
    let uncertainty = uncertainty.unwrap_or_else(|| DMatrix::zeros(model.base.params.len(), 0));
    #[cfg(feature = "collision")]
    let collisions = collision::Collisions::new(model, &geometry, &request.limits.rest());
    let demands = Demands {
        limits: &request.limits,
        region: &request.region,
        sigmas: request.sigmas,
        uncertainty: &uncertainty,
        clearance: &clearance,
        #[cfg(feature = "collision")]
        collisions: &collisions,
    };
    let fallback = default_candidates(request.poses, model.base.params.len());
    let wanted = request.candidates.unwrap_or(fallback);
    let mut sampler = Sampler::new(model, demands, request.seed);
    let q = sampler.sample(wanted, DRAWS.saturating_mul(wanted), |found| {
        progress("drawing candidates", found as u64, wanted as u64);
    });
    let counts = sampler.counts;
    let count = q.len() / dof;
    if count < request.poses {
        return Err(Error::request(too_few(model, request, &clearance, &counts)));
    }
    let params = model.base.params.len();
    let regressor = Evaluator::new(model, Function::RegressorCop).run(&q, count);
    let regressor = DMatrix::from_vec(params, 2 * count, regressor);
    let rows = match &prior {
        Some(s) => Rows::with_prior(&regressor, s, request.noise),
        None => Rows::free(&regressor, UNSEEN),
    };
    let looked = std::cell::Cell::new(0);
    let choice = rows.choose(request.poses, |step| {
        looked.set(looked.get() + step);
        let rounds = looked.get().div_ceil(request.poses as u64);
        progress(
            "choosing postures",
            looked.get(),
            rounds * request.poses as u64,
        );
    });
    let (rank, condition_number) = conditioning(&regressor, &choice.chosen);
    let told = prior.is_some() || rank >= rows.directions();
    let chosen = ordered(&q, dof, &choice.chosen);
    let curve = match told {
        true => worth::curve(&rows, &choice, request.noise, request.seed, prior.is_some()),
        false => Vec::new(),
    };
    let last = curve.last();
    let mut notes = geometry.notes.clone();
    notes.extend(request.limits.notes.iter().cloned());
    if count < wanted {
        notes.push(format!(
            "{count} candidates instead of {wanted} after {} draws",
            counts.drawn
        ));
    }
    if !told {
        notes.push(format!(
            "{} postures tell {rank} of {} directions; a fit without a prior leaves the others at CAD",
            request.poses,
            rows.directions()
        ));
    }
    let cop = Evaluator::new(model, Function::Cop).run(&q, count);
    #[cfg(feature = "collision")]
    let (collision, collision_exempt) =
        (watched(&collisions, &geometry), collisions.exempt.clone());
    #[cfg(not(feature = "collision"))]
    let (collision, collision_exempt) = (
        "not checked: built without it; `cargo install --features collision` adds it".to_string(),
        Vec::new(),
    );
    Ok(Plan {
        robot: model.tree.robot.clone(),
        support: model.tree.links[model.tree.support].name.clone(),
        poses: request.poses,
        cop_region: request.region.sentence(),
        sigmas: request.sigmas,
        draws: counts,
        candidates: count,
        prior: request.prior.sentence(),
        noise: request.noise,
        directions: rows.directions(),
        rank,
        condition_number,
        expected_error: last.map(|worth| worth.planned),
        expected_error_random: last.map(|worth| worth.random),
        motion: Motion {
            as_chosen: order::length(&q, dof, &choice.chosen),
            ordered: order::length(&q, dof, &chosen),
        },
        log_det: choice.log_det.clone(),
        exchanges: choice.exchanges,
        clearance: clearance.sentence(),
        collision,
        collision_exempt,
        notes,
        corners: request.region.corners.clone(),
        margin: request.region.margin,
        joints: joint_use::of_all(model, &request.limits, &q, &chosen),
        cop: chosen
            .iter()
            .map(|&k| [cop[2 * k], cop[2 * k + 1]])
            .collect(),
        curve,
        chosen,
        q,
    })
}

impl Plan {
    /// The chosen postures in their order, rad or m.
    pub fn postures(&self) -> impl Iterator<Item = &[f64]> {
        let dof = self.q.len() / self.candidates.max(1);
        self.chosen
            .iter()
            .map(move |&k| &self.q[k * dof..(k + 1) * dof])
    }
}

fn ordered(q: &[f64], dof: usize, chosen: &[usize]) -> Vec<usize> {
    let own: Vec<f64> = chosen
        .iter()
        .flat_map(|&k| q[k * dof..(k + 1) * dof].iter().copied())
        .collect();
    order::shorten(&own, dof)
        .into_iter()
        .map(|k| chosen[k])
        .collect()
}

/// Rank and condition number of the chosen rows, as a fit will state them.
fn conditioning(regressor: &DMatrix<f64>, chosen: &[usize]) -> (usize, f64) {
    let columns: Vec<usize> = chosen.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
    let rows = regressor.select_columns(&columns).transpose();
    let mut factor = Factor::new(regressor.nrows());
    factor.push(
        &rows,
        &DVector::zeros(columns.len()),
        &vec![1.0; columns.len()],
    );
    let values = factor.r().singular_values();
    let largest = values.max();
    let seen: Vec<f64> = values
        .iter()
        .copied()
        .filter(|x| *x > UNSEEN * largest)
        .collect();
    let smallest = seen.iter().copied().fold(largest, f64::min);
    (seen.len(), largest / smallest)
}

#[cfg(feature = "collision")]
fn watched(collisions: &collision::Collisions, geometry: &Geometry) -> String {
    match (geometry.shapes.len(), collisions.watched) {
        (0, _) => "not checked: the robot has no collision shapes".to_string(),
        (shapes, pairs) => {
            format!("{pairs} pairs of bodies by {shapes} shapes; neighbours are exempt")
        }
    }
}

/// Why there are not enough candidates, with the numbers and what would help.
fn too_few(model: &Model, request: &Request, clearance: &Clearance, counts: &Counts) -> Message {
    let Counts {
        drawn,
        balanced,
        clear,
        collision_free,
        ..
    } = counts;
    let support = &model.tree.links[model.tree.support].name;
    let numbers = format!(
        "of {drawn} postures drawn, {balanced} balance on `{support}`, {clear} of them keep clear of \
         the ground, {collision_free} of these of themselves; {} are wanted",
        request.poses
    );
    let remedy = if *balanced < request.poses.max(drawn / 1000) {
        let miss = match counts.nearest_miss {
            Some(miss) if miss.is_finite() && *balanced == 0 => {
                format!(", the best one misses by {:.1} mm", 1e3 * miss)
            }
            _ => String::new(),
        };
        let strict = format!(
            "the CoP must stay within {} by {} standard deviations ({:.1} mm each on average){miss}",
            request.region.sentence(),
            request.sigmas,
            1e3 * counts.cop_std,
        );
        message![
            strict,
            ": give a larger ",
            Setting::CopBox,
            " or the ",
            Setting::Sole,
            ", a ",
            Setting::Prior,
            " that knows more, or ",
            Setting::Limits,
            " that suit the support"
        ]
    } else if *clear < request.poses.max(balanced / 1000) {
        let worst = (0..counts.low.len())
            .max_by_key(|&link| counts.low[link])
            .unwrap_or(0);
        let low = format!(
            "asked is {}; most often `{}` is too low: give a smaller ",
            clearance.sentence(),
            model.tree.links[worst].name
        );
        message![
            low,
            Setting::Clearance,
            ", narrower ",
            Setting::Limits,
            ", or a support whose z = 0 is its sole"
        ]
    } else if *collision_free < *clear {
        message!["give narrower ", Setting::Limits, ", or ask for fewer"]
    } else {
        message![
            "ask for fewer ",
            Setting::Poses,
            ", or allow more with ",
            Setting::Candidates
        ]
    };
    remedy.after(&format!("{numbers}\n  "))
}
