//! Fits: a request in, everything that is said of it and made from it out.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use sesc::report::fit::{FitReport as Printed, Shown, Unusable, corrections, page, text};
use sesc::report::next_steps::Worded;
use sesc_identify::fit::corrected::correct;
use sesc_identify::fit::prior::{Prior, PriorChoice};
use sesc_identify::fit::{self, Masses, Request};
use sesc_model::Snapping;

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::model::json;
use crate::options::{FitOptions, taken, weighed};
use crate::part::Part;
use crate::robot::Robot;
use crate::steps;

/// What a fit found, with what is needed to make files of it.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct FitReport {
    inner: Arc<(Request, fit::Report)>,
    warnings: Vec<String>,
}

impl FitReport {
    fn report(&self) -> &fit::Report {
        &self.inner.1
    }

    fn next_steps(&self) -> Vec<Worded> {
        steps::worded(&self.report().identification.next_steps(), steps::text)
    }
}

/// Identify the parameters of a robot from logs and parts of logs.
#[pyfunction]
#[pyo3(signature = (robot, logs, parts, options, show=None))]
pub fn fit_logs(
    py: Python<'_>,
    robot: Option<PyRef<'_, Robot>>,
    logs: Vec<PyRef<'_, Log>>,
    parts: Vec<PyRef<'_, Part>>,
    options: &Bound<'_, PyAny>,
    show: Option<Py<PyAny>>,
) -> PyResult<FitReport> {
    let options: FitOptions = taken(options, Doing::Fit)?;
    let parts = parts.iter().map(|part| part.inner.clone());
    let request = options.request(robot.as_deref(), &logs, parts.collect());
    let request = request.map_err(|failure| failure.raise(py))?;
    let (inner, mut warnings) = watched(py, show, Stopped::Abandoned, move |watch| {
        let report = fit::fit(&request, watch).during(Doing::Fit)?;
        Ok(Arc::new((request, report)))
    })?;
    let found = &inner.1.identification;
    warnings.extend_from_slice(&found.warnings[found.warnings_of_logs..]);
    Ok(FitReport { inner, warnings })
}

#[pymethods]
impl FitReport {
    /// Whether the data can be used.
    #[getter]
    fn usable(&self) -> bool {
        self.report().identification.is_usable()
    }

    /// What `sesc fit --json` prints.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        let found = &self.report().identification;
        detached(py, || match found.is_usable() {
            false => json(&Unusable::new(&found.health, &self.next_steps())),
            true => json(&Printed {
                found,
                next_steps: &self.next_steps(),
                corrected: None,
                shown: None,
            }),
        })
    }

    /// What `sesc fit` prints.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            Ok(text(
                &self.report().identification,
                &self.next_steps(),
                true,
            ))
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
        self.report().notes.clone()
    }

    fn params<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values = self.report().identification.parameters.iter();
        PyArray1::from_iter(py, values.map(|parameter| parameter.value))
    }

    /// Text and file of the robot's URDF, and whether right angles were made exact.
    #[getter]
    fn robot(&self) -> (String, String, bool) {
        let robot = &self.report().robot;
        let snapped = self.report().snapping != Snapping::Off;
        (
            robot.text().to_string(),
            robot.description.file.clone(),
            snapped,
        )
    }

    /// Covariance of the parameters, row by row.
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let all = &self.report().identification.estimate.covariance;
        let row = |k: usize| all.row(k).iter().copied().collect();
        let rows: Vec<Vec<f64>> = (0..all.nrows()).map(row).collect();
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// The model file.
    fn model_file(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || self.report().model_file.to_toml().during(Doing::Fit))
    }

    /// The corrected URDF, what changed in it as JSON, and the same as a table.
    #[pyo3(signature = (total_mass=None))]
    fn corrected(
        &self,
        py: Python<'_>,
        total_mass: Option<f64>,
    ) -> PyResult<(String, String, String)> {
        let inner = Arc::clone(&self.inner);
        let corrected = watched(py, None, Stopped::Abandoned, move |_| {
            weighed(total_mass, &inner.1.robot)?;
            let corrected = inner.1.corrected_urdf(total_mass).during(Doing::Fit)?;
            Ok((
                corrected.text.clone(),
                json(&corrected)?,
                corrections(&corrected, true),
            ))
        });
        Ok(corrected?.0)
    }

    /// Masses and first moments of the corrected URDF, as parts of the whole; none where no masses
    /// give the parameters.
    fn masses(&self, py: Python<'_>) -> PyResult<Option<Vec<f64>>> {
        detached(py, || Ok(self.report().masses()))
    }

    /// The page of `sesc fit --report`; `command` makes it again.
    #[pyo3(signature = (command, show=None))]
    fn page(&self, py: Python<'_>, command: String, show: Option<Py<PyAny>>) -> PyResult<String> {
        let inner = Arc::clone(&self.inner);
        let page = watched(py, show, Stopped::Abandoned, move |watch| {
            let (request, report) = &*inner;
            let sample = fit::residuals(request, report, watch).during(Doing::Fit)?;
            let found = &report.identification;
            let shown = Shown::of(report, sample, command, None);
            page(&Printed {
                found,
                next_steps: &steps::worded(&found.next_steps(), steps::text),
                corrected: None,
                shown: Some(&shown),
            })
            .map_err(Failure::internal)
        });
        Ok(page?.0)
    }
}

/// The corrected URDF of a fit that travelled: of its parameters and [`FitReport::masses`].
#[pyfunction]
#[pyo3(signature = (robot, support, params, masses, prior, total_mass=None))]
pub fn correct_fit(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    support: String,
    params: Vec<f64>,
    masses: Option<Vec<f64>>,
    prior: String,
    total_mass: Option<f64>,
) -> PyResult<String> {
    let (robot, snapping) = (robot.inner.clone(), robot.snapping);
    let corrected = watched(py, None, Stopped::Abandoned, move |_| {
        weighed(total_mass, &robot)?;
        let model = robot.model(&support, snapping, None).during(Doing::Fit)?;
        // Where masses are known, a file of tolerances may be gone.
        let prior = match masses {
            Some(_) => Prior::Free,
            None => PriorChoice::from(prior.as_str())
                .of(&model)
                .during(Doing::Fit)?,
        };
        let masses = masses.map(Masses::from);
        let target = (&params[..], masses.as_ref());
        let corrected = correct(&robot, &model, snapping, target, &prior, total_mass);
        Ok(corrected.during(Doing::Fit)?.text)
    });
    Ok(corrected?.0)
}
