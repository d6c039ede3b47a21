//! Postures to be taken: plans, simulations, predictions.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sesc::report::{self, next_steps::WithSteps};
use sesc_identify::feet::Feet;
use sesc_identify::fit::prior::Prior;
use sesc_identify::logs::{PostureWriter, Row, Sidecar, Written};
use sesc_identify::plan::{self, Limits, Region, Request};
use sesc_identify::predict::{self, predict};
use sesc_identify::robot::Stance;
use sesc_identify::simulate::{self, hide, simulate};

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
pub(crate) struct PlanOptions {
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

/// What `sesc plan` prints as JSON and as text, and its page.
#[derive(IntoPyObject)]
pub(crate) struct Planned {
    json: String,
    text: String,
    page: String,
}

/// Numbers of postures, and their joint positions.
type Rows<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray2<f64>>);

/// Choose postures that tell most about the parameters: the rows of their file, and what is said
/// of them.
#[pyfunction]
#[pyo3(signature = (robot, model, data, options, show=None))]
pub(crate) fn plan_postures<'py>(
    py: Python<'py>,
    robot: PyRef<'_, Robot>,
    model: PyRef<'_, Model>,
    data: Option<PyRef<'_, Log>>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<(Rows<'py>, Planned)> {
    let options: PlanOptions = taken(options, Doing::Plan)?;
    let (own, model, folder) = (&*robot, model.inner.clone(), robot.folder.clone());
    let skeleton = detached(py, || Ok(own.skeleton(&model)))?;
    let robot = robot.inner.clone();
    let log = data.map(|log| log.source.clone());
    let (plan, said) = watched(py, show, Stopped::Abandoned, move |watch| {
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
            plan::plan(&request, watch)
        };
        let plan = build(watch).during(Doing::Plan)?;
        let next_steps = steps::worded(&plan.next_steps(), steps::text);
        let page = report::plan::page(&plan, &next_steps, &skeleton, "plan", "sesc.plan(…)");
        let said = Planned {
            json: json(&WithSteps {
                found: &plan,
                next_steps: &next_steps,
            })?,
            text: report::plan::text(&plan, &next_steps),
            page: page.map_err(Failure::internal)?,
        };
        Ok((plan, said))
    })?;
    let (poses, q): (Vec<i64>, Vec<Vec<f64>>) =
        plan.rows().map(|(pose, q)| (pose, q.to_vec())).unzip();
    let rows = (PyArray1::from_vec(py, poses), PyArray2::from_vec2(py, &q)?);
    Ok((rows, said))
}

/// Write postures with their numbers (of a stand on both feet where there is another foot) as a
/// log with a sidecar, whose path is given back.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn write_postures(
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
pub(crate) struct SimulateOptions<'py> {
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
pub(crate) fn simulate_log(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<Log> {
    let options: SimulateOptions<'_> = taken(options, Doing::Log)?;
    let mut request = simulate::Request::new(model.inner.clone(), options.poses);
    let postures = options.postures.as_ref();
    request.postures = postures.map(|q| q.as_array().iter().copied().collect());
    request.numbers = options.numbers;
    request.range = options.range;
    request.noise = options.noise;
    request.seed = options.seed;
    request.rate = options.rate;
    request.motion = motion(options.motion);
    let hidden = options.hide;
    watched(py, show, Stopped::Abandoned, move |watch| {
        let model = hide((*request.model).clone(), &hidden).during(Doing::Log)?;
        request.model = Arc::new(model);
        let log = simulate(&request, watch).during(Doing::Log)?;
        Ok(Log::simulated(log, request))
    })
}

/// Pose, CoM and CoP of every row of a log, m.
#[pyfunction]
#[pyo3(signature = (robot, support, model, log, degrees=None, moves=true, show=None))]
#[allow(clippy::type_complexity, clippy::too_many_arguments)]
pub(crate) fn predict_log<'py>(
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
    let found = watched(py, show, Stopped::Abandoned, move |watch| {
        predict(&request, watch).during(Doing::Log)
    })?;
    let n = found.pose.len();
    let com = PyArray1::from_slice(py, found.com_m.as_flattened()).reshape([n, 3])?;
    let cop = PyArray1::from_slice(py, found.cop_m.as_flattened()).reshape([n, 2])?;
    Ok((PyArray1::from_vec(py, found.pose), com, cop))
}
