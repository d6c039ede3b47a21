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

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::model::json;
use crate::options::{angles, motion, stays, taken, weighed};
use crate::robot::Robot;
use crate::steps;

/// Keywords of a diagnosis, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct DiagnoseOptions {
    support: Option<String>,
    degrees: Option<bool>,
    prior: String,
    noise: Option<f64>,
    floor: f64,
    motion: bool,
    settle: Option<f64>,
    servos: Option<PathBuf>,
}

/// What a diagnosis found, with what is needed to make files of it.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct DiagnosisReport {
    report: diagnose::Report,
    warnings: Vec<String>,
}

/// Find where simulation and measurement disagree, and name what is missing.
#[pyfunction]
#[pyo3(signature = (robot, log, then, healthy, options, show=None))]
pub fn diagnose_log(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    log: PyRef<'_, Log>,
    then: Vec<PyRef<'_, Log>>,
    healthy: Vec<PyRef<'_, Log>>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<DiagnosisReport> {
    let options: DiagnoseOptions = taken(options, Doing::Fit)?;
    let mut request = Request::new(robot.inner.clone(), &log.source);
    request.then = then.iter().map(|log| log.source.clone()).collect();
    request.healthy = healthy.iter().map(|log| log.source.clone()).collect();
    request.support = options.support;
    request.snapping = robot.snapping;
    request.angles = options.degrees.map(angles);
    request.prior = PriorChoice::from(options.prior.as_str());
    request.noise = options.noise;
    request.floor = options.floor;
    request.motion = motion(options.motion);
    request.stays = stays(options.settle).map_err(|failure| failure.raise(py))?;
    request.meshes.clone_from(&robot.folder);
    request.view = true;
    let (report, warnings) = watched(py, show, Stopped::Abandoned, move |watch| {
        if let Some(file) = &options.servos {
            let servos = sesc::servos::read(file, &request.robot);
            request.servos = servos.during(Doing::Code)?;
        }
        diagnose::diagnose(&request, watch).during(Doing::Fit)
    })?;
    Ok(DiagnosisReport { report, warnings })
}

impl DiagnosisReport {
    /// Call `show` with the report, its next steps being those that `keep` keeps.
    fn shown<T>(
        &self,
        keep: impl Fn(&&NextStep) -> bool,
        show: impl FnOnce(&DiagnoseReport<'_>) -> T,
    ) -> T {
        let all = self.report.diagnosis.next_steps();
        show(&DiagnoseReport {
            found: &self.report.diagnosis,
            next_steps: &steps::worded(all.iter().filter(keep), steps::text),
            model_use: None,
        })
    }
}

#[pymethods]
impl DiagnosisReport {
    /// What `sesc diagnose --json` prints.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || self.shown(|_| true, |report| json(report)))
    }

    /// What `sesc diagnose` prints.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || Ok(self.shown(|_| true, |report| text(report, true))))
    }

    /// The page of `sesc diagnose --report`.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || match &self.report.view {
            Some(view) => self
                .shown(
                    |step| !matches!(step, NextStep::LookAtPage),
                    |report| page(report, view, &self.report.model_file, ""),
                )
                .map_err(Failure::internal),
            None => Ok(String::new()),
        })
    }

    /// Warnings about logs, as sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// What is to be known of the robot, as sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.report.notes.clone()
    }

    /// The model file.
    fn model_file(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || self.report.model_file.to_toml().during(Doing::Fit))
    }

    /// The tolerances that masses of the corrected URDF move within, and what belongs to the
    /// log alone, as sentences.
    fn correction(&self) -> (bool, Vec<String>) {
        let about = &self.report;
        (about.frees_masses, about.of_the_log.clone())
    }

    /// Postures of the experiment that would tell most: support, experiment, postures, and the
    /// rank of each, the most telling first.
    #[allow(clippy::type_complexity)]
    fn next<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<
        Option<(
            String,
            Option<&'static str>,
            Bound<'py, PyArray2<f64>>,
            Bound<'py, PyArray1<i64>>,
        )>,
    > {
        let Some(next) = &self.report.next else {
            return Ok(None);
        };
        let dof = next.dofs.len();
        let q = PyArray1::from_slice(py, &next.q).reshape([next.q.len() / dof.max(1), dof])?;
        let ranks = next.ranks.iter().map(|rank| *rank as i64);
        let experiment = Some(next.experiment.name());
        let ranks = PyArray1::from_iter(py, ranks);
        Ok(Some((next.support.clone(), experiment, q, ranks)))
    }
}

/// The URDF of `robot` with the parameters and effects of a model file, and what it leaves out.
#[pyfunction]
#[pyo3(signature = (robot, model_file, prior, total_mass=None))]
pub fn correct_urdf(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model_file: String,
    prior: String,
    total_mass: Option<f64>,
) -> PyResult<(String, Vec<String>)> {
    let (robot, snapping) = (robot.inner.clone(), robot.snapping);
    let corrected = watched(py, None, Stopped::Abandoned, move |_| {
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
    });
    Ok(corrected?.0)
}
