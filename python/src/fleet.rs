//! A fleet: its groups, the work on one of them wherever that is done, and all together.
//!
//! Groups, options and what groups came to travel as JSON.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sesc_identify::fleet::summary::{Summary, summary};
use sesc_identify::fleet::{self, Fleet, Gathering, Group, Input, Options, Request, Store};

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, Failure};
use crate::robot::Robot;

fn parsed<T: DeserializeOwned>(json: &str) -> Result<T, Failure> {
    let found = serde_json::from_str(json);
    found.map_err(|error| Failure::plain(Doing::Fit, format!("no such value: {error}")))
}

fn text(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(|error| Failure::internal(error.to_string()))
}

/// The groups of patterns, folders, lists and manifests, and of a table of paths with what is
/// said of each.
#[pyfunction]
pub fn fleet_groups(
    py: Python<'_>,
    data: Vec<String>,
    table: Vec<(PathBuf, BTreeMap<String, String>)>,
    by: Vec<String>,
) -> PyResult<Vec<String>> {
    detached(py, || {
        let found = fleet::inputs(&data, &by);
        let mut inputs = found.map_err(|error| Failure::of(&error, Doing::Log))?;
        let rows = table.into_iter();
        inputs.extend(rows.map(|(path, said)| Input::new(path, &said, &by)));
        fleet::groups(&inputs).iter().map(text).collect()
    })
}

/// What one group comes to.
#[pyfunction]
#[pyo3(signature = (robot, options, group, store=None))]
pub fn fleet_work(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    options: &str,
    group: &str,
    store: Option<PathBuf>,
) -> PyResult<String> {
    let robot = robot.inner.clone();
    detached(py, || {
        let (options, group): (Options, Group) = (parsed(options)?, parsed(group)?);
        let store = store.map(Store::new);
        let done = fleet::work((&robot, &options, store.as_ref()), &group, &mut ());
        text(&done.map_err(|error| Failure::of(&error, Doing::Fit))?)
    })
}

/// All groups of a fleet, and what they say together.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct FleetFound {
    fleet: Fleet,
    summary: Summary,
}

impl FleetFound {
    fn of(fleet: Fleet) -> FleetFound {
        let summary = summary(&fleet.rows, &fleet.names);
        FleetFound { fleet, summary }
    }
}

#[pymethods]
impl FleetFound {
    /// Work on all groups with the threads of this machine.
    #[staticmethod]
    #[pyo3(signature = (robot, options, groups, store=None, show=None))]
    fn run(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        options: &str,
        groups: Vec<String>,
        store: Option<PathBuf>,
        show: Option<Py<PyAny>>,
    ) -> PyResult<FleetFound> {
        let request = || -> Result<Request, Failure> {
            let groups: Result<Vec<Group>, Failure> = groups.iter().map(|g| parsed(g)).collect();
            let mut request = Request::new(robot.inner.clone(), groups?);
            request.options = parsed(options)?;
            request.store = store.map(Store::new);
            Ok(request)
        };
        let request = request().map_err(|failure| failure.raise(py))?;
        let (found, _) = watched(py, show, Stopped::Awaited, move |watch| {
            fleet::run(&request, watch).map_err(|error| Failure::of(&error, Doing::Fit))
        })?;
        Ok(FleetFound::of(found))
    }

    /// Put together what groups came to, in any order.
    #[staticmethod]
    fn gathered(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        done: Vec<String>,
    ) -> PyResult<FleetFound> {
        let robot = robot.inner.clone();
        detached(py, || {
            let mut gathering = Gathering::default();
            for group in &done {
                gathering.add(parsed(group)?);
            }
            Ok(FleetFound::of(gathering.finish(&robot)))
        })
    }

    /// The rows as JSON, a list of objects.
    fn rows(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || text(&self.fleet.rows))
    }

    /// What is said besides the rows, as JSON.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            text(&sesc::report::fleet::answer(&self.fleet, &self.summary))
        })
    }

    /// Write the table, as Parquet or CSV.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        detached(py, || {
            let written = fleet::write(&path, &self.fleet.rows);
            written.map_err(|error| Failure::of(&error, Doing::Fit))
        })
    }

    /// The page.
    fn page(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let page = sesc::report::fleet::page(&self.fleet, &self.summary, "sesc.fleet.run(…)");
            page.map_err(|error| Failure::internal(error.to_string()))
        })
    }
}
