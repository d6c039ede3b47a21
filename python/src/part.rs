//! What one log contributes to a fit, as a value.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sesc_identify::fit;

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::options::{FitOptions, taken};
use crate::robot::Robot;

/// Sums of one log or of many, with the robot they are about.
#[pyclass(frozen, subclass, module = "sesc._sesc")]
pub struct Part {
    pub inner: fit::part::Part,
    warnings: Vec<String>,
}

#[pymethods]
impl Part {
    /// What logs contribute, gathered with the keywords of a fit.
    #[staticmethod]
    #[pyo3(signature = (robot, logs, options, show=None))]
    fn gather(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        logs: Vec<PyRef<'_, Log>>,
        options: &Bound<'_, PyAny>,
        show: Option<Py<PyAny>>,
    ) -> PyResult<Part> {
        let options: FitOptions = taken(options, Doing::Fit)?;
        let request = options.request(Some(&robot), &logs, Vec::new());
        let request = request.map_err(|failure| failure.raise(py))?;
        let (inner, warnings) = watched(py, show, Stopped::Abandoned, move |watch| {
            let part = fit::gather(&request, watch).during(Doing::Fit)?;
            match part.unusable() {
                Some(broken) => Err(Failure::plain(Doing::Part, broken.sentence.clone())),
                None => Ok(part),
            }
        })?;
        Ok(Part { inner, warnings })
    }

    #[staticmethod]
    fn parse(py: Python<'_>, data: Vec<u8>) -> PyResult<Part> {
        let inner = detached(py, || {
            fit::part::Part::from_bytes(&data, "part").during(Doing::Part)
        })?;
        Ok(Part {
            inner,
            warnings: Vec::new(),
        })
    }

    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || self.inner.to_bytes().during(Doing::Part))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// This part and another, together.
    fn merged(&self, py: Python<'_>, other: &Part) -> PyResult<Part> {
        let inner = detached(py, || {
            let mut whole = self.inner.clone();
            whole
                .merge(other.inner.clone(), "the other part")
                .during(Doing::Part)?;
            Ok(whole)
        })?;
        let warnings = self.warnings.iter().chain(&other.warnings);
        Ok(Part {
            inner,
            warnings: warnings.cloned().collect(),
        })
    }

    #[getter]
    fn support(&self) -> &str {
        &self.inner.support
    }

    #[getter]
    fn supports(&self) -> Vec<String> {
        self.inner.supports.clone()
    }

    /// Hash of the robot.
    #[getter]
    fn hash(&self) -> &str {
        &self.inner.hash
    }

    #[getter]
    fn postures(&self) -> u64 {
        self.inner.postures()
    }

    /// The robot of its type that the logs are of.
    #[getter]
    fn unit(&self) -> Option<&str> {
        self.inner.unit.as_deref()
    }

    /// The options that shaped the sums, as JSON.
    #[getter]
    fn options(&self) -> PyResult<String> {
        let options = serde_json::to_string(&self.inner.options);
        options.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }

    /// Name, hash and rows of each log.
    #[getter]
    fn logs(&self) -> Vec<(String, String, u64)> {
        let logs = self.inner.logs().iter();
        logs.map(|log| (log.file.clone(), log.hash.clone(), log.rows))
            .collect()
    }

    /// What is wrong with the logs: kind, target, sentence.
    #[getter]
    fn health(&self) -> Vec<(&'static str, String, String)> {
        let all = self.inner.health().iter();
        all.map(|f| (f.kind.name(), f.target.clone(), f.sentence.clone()))
            .collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }
}
