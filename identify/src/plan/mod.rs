//! Postures to take: balanced, clear, and the ones that tell most.
//!
//! ```text
//! limits → candidates (balance, ground, collisions) → design → order → posture file
//! ```
//!
//! One foot on the ground, N postures: which? Those whose readings leave the
//! least volume to the parameters' uncertainty, max log det(C⁻¹ + Σ φᵀφ / σ²),
//! among many in which the robot stands surely, given what CAD does not know.

pub(crate) mod candidates;
#[cfg(feature = "collision")]
mod collision;
/// Without the feature `collision` no body is watched.
#[cfg(not(feature = "collision"))]
mod collision {
    pub(super) struct Collisions {
        pub(super) exempt: Vec<[String; 2]>,
        pub(super) is_checked: bool,
        pub(super) sentence: String,
    }

    impl Collisions {
        pub(super) fn new(
            _: &sesc_model::Model,
            _: &super::shapes::Geometry,
            _: &[f64],
        ) -> Collisions {
            Collisions {
                exempt: Vec::new(),
                is_checked: false,
                sentence: "not checked: built without the feature `collision`".to_string(),
            }
        }

        pub(super) fn first(&self, _: &[crate::poses::Pose]) -> Option<(usize, usize)> {
            None
        }
    }
}
pub(crate) mod design;
mod limits;
mod report;
pub(crate) mod shapes;

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc_model::{Function, Model};

pub use candidates::Counts;
#[doc(hidden)]
pub use candidates::{Scene, sample};
pub use design::Efficiency;
pub use limits::Limits;
pub use report::{JointUse, Lesson, Motion, Plan, Revisits, TwoFeet};
#[doc(hidden)]
pub use shapes::Geometry;
pub use shapes::Region;

use crate::evaluate::Evaluator;
use crate::feet::{Closure, Feet, of_many};
use crate::fit::prior::{Prior, Tolerances};
use crate::logs::{LogSource, Sidecar};
use crate::lsq::factor::Factor;
use crate::lsq::solve::{UNSEEN, solve};
use crate::robot::Robot;
use crate::watch::{Watch, tell};
use crate::{Error, Message, Setting, message};
use design::WhitenedRows;

/// Plan postures.
///
/// ```
/// use std::sync::Arc;
///
/// use sesc_identify::plan::{Region, Request, plan};
/// use sesc_identify::robot::{Robot, Stance};
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <origin xyz='0 0 0.02'/><mass value='2'/></inertial></link>\
/// #   <joint name='hip' type='revolute'><parent link='foot'/><child link='top'/>\
/// #   <origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>";
/// let robot = Arc::new(Robot::parse(urdf, "pole.urdf")?);
/// let model = Stance::new(robot.clone()).on("foot").model()?;
/// let region = Region::square(0.023, 0.0)?;
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
    let (noise, visits) = report::known(request, watch)?;
    let dof = model.dof();
    if dof == 0 {
        return Err(Error::request(
            "no joint of this robot moves: there is only one posture",
        ));
    }
    let geometry = Geometry::read(&request.robot.description, request.folder.as_deref());
    let prior = request.prior.covariance_factor(model);
    if prior.as_ref().is_some_and(|s| s.ncols() == 0) {
        return Err(Error::request(
            "the prior leaves nothing to learn: its tolerances are zero",
        ));
    }
    let other = request.feet.of(&Sidecar::default(), model)?;
    let (limits, region) = (&request.limits, &request.region);
    let mut scene = Scene::new(model, &geometry, limits, region, request.clearance, other);
    scene.sigmas = request.sigmas;
    // Without a prior the first postures would teach from nothing: from what CAD usually knows.
    let usual = || Prior::Cad(Tolerances::usual()).covariance_factor(model);
    if let Some(uncertainty) = prior.clone().or_else(usual) {
        scene.uncertainty = uncertainty;
    }
    let both = scene.both_feet.as_ref();
    if let Some(note) = both.and_then(|feet| of_many(model, &feet.other)) {
        watch.note(&note);
    }
    let wanted = request.wanted();
    let draws = 100_usize.saturating_mul(wanted);
    let (q, counts) = sample(&scene, request.seed, wanted, draws, |found| {
        tell(watch, "drawing candidates", found as u64, wanted as u64)
    })?;
    let count = q.len() / dof;
    if count < request.poses {
        let why = candidates::shortage(&scene, request, &counts);
        return Err(Error::request(why));
    }

    let params = model.base.params.len();
    let regressor = Evaluator::new(model, Function::RegressorCop).run(&q, count);
    let regressor = DMatrix::from_vec(params, 2 * count, regressor);
    let rows = match &prior {
        Some(s) => WhitenedRows::with_prior(&regressor, s, noise),
        None => WhitenedRows::free(&regressor, UNSEEN),
    };
    let mut looked = 0_u64;
    let choice = rows.choose(request.poses, || {
        looked += 1;
        let total = looked.next_multiple_of(request.poses as u64);
        tell(watch, "choosing postures", looked, total)
    })?;
    let order = design::short_order(&some(&q, dof, &choice.chosen), dof);
    let chosen: Vec<usize> = order.into_iter().map(|k| choice.chosen[k]).collect();
    // Two rows of each of the chosen postures.
    let columns: Vec<usize> = chosen.iter().flat_map(|k| [2 * k, 2 * k + 1]).collect();
    let own_rows = regressor.select_columns(&columns).transpose();
    // As a fit of these postures will state them.
    let mut factor = Factor::new(params);
    let readings = 2 * chosen.len();
    factor.push(&own_rows, &DVector::zeros(readings), &vec![1.0; readings]);
    let solved = solve(&factor, 1.0, &DVector::zeros(params), None);
    let (rank, condition_number) = (solved.rank, solved.condition_number);
    let told = prior.is_some() || rank >= rows.directions();
    let lessons = report::lessons(model, &regressor, &scene.uncertainty, noise, &chosen);
    let curve = told.then(|| design::curve(&rows, &choice, noise, request.seed, prior.is_some()));
    let curve = curve.unwrap_or_default();

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
    let cop_of = |&k: &usize| [cop[2 * k], cop[2 * k + 1]];
    Ok(Plan {
        robot: model.tree.robot.clone(),
        hash: model.tree.hash.clone(),
        support: model.support().to_string(),
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
            as_chosen: design::way(&q, dof, &choice.chosen),
            ordered: design::way(&q, dof, &chosen),
        },
        clearance: scene.clearance.sentence(),
        collision: scene.collisions.sentence.clone(),
        collision_checked: scene.collisions.is_checked,
        collision_exempt: scene.collisions.exempt.clone(),
        notes,
        corners: request.region.corners.clone(),
        margin: request.region.margin,
        both_feet: both.map(|feet| {
            let q = some(&q, dof, &chosen);
            let closure = Closure::of(model, feet.other.clone(), &q, None);
            TwoFeet {
                other_foot: feet.other.name.clone(),
                offsets: closure.precision(),
            }
        }),
        revisits: report::revisits(request, visits, &own_rows),
        joints: report::joint_use(model, &request.limits, &q, &chosen),
        cop: chosen.iter().map(cop_of).collect(),
        log_det: choice.log_det,
        exchanges: choice.exchanges,
        curve,
        lessons,
        chosen,
        q,
    })
}

/// Some of the postures `q`, one after the other.
fn some(q: &[f64], dof: usize, chosen: &[usize]) -> Vec<f64> {
    let own = chosen.iter().flat_map(|&k| &q[k * dof..(k + 1) * dof]);
    own.copied().collect()
}

/// What is asked for.
#[derive(Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot, whose shapes must not collide.
    pub robot: Arc<Robot>,
    /// The robot on its support, with the parameters to balance with.
    pub model: Arc<Model>,
    /// Number of postures.
    pub poses: usize,
    /// Candidates to choose from; a default by the number of postures and parameters.
    pub candidates: Option<usize>,
    /// Where the CoP may be.
    pub region: Region,
    /// Safety margin of the CoP in standard deviations of its prediction.
    pub sigmas: f64,
    /// Joint limits.
    pub limits: Limits,
    /// What the later fit will know beforehand.
    pub prior: Prior,
    /// Standard deviation of a reading as it enters the fit, m.
    pub noise: f64,
    /// Least height of everything but the support body, m.
    pub clearance: f64,
    /// Seed of the candidates.
    pub seed: u64,
    /// Which feet are on the floor: the support alone, unless it says both.
    pub feet: Feet,
    /// Postures that are reached once more, as rows of the file; unless given, as many as tell
    /// what visits differ by are named, where no log knows it.
    pub revisits: Option<usize>,
    /// A log of this robot: its noise and what its visits differ by are those to come.
    pub log: Option<LogSource>,
    /// Where meshes may be.
    pub folder: Option<PathBuf>,
}

impl Request {
    /// A request for `poses` postures within the URDF's limits, with the CoP in `region`.
    pub fn new(
        robot: impl Into<Arc<Robot>>,
        model: impl Into<Arc<Model>>,
        poses: usize,
        region: Region,
    ) -> Request {
        let model = model.into();
        Request {
            robot: robot.into(),
            poses,
            candidates: None,
            region,
            sigmas: 2.0,
            limits: Limits::of_urdf(&model.tree.dofs),
            prior: Prior::Cad(Tolerances::usual()),
            noise: 0.0005,
            clearance: 0.005,
            seed: 1,
            feet: Feet::default(),
            revisits: None,
            log: None,
            folder: None,
            model,
        }
    }

    /// Whether the numbers make sense.
    fn check(&self) -> Result<(), Error> {
        let refused = |why: Message| Err(Error::request(why));
        let (positive, more) = ("give a number above zero", "give a number, zero or more");
        let numbers = [
            (Setting::Noise, self.noise, f64::MIN_POSITIVE, positive),
            (Setting::Margin, self.region.margin, 0.0, more),
            (Setting::Sigmas, self.sigmas, 0.0, more),
            (Setting::Clearance, self.clearance, 0.0, more),
        ];
        for (setting, value, least, remedy) in numbers {
            if !(value.is_finite() && value >= least) {
                return refused(message![setting, format!(" {value}: {remedy}")]);
            }
        }
        let ranges = self.limits.ranges.iter();
        if ranges.filter(|(lower, upper)| lower <= upper).count() != self.model.dof() {
            let remedy = ": give each joint a lower limit that is not above its upper one";
            return refused(message![Setting::Limits, remedy]);
        }
        let poses = self.poses;
        if let Some(candidates) = self.candidates.filter(|count| *count < poses) {
            let given = format!(" {candidates} for ");
            let remedy =
                format!(" {poses}: give at least as many, twenty times as many choose well");
            return refused(message![Setting::Candidates, given, Setting::Poses, remedy]);
        }
        if poses == 0 {
            return refused(message![Setting::Poses, " 0: give one or more"]);
        }
        Ok(())
    }

    /// Candidates to look for: twenty per posture unless told, within what is quickly
    /// worked on.
    pub(super) fn wanted(&self) -> usize {
        let params = self.model.base.params.len();
        let quick = 2_000_000_000 / (params * params).max(1);
        let usual = (20 * self.poses).clamp(2_000, 20_000);
        self.candidates
            .unwrap_or(usual.min(quick).max(2 * self.poses))
    }
}
