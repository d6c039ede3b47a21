//! Postures to be taken: plans, simulations, predictions.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sesc::report::{
    self,
    next_steps::{WithSteps, Worded},
};
use sesc_identify::feet::Feet;
use sesc_identify::fit::prior::Prior;
use sesc_identify::logs::{PostureWriter, Row, Sidecar, Written};
use sesc_identify::plan::Limits;
use sesc_identify::plan::Region;
use sesc_identify::plan::{self, Request};
use sesc_identify::predict::{self, predict};
use sesc_identify::robot::Stance;
use sesc_identify::simulate::hide;
use sesc_identify::simulate::{self, simulate};
use sesc_identify::skeleton::Skeleton;

use crate::calls::{Stopped, Waiting, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::model::{Model, json};
use crate::options::{angles, motion, taken};
use crate::robot::Robot;
use crate::steps;

/// Keywords of a plan, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct PlanOptions {
    poses: usize,
    cop_box: Option<f64>,
    sole: Option<String>,
    margin: f64,
    sigmas: f64,
    limits: Option<PathBuf>,
    /// Lower and upper limit of joints, rad or m.
    ranges: Option<Vec<(String, (f64, f64))>>,
    candidates: Option<usize>,
    prior: String,
    noise: f64,
    clearance: f64,
    seed: u64,
    revisits: Option<usize>,
    both_feet: bool,
    other_foot: Option<String>,
}

/// Postures that tell most.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct PlanReport {
    plan: plan::Plan,
    skeleton: Skeleton,
}

/// Choose postures that tell most about the parameters.
#[pyfunction]
#[pyo3(signature = (robot, model, data, options, show=None))]
pub fn plan_postures(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model: PyRef<'_, Model>,
    data: Option<PyRef<'_, Log>>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<PlanReport> {
    let options: PlanOptions = taken(options, Doing::Plan)?;
    let (robot, folder, model) = (
        robot.inner.clone(),
        robot.folder.clone(),
        model.inner.clone(),
    );
    let log = data.map(|log| log.source.clone());
    let plan = watched(py, show, Stopped::Abandoned, move |watch| {
        let build = |watch: &mut Waiting| -> Result<_, sesc_identify::Error> {
            let region = match (&options.sole, options.cop_box) {
                (Some(sole), _) => Region::sole(sole, options.margin)?,
                (None, Some(half)) => Region::square(half, options.margin)?,
                (None, None) => {
                    let folder = folder.as_deref();
                    Region::of_support(&model, &robot.description, folder, options.margin)?
                }
            };
            let mut request = Request::new(robot, model, options.poses, region);
            request.candidates = options.candidates;
            request.sigmas = options.sigmas;
            if let Some(path) = &options.limits {
                request.limits = Limits::read(path, &request.model.tree.dofs)?;
            }
            if let Some(ranges) = &options.ranges {
                let asked = ranges.iter().map(|(joint, range)| (joint.as_str(), *range));
                request.limits = Limits::of_joints(asked, &request.model.tree.dofs)?;
            }
            request.prior = Prior::named(&options.prior, &request.model)?;
            request.noise = options.noise;
            request.clearance = options.clearance;
            request.seed = options.seed;
            request.revisits = options.revisits;
            request.log = log;
            request.feet = Feet {
                both: options.both_feet.then_some(true),
                other: options.other_foot,
            };
            request.folder = folder;
            let (description, folder) = (&request.robot.description, request.folder.as_deref());
            let skeleton = Skeleton::of(&request.model, description, folder);
            plan::plan(&request, watch).map(|plan| PlanReport { plan, skeleton })
        };
        build(watch).during(Doing::Plan)
    });
    Ok(plan?.0)
}

impl PlanReport {
    fn next_steps(&self) -> Vec<Worded> {
        steps::worded(&self.plan.next_steps(), steps::text)
    }
}

#[pymethods]
impl PlanReport {
    /// What `sesc plan --json` prints.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            json(&WithSteps {
                found: &self.plan,
                next_steps: &self.next_steps(),
            })
        })
    }

    /// What `sesc plan` prints.
    fn text(&self) -> String {
        report::plan::text(&self.plan, &self.next_steps())
    }

    /// The page of `sesc plan --report`.
    fn page(&self, py: Python<'_>, file: &str, command: &str) -> PyResult<String> {
        detached(py, || {
            let (plan, next) = (&self.plan, self.next_steps());
            report::plan::page(plan, &next, &self.skeleton, file, command)
                .map_err(Failure::internal)
        })
    }

    /// Numbers and joint positions of the rows of its file.
    #[allow(clippy::type_complexity)]
    fn rows<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<f64>>)> {
        let (poses, q): (Vec<i64>, Vec<Vec<f64>>) =
            self.plan.rows().map(|(pose, q)| (pose, q.to_vec())).unzip();
        Ok((PyArray1::from_vec(py, poses), PyArray2::from_vec2(py, &q)?))
    }
}

/// Write postures with their numbers (of a stand on both feet where there is another foot) as a
/// log with a sidecar, whose path is given back.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn write_postures(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    q: PyReadonlyArray2<'_, f64>,
    poses: Vec<i64>,
    path: PathBuf,
    experiment: Option<String>,
    other_foot: Option<String>,
) -> PyResult<PathBuf> {
    let (model, dof) = (model.inner.clone(), q.shape()[1]);
    let q = q.as_array().iter().copied().collect::<Vec<f64>>();
    detached(py, || {
        let write = || -> Result<_, sesc_identify::Error> {
            let mut log = PostureWriter::create(&path, &model.tree.dofs, Written::default())?;
            for (pose, q) in poses.into_iter().zip(q.chunks_exact(dof.max(1))) {
                log.row(&Row {
                    pose,
                    q,
                    ..Row::default()
                })?;
            }
            log.finish(&Sidecar {
                robot: Some(model.tree.robot.clone()),
                support: Some(model.support().to_string()),
                experiment,
                both_feet: other_foot.as_ref().map(|_| true),
                other_foot,
                ..Sidecar::default()
            })?;
            Ok(Sidecar::path(&path))
        };
        write().during(Doing::Plan)
    })
}

/// Keywords of a simulation, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct SimulateOptions<'py> {
    poses: usize,
    postures: Option<PyReadonlyArray2<'py, f64>>,
    numbers: Option<Vec<i64>>,
    range: Option<f64>,
    noise: f64,
    seed: u64,
    rate: Option<f64>,
    motion: bool,
    hide: Vec<String>,
}

/// A posture log of an ideal robot, with CoP noise.
#[pyfunction]
#[pyo3(signature = (model, options, show=None))]
pub fn simulate_log(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<Log> {
    let options: SimulateOptions<'_> = taken(options, Doing::Log)?;
    let postures = options.postures.as_ref();
    let postures = postures.map(|q| q.as_array().iter().copied().collect::<Vec<f64>>());
    let SimulateOptions {
        poses,
        range,
        noise,
        seed,
        rate,
        numbers,
        motion: moves,
        hide: hidden,
        ..
    } = options;
    let model = model.inner.clone();
    let log = watched(py, show, Stopped::Abandoned, move |watch| {
        let build = |watch: &mut Waiting| -> Result<_, sesc_identify::Error> {
            let model = hide((*model).clone(), &hidden)?;
            let mut request = simulate::Request::new(model, poses);
            request.postures = postures;
            request.numbers = numbers;
            request.range = range;
            request.noise = noise;
            request.seed = seed;
            request.rate = rate;
            request.motion = motion(moves);
            let log = simulate(&request, watch)?;
            Ok(Log::simulated(log, request))
        };
        build(watch).during(Doing::Log)
    });
    Ok(log?.0)
}

/// Pose, CoM and CoP of every row of a log, m.
#[pyfunction]
#[pyo3(signature = (robot, support, model, log, degrees=None, moves=true, show=None))]
#[allow(clippy::type_complexity, clippy::too_many_arguments)]
pub fn predict_log<'py>(
    py: Python<'py>,
    robot: PyRef<'_, Robot>,
    support: Option<String>,
    model: PyRef<'_, Model>,
    log: PyRef<'_, Log>,
    degrees: Option<bool>,
    moves: bool,
    show: Option<Py<PyAny>>,
) -> PyResult<(
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
)> {
    let mut stance = Stance::new(robot.inner.clone());
    stance.support = support;
    stance.snapping = robot.snapping;
    stance.parameters = model.inner.file.clone().map(Into::into);
    let mut request = predict::Request::new(stance, &log.source);
    request.angles = degrees.map(angles);
    request.motion = motion(moves);
    let (found, _) = watched(py, show, Stopped::Abandoned, move |watch| {
        predict(&request, watch).during(Doing::Log)
    })?;
    let n = found.pose.len();
    let com = PyArray1::from_slice(py, found.com_m.as_flattened()).reshape([n, 3])?;
    let cop = PyArray1::from_slice(py, found.cop_m.as_flattened()).reshape([n, 2])?;
    Ok((PyArray1::from_vec(py, found.pose), com, cop))
}
