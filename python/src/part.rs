//! What one log contributes to a fit, as a value.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;
use sesc_identify::fit;

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::log::Log;
use crate::model::compact;
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
        watched(py, show, Stopped::Abandoned, move |watch| {
            let inner = fit::gather(&request, watch).during(Doing::Fit)?;
            if let Some(broken) = inner.unusable() {
                return Err(Failure::plain(Doing::Part, broken.sentence.clone()));
            }
            let warnings = std::mem::take(&mut watch.warnings);
            Ok(Part { inner, warnings })
        })
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

    /// Robot, logs and options, and what is wrong with them, as JSON.
    fn about(&self, py: Python<'_>) -> PyResult<String> {
        let part = &self.inner;
        let about = || {
            compact(&json!({
                "support": part.support,
                "supports": part.supports,
                "robot_hash": part.hash,
                "postures": part.postures(),
                "unit": part.unit,
                "options": part.options,
                "logs": part.logs(),
                "health": part.health(),
                "warnings": self.warnings,
            }))
        };
        detached(py, about)
    }
}
