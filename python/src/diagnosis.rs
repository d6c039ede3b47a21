//! Diagnoses: a request in, everything that is said of it and made from it out.

use std::path::PathBuf;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use sesc::report::diagnose::{DiagnoseReport, page, text};
use sesc_identify::NextStep;
use sesc_identify::diagnose::{self, Request, remedy};
use sesc_identify::fit::prior::PriorChoice;
use sesc_model::ModelFile;
use sesc_model::effects::Catalog;

use crate::calls::{Stopped, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::model::json;
use crate::options::{angles, motion, stays, taken, weighed};
use crate::robot::Robot;
use crate::steps;

/// Keywords of a diagnosis, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct DiagnoseOptions {
    support: Option<String>,
    degrees: Option<bool>,
    prior: String,
    noise: Option<f64>,
    offset: Option<f64>,
    floor: f64,
    motion: bool,
    settle: Option<f64>,
    servos: Option<PathBuf>,
    effects: Option<PathBuf>,
}

/// Support, experiment, postures, and the rank of each, the most telling first.
type Next = (String, &'static str, Py<PyArray2<f64>>, Py<PyArray1<i64>>);

/// What a diagnosis found, and all that files are made of.
#[derive(IntoPyObject)]
pub(crate) struct Diagnosed {
    /// What `sesc diagnose --json` prints.
    json: String,
    /// What `sesc diagnose` prints.
    text: String,
    /// The page of `sesc diagnose --report`.
    page: String,
    model_file: String,
    /// Whether masses of the corrected URDF are free, and what belongs to the log alone, as sentences.
    correction: (bool, Vec<String>),
    /// Postures of the experiment that would tell most.
    next: Option<Next>,
    /// Warnings about logs, as sentences.
    warnings: Vec<String>,
    /// What is to be known of the robot, as sentences.
    notes: Vec<String>,
}

/// Find where simulation and measurement disagree, and name what is missing.
#[pyfunction]
#[pyo3(signature = (robot, log, then, healthy, options, show=None))]
pub(crate) fn diagnose_log(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    log: PyRef<'_, Log>,
    then: Vec<PyRef<'_, Log>>,
    healthy: Vec<PyRef<'_, Log>>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<Diagnosed> {
    let options: DiagnoseOptions = taken(options, Doing::Fit)?;
    let mut request = Request::new(robot.inner.clone(), &log.source);
    request.then = then.iter().map(|log| log.source.clone()).collect();
    request.healthy = healthy.iter().map(|log| log.source.clone()).collect();
    request.support = options.support;
    request.snapping = robot.snapping;
    request.angles = options.degrees.map(angles);
    request.prior = PriorChoice::from(options.prior.as_str());
    request.noise = options.noise;
    request.offset = options.offset;
    request.floor = options.floor;
    request.motion = motion(options.motion);
    request.stays = stays(options.settle).map_err(|failure| failure.raise(py))?;
    request.meshes.clone_from(&robot.folder);
    request.view = true;
    let (mut found, next) = watched(py, show, Stopped::Abandoned, move |watch| {
        if let Some(file) = &options.servos {
            let servos = sesc::servos::read(file, &request.robot);
            request.servos = servos.during(Doing::Sesc)?;
        }
        if let Some(file) = &options.effects {
            request.effects = request.effects.with_file(file).during(Doing::Sesc)?;
        }
        let report = diagnose::diagnose(&request, watch).during(Doing::Fit)?;
        let next_steps = report.diagnosis.next_steps();
        let on_page = next_steps.iter();
        let on_page = on_page.filter(|step| **step != NextStep::LookAtPage);
        let on_page = steps::worded(on_page, steps::text);
        let all = steps::worded(&next_steps, steps::text);
        let shown = |next_steps| DiagnoseReport {
            found: &report.diagnosis,
            next_steps,
            model_use: None,
        };
        let view = report.view.as_ref();
        let page = view.map(|view| page(&shown(&on_page), view, &report.model_file, ""));
        let found = Diagnosed {
            json: json(&shown(&all))?,
            text: text(&shown(&all), true),
            page: page
                .transpose()
                .map_err(Failure::internal)?
                .unwrap_or_default(),
            model_file: report.model_file.to_toml().during(Doing::Fit)?,
            correction: (report.frees_masses, report.of_the_log),
            next: None,
            warnings: std::mem::take(&mut watch.warnings),
            notes: report.notes,
        };
        Ok((found, report.next))
    })?;
    if let Some(next) = next {
        let dof = next.dofs.len();
        let shape = [next.q.len() / dof.max(1), dof];
        let q = PyArray1::from_vec(py, next.q).reshape(shape)?.unbind();
        let ranks = next.ranks.iter().map(|rank| *rank as i64);
        let ranks = PyArray1::from_iter(py, ranks).unbind();
        found.next = Some((next.support, next.experiment.name(), q, ranks));
    }
    Ok(found)
}

/// The URDF of `robot` with the parameters and effects of a model file, and what it leaves out.
#[pyfunction]
#[pyo3(signature = (robot, model_file, prior, total_mass=None))]
pub(crate) fn correct_urdf(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model_file: String,
    prior: String,
    total_mass: Option<f64>,
) -> PyResult<(String, Vec<String>)> {
    let (robot, snapping) = (robot.inner.clone(), robot.snapping);
    watched(py, None, Stopped::Abandoned, move |_| {
        weighed(total_mass, &robot)?;
        let file = ModelFile::parse(&model_file, "model").during(Doing::ModelFile)?;
        let model = robot
            .model(&file.support, snapping, None)
            .during(Doing::Fit)?;
        let prior = PriorChoice::from(prior.as_str())
            .of(&model)
            .during(Doing::Fit)?;
        let corrected = remedy::of_model_file(
            &file,
            &robot,
            &model,
            &Catalog::standard(),
            snapping,
            &prior,
            total_mass,
        )
        .during(Doing::Fit)?;
        Ok((corrected.text, corrected.left_out))
    })
}
