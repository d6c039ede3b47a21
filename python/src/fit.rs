//! Fits: a request in, everything that is said of it and made from it out.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use sesc::report::fit::{FitReport as Printed, Shown, page, text};
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

/// What a fit found, and all that files are made of but what takes long.
#[derive(IntoPyObject)]
pub(crate) struct Fitted<'py> {
    /// What `sesc fit --json` prints.
    json: String,
    /// What `sesc fit` prints.
    text: String,
    params: Bound<'py, PyArray1<f64>>,
    /// Row by row.
    covariance: Bound<'py, PyArray2<f64>>,
    model_file: String,
    /// Warnings about logs, as sentences.
    warnings: Vec<String>,
    /// What is to be known of the robot, as sentences.
    notes: Vec<String>,
}

/// Identify the parameters of a robot from logs and parts of logs.
#[pyfunction]
#[pyo3(signature = (robot, logs, parts, options, show=None))]
pub(crate) fn fit_logs(
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
    watched(py, show, Stopped::Abandoned, move |watch| {
        let report = fit::fit(&request, watch).during(Doing::Fit)?;
        let found = &report.identification;
        let mut warnings = std::mem::take(&mut watch.warnings);
        warnings.extend_from_slice(&found.warnings[found.warnings_of_logs..]);
        let inner = Arc::new((request, report));
        Ok(FitReport { inner, warnings })
    })
}

#[pymethods]
impl FitReport {
    /// What is wrong with data that cannot be used, as sentences.
    #[getter]
    fn unusable(&self) -> Option<String> {
        let found = &self.inner.1.identification;
        let said: Vec<&str> = found.health.iter().map(|own| &*own.sentence).collect();
        (!found.is_usable()).then(|| said.join("; "))
    }

    /// Text and file of the robot's URDF, and whether right angles were made exact.
    #[getter]
    fn robot(&self) -> (String, String, bool) {
        let robot = &self.inner.1.robot;
        let snapped = self.inner.1.snapping != Snapping::Off;
        (
            robot.text().to_string(),
            robot.description.file.clone(),
            snapped,
        )
    }

    /// All that Python keeps of data that can be used.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Fitted<'py>> {
        let report = &self.inner.1;
        let found = &report.identification;
        let (json, text, model_file) = detached(py, || {
            let next_steps = &steps::worded(&found.next_steps(), steps::text);
            let printed = json(&Printed {
                found,
                next_steps,
                corrected: None,
                shown: None,
            });
            let model_file = report.model_file.to_toml().during(Doing::Fit);
            Ok((printed?, text(found, next_steps, true), model_file?))
        })?;
        let values = found.parameters.iter().map(|parameter| parameter.value);
        let rows = found.estimate.covariance.row_iter();
        let rows: Vec<Vec<f64>> = rows.map(|row| row.iter().copied().collect()).collect();
        Ok(Fitted {
            json,
            text,
            params: PyArray1::from_iter(py, values),
            covariance: PyArray2::from_vec2(py, &rows)?,
            model_file,
            warnings: self.warnings.clone(),
            notes: report.notes.clone(),
        })
    }

    /// The corrected URDF.
    #[pyo3(signature = (total_mass=None))]
    fn corrected(&self, py: Python<'_>, total_mass: Option<f64>) -> PyResult<String> {
        let inner = Arc::clone(&self.inner);
        watched(py, None, Stopped::Abandoned, move |_| {
            weighed(total_mass, &inner.1.robot)?;
            let corrected = inner.1.corrected_urdf(total_mass).during(Doing::Fit)?;
            Ok(corrected.text)
        })
    }

    /// Masses and first moments of the corrected URDF, as parts of the whole; none where no masses
    /// give the parameters.
    fn masses(&self, py: Python<'_>) -> PyResult<Option<Vec<f64>>> {
        detached(py, || Ok(self.inner.1.masses()))
    }

    /// The page of `sesc fit --report`.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        let inner = Arc::clone(&self.inner);
        watched(py, None, Stopped::Abandoned, move |watch| {
            let (request, report) = &*inner;
            let sample = fit::residuals(request, report, watch).during(Doing::Fit)?;
            let found = &report.identification;
            let shown = Shown::of(report, sample, "sesc.fit(…)".to_string(), None);
            page(&Printed {
                found,
                next_steps: &steps::worded(&found.next_steps(), steps::text),
                corrected: None,
                shown: Some(&shown),
            })
            .map_err(Failure::internal)
        })
    }
}

/// The corrected URDF of a fit that travelled: of its parameters and [`FitReport::masses`].
#[pyfunction]
#[pyo3(signature = (robot, support, params, masses, prior, total_mass=None))]
pub(crate) fn correct_fit(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    support: String,
    params: Vec<f64>,
    masses: Option<Vec<f64>>,
    prior: String,
    total_mass: Option<f64>,
) -> PyResult<String> {
    let (robot, snapping) = (robot.inner.clone(), robot.snapping);
    watched(py, None, Stopped::Abandoned, move |_| {
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
    })
}
