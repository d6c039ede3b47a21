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
pub mod both_feet;
#[cfg(feature = "nalgebra")]
#[doc(hidden)]
pub mod candidates;
#[cfg(not(feature = "nalgebra"))]
#[allow(dead_code)]
pub(crate) mod candidates;
#[cfg(feature = "nalgebra")]
#[doc(hidden)]
pub mod clearance;
#[cfg(not(feature = "nalgebra"))]
#[allow(dead_code)]
pub(crate) mod clearance;
#[cfg(all(feature = "collision", feature = "nalgebra"))]
#[doc(hidden)]
pub mod collision;
#[cfg(all(feature = "collision", not(feature = "nalgebra")))]
#[allow(dead_code)]
pub(crate) mod collision;
mod design;
pub mod efficiency;
#[cfg(feature = "nalgebra")]
#[doc(hidden)]
pub mod geometry;
#[cfg(not(feature = "nalgebra"))]
#[allow(dead_code)]
pub(crate) mod geometry;
pub mod joint_use;
pub mod limits;
mod mesh;
pub(crate) mod order;
pub(crate) mod poses;
mod request;
mod revisits;

use std::ops::ControlFlow;
use std::path::PathBuf;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use sesc_model::{Function, Model};

use crate::evaluate::Evaluator;
use crate::feet::{Closure, Offset};
use crate::fit::prior::{Prior, Tolerances};
use crate::logs::{LogSource, PostureWriter, Row, Sidecar, Table};
use crate::lsq::factor::Factor;
use crate::lsq::solve::UNSEEN;
use crate::observations::again::spread;
use crate::svd::singular_values;
use crate::watch::{Progress, Watch, stopped};
use crate::{Error, Message, Setting, message};
use both_feet::BothFeet;
pub use candidates::Counts;
use candidates::{Demands, Sampler};
use clearance::Clearance;
use design::Rows;
use efficiency::Efficiency;
use geometry::Geometry;
use joint_use::JointUse;
pub use request::{COP_BOX, Request};
use revisits::Known;
pub use revisits::Revisits;

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// The robot's name.
    pub robot: String,
    /// The link on the ground.
    pub support: String,
    /// Number of postures.
    pub poses: usize,
    /// Where the CoP stays, in words.
    pub cop_region: String,
    /// Safety margin of the CoP in standard deviations.
    pub sigmas: f64,
    /// What was drawn.
    pub draws: Counts,
    /// Postures that were chosen from.
    pub candidates: usize,
    /// What the later fit will know beforehand, in words.
    pub prior: String,
    /// Standard deviation of a reading, m.
    pub noise: f64,
    /// Directions of the parameters that the candidates can tell.
    pub directions: usize,
    /// Directions that the chosen postures tell.
    pub rank: usize,
    /// Condition number of the chosen postures' rows.
    pub condition_number: f64,
    /// RMS error of the CoP over all candidates that a fit will have, m.
    pub expected_error: Option<f64>,
    /// The same for random choices of as many candidates, on average.
    pub expected_error_random: Option<f64>,
    /// Both over the number of postures.
    pub curve: Vec<Efficiency>,
    /// log det of the information over the prior's: greedy, then per round of exchanges.
    pub log_det: Vec<f64>,
    /// Exchanges that improved the greedy choice.
    pub exchanges: usize,
    /// How far the joints move from posture to posture.
    pub motion: Motion,
    /// What was kept clear of the ground, in words.
    pub clearance: String,
    /// What was kept from colliding, in words.
    pub collision: String,
    /// Pairs of bodies that touch at rest and are not watched.
    pub collision_exempt: Vec<[String; 2]>,
    /// What was noticed.
    pub notes: Vec<String>,
    /// Corners of where the CoP may be, counter-clockwise, m.
    pub corners: Vec<[f64; 2]>,
    /// How far the CoP is kept from their edges, m.
    pub margin: f64,
    /// Predicted CoP of the chosen postures, m, in their order.
    pub cop: Vec<[f64; 2]>,
    /// Postures that come back after the last, under their own numbers.
    pub revisits: Revisits,
    /// What the soles will tell, where both are on the floor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub both_feet: Option<TwoFeet>,
    /// What the chosen postures ask of every joint.
    pub joints: Vec<JointUse>,
    /// The chosen candidates in their order.
    #[serde(skip)]
    pub chosen: Vec<usize>,
    /// All candidates, `q[k * dof + joint]`, rad or m.
    #[serde(skip)]
    pub q: Vec<f64>,
}

/// What the soles of a plan on both feet will tell.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TwoFeet {
    /// The link that is the other sole.
    pub other_foot: String,
    /// Joints between the soles, and how well their soles know the offset of each alone; those
    /// that move no sole are left out.
    pub offsets: Vec<Offset>,
}

impl TwoFeet {
    /// In a few words.
    pub fn sentence(&self) -> String {
        let worst = self.offsets.iter().max_by(|a, b| a.std.total_cmp(&b.std));
        match worst {
            Some(worst) => format!(
                "both soles on the floor, `{}` the other: how it lies tells an offset of each of {} \
                 joints, of `{}` worst (± {:.2}°)",
                self.other_foot,
                self.offsets.len(),
                worst.joint,
                worst.std.to_degrees()
            ),
            None => format!("both soles on the floor, `{}` the other", self.other_foot),
        }
    }
}

/// The largest joint displacement from posture to posture, summed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Motion {
    /// In the order of choice, rad (m for prismatic joints).
    pub as_chosen: f64,
    /// In the order of the plan.
    pub ordered: f64,
}

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
    let noise = known.of_posture(request.noise);
    let dof = model.dof();
    if dof == 0 {
        return Err(Error::request(
            "no joint of this robot moves: there is only one posture",
        ));
    }
    let geometry = Geometry::read(&request.robot.description, request.folder.as_deref());
    let both_feet = match request.feet.of(&Sidecar::default(), model)? {
        Some(other) => BothFeet::new(model, other, &request.limits.rest()),
        None => None,
    };
    let standing = both_feet.as_ref().map(|feet| feet.body);
    let clearance = Clearance::new(model, &geometry, request.clearance, standing);
    let prior = request.prior.covariance_factor(model);
    if prior.as_ref().is_some_and(|s| s.ncols() == 0) {
        return Err(Error::request(
            "the prior leaves nothing to learn: its tolerances are zero",
        ));
    }
    let usual = || Prior::Cad(Tolerances::usual()).covariance_factor(model);
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
        both_feet: both_feet.as_ref(),
        #[cfg(feature = "collision")]
        collisions: &collisions,
    };
    let wanted = request.wanted();
    let mut sampler = Sampler::new(model, demands, request.seed);
    let mut flow = ControlFlow::Continue(());
    let q = sampler.sample(wanted, DRAWS.saturating_mul(wanted), |found| {
        flow = watch.progress(Progress {
            what: "drawing candidates",
            done: found as u64,
            total: Some(wanted as u64),
        });
        flow
    });
    stopped(flow)?;
    let counts = sampler.counts;
    let count = q.len() / dof;
    if count < request.poses {
        return Err(Error::request(too_few(model, request, &clearance, &counts)));
    }
    let params = model.base.params.len();
    let regressor = Evaluator::new(model, Function::RegressorCop).run(&q, count);
    let regressor = DMatrix::from_vec(params, 2 * count, regressor);
    let rows = match &prior {
        Some(s) => Rows::with_prior(&regressor, s, noise),
        None => Rows::free(&regressor, UNSEEN),
    };
    let (mut looked, poses) = (0, request.poses as u64);
    let choice = rows.choose(request.poses, |step| {
        looked += step;
        let rounds = looked.div_ceil(poses);
        flow = watch.progress(Progress {
            what: "choosing postures",
            done: looked,
            total: Some(rounds * poses),
        });
        flow
    });
    stopped(flow)?;
    let (rank, condition_number) = conditioning(&regressor, &choice.chosen);
    let told = prior.is_some() || rank >= rows.directions();
    let chosen = ordered(&q, dof, &choice.chosen);
    let again = revisits::count(request, &known);
    let columns: Vec<usize> = chosen.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
    let spread = spread(&regressor.select_columns(&columns).transpose(), again);
    let again: Vec<i64> = spread.into_iter().map(|k| k as i64 + 1).collect();
    let again = revisits::said(again, request, &known);
    let curve = match told {
        true => efficiency::curve(&rows, &choice, noise, request.seed, prior.is_some()),
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
    let soles = both_feet.as_ref().map(|feet| {
        let own = chosen.iter().flat_map(|&k| &q[k * dof..(k + 1) * dof]);
        let own: Vec<f64> = own.copied().collect();
        let closure = Closure::of(model, feet.other.clone(), &own, None);
        TwoFeet {
            other_foot: feet.other.name.clone(),
            offsets: closure.precision(),
        }
    });
    let cop = Evaluator::new(model, Function::Cop).run(&q, count);
    #[cfg(feature = "collision")]
    let (collision, collision_exempt) =
        (watched(&collisions, &geometry), collisions.exempt.clone());
    #[cfg(not(feature = "collision"))]
    let (collision, collision_exempt) = (
        "not checked: built without the feature `collision`".to_string(),
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
        noise,
        directions: rows.directions(),
        rank,
        condition_number,
        expected_error: last.map(|point| point.planned),
        expected_error_random: last.map(|point| point.random),
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
        both_feet: soles,
        revisits: again,
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
    /// The postures as a log in memory, those that come back included.
    pub fn log(&self) -> LogSource {
        let rows: Vec<usize> = self.rows().collect();
        let poses: Vec<i64> = rows.iter().map(|&k| k as i64 + 1).collect();
        let table = Table::new("plan").integers("pose", poses);
        let joints = self.joints.iter();
        let table = joints.fold(table, |table, joint| {
            let values: Vec<f64> = rows.iter().map(|&k| joint.values[k]).collect();
            table.numbers(&joint.joint, values)
        });
        LogSource::from(table).with_sidecar(self.sidecar())
    }

    /// Write the postures as a log, those that come back included; gives back where its
    /// sidecar is.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, mut log: PostureWriter) -> Result<PathBuf, Error> {
        let postures: Vec<&[f64]> = self.postures().collect();
        for k in self.rows() {
            log.row(&Row {
                pose: k as i64 + 1,
                q: postures[k],
                ..Row::default()
            })?;
        }
        log.finish(&self.sidecar())
    }

    /// Places of the postures, row by row.
    fn rows(&self) -> impl Iterator<Item = usize> {
        let again = self.revisits.poses.iter().map(|pose| *pose as usize - 1);
        let again = again.filter(|_| self.revisits.written);
        (0..self.chosen.len()).chain(again)
    }

    fn sidecar(&self) -> Sidecar {
        Sidecar {
            robot: Some(self.robot.clone()),
            support: Some(self.support.clone()),
            both_feet: self.both_feet.as_ref().map(|_| true),
            other_foot: self.both_feet.as_ref().map(|feet| feet.other_foot.clone()),
            ..Sidecar::default()
        }
    }

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
    let values = singular_values(factor.r());
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
