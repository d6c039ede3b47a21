//! Posture logs: files, bytes and columns of arrays.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::ndarray::{ArrayView1, Axis};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sesc_identify::health;
use sesc_identify::logs::{LogSource, Sidecar, Table, Values};
use sesc_identify::simulate;

use crate::arrow::Unusable;
use crate::calls::{Signals, Stopped, detached, guarded, watched};
use crate::errors::{Doing, During, Failure, keyword};
use crate::model::compact;
use crate::robot::Robot;

/// A posture log that can be read as often as needed.
#[pyclass(frozen, subclass, module = "sesc._sesc")]
pub struct Log {
    pub source: LogSource,
    /// What is odd about its sidecar.
    pub warnings: Vec<String>,
    /// How it was simulated, if it was.
    simulated: Option<simulate::Request>,
}

impl Log {
    /// A log with `settings`, JSON of a sidecar, beside those that it has.
    fn with(source: LogSource, settings: Option<&str>) -> Result<Log, Failure> {
        let (own, warnings) = source.sidecar().during(Doing::Log)?;
        let source = match settings {
            None => source,
            Some(settings) => {
                let source = source.with_sidecar(overlaid(&own, settings)?);
                source.sidecar().during(Doing::Log)?;
                source
            }
        };
        Ok(Log {
            source,
            warnings: warnings.iter().map(|w| w.worded(keyword)).collect(),
            simulated: None,
        })
    }

    /// A log that was simulated.
    pub fn simulated(source: LogSource, request: simulate::Request) -> Log {
        Log {
            source,
            warnings: Vec::new(),
            simulated: Some(request),
        }
    }
}

/// `own` with the keys of `settings`.
fn overlaid(own: &Sidecar, settings: &str) -> Result<Sidecar, Failure> {
    let wrong = |error: serde_json::Error| Failure::plain(Doing::Log, error.to_string());
    let mut merged = serde_json::to_value(own).map_err(wrong)?;
    let given: serde_json::Value = serde_json::from_str(settings).map_err(wrong)?;
    let serde_json::Value::Object(given) = given else {
        return serde_json::from_value(merged).map_err(wrong);
    };
    for (key, value) in given {
        let said = value.to_string();
        if let Some(merged) = merged.as_object_mut() {
            merged.insert(key.clone(), value);
        }
        serde_json::from_value::<Sidecar>(merged.clone())
            .map_err(|error| Failure::plain(Doing::Log, format!("`{key}` {said}: {error}")))?;
    }
    serde_json::from_value(merged).map_err(wrong)
}

/// A column on its way from Python.
#[derive(FromPyObject)]
enum Given<'py> {
    #[pyo3(transparent)]
    Unusable(PyRef<'py, Unusable>),
    #[pyo3(transparent)]
    Numbers(PyReadonlyArray1<'py, f64>),
    #[pyo3(transparent)]
    Integers(PyReadonlyArray1<'py, i64>),
    #[pyo3(transparent)]
    Texts(Vec<String>),
}

/// Values that are copied between looks for signals: milliseconds' worth.
const CHUNK: usize = 1 << 18;

fn copy<T: Copy>(values: ArrayView1<'_, T>, signals: &mut Signals) -> PyResult<Vec<T>> {
    let mut all = Vec::with_capacity(values.len());
    for some in values.axis_chunks_iter(Axis(0), CHUNK) {
        match some.as_slice() {
            Some(some) => all.extend_from_slice(some),
            None => all.extend(some),
        }
        signals.look()?;
    }
    Ok(all)
}

fn copy_texts(values: &[String], signals: &mut Signals) -> PyResult<Vec<Arc<str>>> {
    let mut all = Vec::with_capacity(values.len());
    for some in values.chunks(CHUNK) {
        all.extend(some.iter().map(|text| Arc::from(&**text)));
        signals.look()?;
    }
    Ok(all)
}

#[pymethods]
impl Log {
    /// The log at `path`.
    #[staticmethod]
    #[pyo3(signature = (path, settings=None))]
    fn file(py: Python<'_>, path: PathBuf, settings: Option<&str>) -> PyResult<Log> {
        detached(py, || {
            if let Err(error) = std::fs::metadata(&path) {
                return Err(Failure::unreadable(Doing::Log, &path, &error));
            }
            Log::with(LogSource::from(&path), settings)
        })
    }

    /// The bytes of a log file of any format.
    #[staticmethod]
    #[pyo3(signature = (name, data, settings=None))]
    fn bytes(py: Python<'_>, name: String, data: Vec<u8>, settings: Option<&str>) -> PyResult<Log> {
        detached(py, || Log::with(LogSource::bytes(name, data), settings))
    }

    /// Columns by name; the log keeps copies of its own.
    #[staticmethod]
    #[pyo3(signature = (name, columns, settings=None))]
    fn table(
        py: Python<'_>,
        name: String,
        columns: Vec<(String, Given<'_>)>,
        settings: Option<&str>,
    ) -> PyResult<Log> {
        let table = guarded(py, || {
            let (mut table, mut signals) = (Table::new(name), Signals::new());
            for (name, column) in &columns {
                table = match column {
                    Given::Unusable(column) => table.unusable(name, column.rows, &column.what),
                    Given::Numbers(values) => {
                        let values = values.as_array();
                        table.numbers(name, py.detach(|| copy(values, &mut signals))?)
                    }
                    Given::Integers(values) => {
                        let values = values.as_array();
                        table.integers(name, py.detach(|| copy(values, &mut signals))?)
                    }
                    Given::Texts(values) => {
                        table.texts(name, py.detach(|| copy_texts(values, &mut signals))?)
                    }
                };
            }
            Ok(table)
        })?;
        detached(py, || Log::with(LogSource::from(table), settings))
    }

    #[getter]
    fn name(&self) -> &str {
        self.source.name()
    }

    /// Columns and rows of a table; none of a file.
    #[getter]
    fn size(&self) -> Option<(usize, usize)> {
        let table = self.source.table()?;
        let sizes = table.columns().map(|(_, values)| values.rows());
        Some(sizes.fold((0, 0), |(columns, most), rows| {
            (columns + 1, most.max(rows))
        }))
    }

    #[getter]
    fn sidecar_warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// What its sidecar says, as JSON.
    #[getter]
    fn settings(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let (sidecar, _) = self.source.sidecar().during(Doing::Log)?;
            compact(&sidecar)
        })
    }

    /// The bytes of a file that was given by them.
    fn content<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        self.source.content().map(|bytes| PyBytes::new(py, bytes))
    }

    /// What is wrong with the data themselves: kind, target, sentence.
    fn health(
        &self,
        py: Python<'_>,
        robot: Option<PyRef<'_, Robot>>,
    ) -> PyResult<Vec<(&'static str, String, String)>> {
        let snapping = robot.as_ref().map(|robot| robot.snapping);
        let robot = robot.map(|robot| robot.inner.clone());
        let source = self.source.clone();
        watched(py, None, Stopped::Abandoned, move |watch| {
            let snapping = snapping.unwrap_or_default();
            let found = health::of_log(&source, robot.as_ref(), snapping, watch);
            let found = found.during(Doing::Log)?.into_iter();
            let found = found.map(|own| (own.kind.name(), own.target, own.sentence));
            Ok(found.collect())
        })
    }

    /// The columns of a table, by name; none of a file.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(table) = self.source.table() else {
            return Ok(None);
        };
        let columns = PyDict::new(py);
        for (name, values) in table.columns() {
            match values {
                Values::Numbers(x) => columns.set_item(name, PyArray1::from_slice(py, x))?,
                Values::Integers(x) => columns.set_item(name, PyArray1::from_slice(py, x))?,
                Values::Texts(x) => {
                    columns.set_item(name, x.iter().map(|text| &**text).collect::<Vec<_>>())?;
                }
                Values::Unusable(..) => {}
            }
        }
        Ok(Some(columns))
    }

    /// Write a simulated log with its sidecar, whose path is given back.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<PathBuf> {
        let Some(request) = self.simulated.clone() else {
            let message = "only simulated logs are written; save others by what they came from";
            return Err(Failure::plain(Doing::Log, message).raise(py));
        };
        watched(py, None, Stopped::Awaited, move |watch| {
            simulate::write(&request, &path, watch).during(Doing::Log)
        })
    }
}
