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
pub(crate) mod both_feet;
pub(crate) mod candidates;
mod clearance;
#[cfg_attr(not(feature = "collision"), path = "no_collision.rs")]
mod collision;
mod design;
pub mod efficiency;
pub(crate) mod geometry;
pub mod joint_use;
mod lessons;
pub mod limits;
mod mesh;
pub(crate) mod order;
mod report;
mod request;
mod revisits;
pub(crate) mod scene;
mod shortage;
pub(crate) mod sole;

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use sesc_model::{Function, Model};

pub use candidates::Counts;
#[doc(hidden)]
pub use candidates::sample;
#[doc(hidden)]
pub use geometry::Geometry;
pub use lessons::Lesson;
pub use report::{Motion, Plan, TwoFeet};
pub use request::{COP_BOX, Request};
pub use revisits::Revisits;
#[doc(hidden)]
pub use scene::Scene;

use crate::Error;
use crate::evaluate::Evaluator;
use crate::feet::{Closure, of_many};
use crate::fit::prior::{Prior, Tolerances};
use crate::logs::Sidecar;
use crate::lsq::factor::Factor;
use crate::lsq::solve::UNSEEN;
use crate::observations::revisits::spread;
use crate::svd::singular_values;
use crate::watch::{Progress, Watch, stopped};
use both_feet::BothFeet;
use design::{Choice, WhitenedRows};
use revisits::Known;

/// Draws per candidate asked for, before giving up.
const DRAWS: usize = 100;

/// Plan postures.
///
/// ```
/// use std::sync::Arc;
///
/// use sesc_identify::plan::balance::Region;
/// use sesc_identify::plan::{COP_BOX, Request, plan};
/// use sesc_identify::robot::Robot;
/// use sesc_identify::stance::Stance;
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <origin xyz='0 0 0.02'/><mass value='2'/></inertial></link>\
/// #   <joint name='hip' type='revolute'><parent link='foot'/><child link='top'/>\
/// #   <origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>";
/// let robot = Arc::new(Robot::parse(urdf, "pole.urdf")?);
/// let model = Stance::new(robot.clone()).on("foot").model()?;
/// let region = Region::square(COP_BOX, 0.0)?;
/// let mut request = Request::new(robot, model, 5, region);
/// request.candidates = Some(50);
/// request.sigmas = 0.0;
/// let plan = plan(&request, &mut ())?;
/// assert_eq!(plan.postures().count(), 5);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// When fewer candidates are found than postures asked for; the message says why.
pub fn plan(request: &Request, watch: &mut dyn Watch) -> Result<Plan, Error> {
    request.check()?;
    let model = &*request.model;
    let known = Known::of(request, watch)?;
    let dof = model.dof();
    if dof == 0 {
        return Err(Error::request(
            "no joint of this robot moves: there is only one posture",
        ));
    }
    let geometry = Geometry::read(&request.robot.description, request.folder.as_deref());
    let prior = request.prior.covariance_factor(model);
    let scene = scene(request, &geometry, prior.as_ref())?;
    let both = scene.both_feet.as_ref();
    if let Some(note) = both.and_then(|feet| of_many(model, &feet.other)) {
        watch.note(&note);
    }
    let (q, counts) = candidates_in(&scene, request, watch)?;
    let count = q.len() / dof;

    let params = model.base.params.len();
    let regressor = Evaluator::new(model, Function::RegressorCop).run(&q, count);
    let regressor = DMatrix::from_vec(params, 2 * count, regressor);
    let noise = known.reading_std(request.noise);
    let rows = match &prior {
        Some(s) => WhitenedRows::with_prior(&regressor, s, noise),
        None => WhitenedRows::free(&regressor, UNSEEN),
    };
    let choice = choose(&rows, request.poses, watch)?;
    let (rank, condition_number) = conditioning(&regressor, &choice.chosen);
    let told = prior.is_some() || rank >= rows.directions();
    let chosen = ordered(&q, dof, &choice.chosen);
    let lessons = lessons::lessons(model, &regressor, &scene.uncertainty, noise, &chosen);
    let curve = match told {
        true => efficiency::curve(&rows, &choice, noise, request.seed, prior.is_some()),
        false => Vec::new(),
    };

    let mut notes = geometry.notes.clone();
    notes.extend(request.limits.notes.iter().cloned());
    if count < request.wanted() {
        notes.push(format!(
            "{count} candidates instead of {} after {} draws",
            request.wanted(),
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
    let cop_of = |&k: &usize| [cop[2 * k], cop[2 * k + 1]];
    Ok(Plan {
        robot: model.tree.robot.clone(),
        hash: model.tree.hash.clone(),
        support: model.tree.links[model.tree.support].name.clone(),
        poses: request.poses,
        cop_region: request.region.sentence(),
        sigmas: request.sigmas,
        draws: counts,
        candidates: count,
        prior: request.prior.sentence(),
        noise,
        directions: rows.directions(),
        rank,
        condition_number,
        expected_error: curve.last().map(|point| point.planned),
        expected_error_random: curve.last().map(|point| point.random),
        motion: Motion {
            as_chosen: order::length(&q, dof, &choice.chosen),
            ordered: order::length(&q, dof, &chosen),
        },
        clearance: scene.clearance.sentence(),
        collision: scene.collisions.sentence(),
        collision_checked: scene.collisions.is_checked(),
        collision_exempt: scene.collisions.exempt.clone(),
        notes,
        corners: request.region.corners.clone(),
        margin: request.region.margin,
        both_feet: both.map(|feet| soles(feet, model, &some(&q, dof, &chosen))),
        revisits: revisits_of(request, &known, &regressor, &chosen),
        joints: joint_use::of_all(model, &request.limits, &q, &chosen),
        cop: chosen.iter().map(cop_of).collect(),
        log_det: choice.log_det,
        exchanges: choice.exchanges,
        curve,
        lessons,
        chosen,
        q,
    })
}

/// What postures have to respect: a robot that stands in spite of what `prior` leaves open.
fn scene<'a>(
    request: &'a Request,
    geometry: &Geometry,
    prior: Option<&DMatrix<f64>>,
) -> Result<Scene<'a>, Error> {
    let model = &*request.model;
    if prior.is_some_and(|s| s.ncols() == 0) {
        return Err(Error::request(
            "the prior leaves nothing to learn: its tolerances are zero",
        ));
    }
    let other = request.feet.of(&Sidecar::default(), model)?;
    let (limits, region) = (&request.limits, &request.region);
    let mut scene = Scene::new(model, geometry, limits, region, request.clearance, other);
    scene.sigmas = request.sigmas;
    // Without a prior the first postures would teach from nothing: from what CAD usually knows.
    let usual = || Prior::Cad(Tolerances::usual()).covariance_factor(model);
    if let Some(uncertainty) = prior.cloned().or_else(usual) {
        scene.uncertainty = uncertainty;
    }
    Ok(scene)
}

/// Postures to choose from, one after the other, and what became of the draws.
fn candidates_in(
    scene: &Scene,
    request: &Request,
    watch: &mut dyn Watch,
) -> Result<(Vec<f64>, Counts), Error> {
    let wanted = request.wanted();
    let mut flow = ControlFlow::Continue(());
    let draws = DRAWS.saturating_mul(wanted);
    let (q, counts) = candidates::sample(scene, request.seed, wanted, draws, |found| {
        flow = watch.progress(Progress {
            what: "drawing candidates",
            done: found as u64,
            total: Some(wanted as u64),
        });
        flow
    });
    stopped(flow)?;
    match q.len() / scene.model.dof() < request.poses {
        true => Err(Error::request(shortage::sentence(scene, request, &counts))),
        false => Ok((q, counts)),
    }
}

/// The `poses` candidates that tell most.
fn choose(rows: &WhitenedRows, poses: usize, watch: &mut dyn Watch) -> Result<Choice, Error> {
    let mut flow = ControlFlow::Continue(());
    let (mut looked, poses_u64) = (0, poses as u64);
    let choice = rows.choose(poses, |step| {
        looked += step;
        let rounds = looked.div_ceil(poses_u64);
        flow = watch.progress(Progress {
            what: "choosing postures",
            done: looked,
            total: Some(rounds * poses_u64),
        });
        flow
    });
    stopped(flow)?;
    Ok(choice)
}

/// Which of the chosen postures come back, spread over what their rows tell.
fn revisits_of(
    request: &Request,
    known: &Known,
    regressor: &DMatrix<f64>,
    chosen: &[usize],
) -> Revisits {
    let count = revisits::count(request, known);
    let spread = spread(&rows_of(regressor, chosen), count);
    let poses = spread.into_iter().map(|k| k as i64 + 1).collect();
    revisits::said(poses, request, known)
}

/// What the soles of the chosen postures `q` tell.
fn soles(feet: &BothFeet, model: &Model, q: &[f64]) -> TwoFeet {
    let closure = Closure::of(model, feet.other.clone(), q, None);
    TwoFeet {
        other_foot: feet.other.name.clone(),
        offsets: closure.precision(),
    }
}

/// Some of the postures `q`, one after the other.
fn some(q: &[f64], dof: usize, chosen: &[usize]) -> Vec<f64> {
    let own = chosen.iter().flat_map(|&k| &q[k * dof..(k + 1) * dof]);
    own.copied().collect()
}

/// Rows of the chosen postures, two each, of a regressor's transpose.
fn rows_of(regressor: &DMatrix<f64>, chosen: &[usize]) -> DMatrix<f64> {
    let columns: Vec<usize> = chosen.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
    regressor.select_columns(&columns).transpose()
}

fn ordered(q: &[f64], dof: usize, chosen: &[usize]) -> Vec<usize> {
    let order = order::shorten(&some(q, dof, chosen), dof);
    order.into_iter().map(|k| chosen[k]).collect()
}

/// Rank and condition number of the chosen rows, as a fit will state them.
fn conditioning(regressor: &DMatrix<f64>, chosen: &[usize]) -> (usize, f64) {
    let rows = rows_of(regressor, chosen);
    let n = rows.nrows();
    let mut factor = Factor::new(regressor.nrows());
    factor.push(&rows, &DVector::zeros(n), &vec![1.0; n]);
    let values = singular_values(factor.r());
    let largest = values.max();
    let seen = values.iter().copied().filter(|x| *x > UNSEEN * largest);
    let seen: Vec<f64> = seen.collect();
    let smallest = seen.iter().copied().fold(largest, f64::min);
    (seen.len(), largest / smallest)
}
