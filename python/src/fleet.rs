//! A fleet: its groups, the work on one of them wherever that is done, and all together.
//!
//! Groups, options and what groups came to travel as JSON.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use sesc::report::fleet as report;
use sesc_identify::fleet::summary::{Summary, summary};
use sesc_identify::fleet::{self, Fleet, Group, Options, Request, Store};
use sesc_identify::robot;

use crate::calls::{Stopped, checked, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::model::{compact, json};
use crate::options::sized;
use crate::robot::Robot;

/// The name of a file, and its text.
type NamedText = (String, String);

fn parsed<T: DeserializeOwned>(json: &str) -> Result<T, Failure> {
    let found = serde_json::from_str(json);
    found.map_err(|error| Failure::plain(Doing::Fit, format!("no such value: {error}")))
}

/// The options of a fleet.
fn read(json: &str) -> Result<Options, Failure> {
    let options: Options = parsed(json)?;
    let noise = options.noise.unwrap_or_default();
    sized("noise", noise, Doing::Fit)?;
    sized("floor", options.floor, Doing::Fit)?;
    Ok(options)
}

/// The groups of patterns, folders, lists and manifests, and of a table of paths with what is
/// said of each.
#[pyfunction]
pub(crate) fn fleet_groups(
    py: Python<'_>,
    data: Vec<String>,
    table: Vec<(PathBuf, BTreeMap<String, String>)>,
    by: Vec<String>,
) -> PyResult<Vec<String>> {
    detached(py, || {
        let mut inputs = fleet::inputs(&data, &by).during(Doing::Log)?;
        for (path, said) in table {
            let input = Group::of_log(path, &said, &by);
            inputs.push(input.during(Doing::Fit)?);
        }
        fleet::groups(&inputs).iter().map(compact).collect()
    })
}

/// What one group comes to; an exception of `check`, which is called every 50 ms, stops it.
#[pyfunction]
#[pyo3(signature = (robot, options, group, store=None, check=None))]
pub(crate) fn fleet_work(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    options: String,
    group: String,
    store: Option<PathBuf>,
    check: Option<Py<PyAny>>,
) -> PyResult<String> {
    let robot = robot.inner.clone();
    checked(py, check, move |watch| {
        let (options, group): (Options, Group) = (read(&options)?, parsed(&group)?);
        let store = store.map(Store::new);
        let done = fleet::work(&robot, &options, &group, store.as_ref(), watch);
        compact(&done.during(Doing::Fit)?)
    })
}

/// The robot of a fleet, and how every group was looked at.
struct Asked {
    robot: Arc<robot::Robot>,
    /// Where its meshes may be.
    folder: Option<PathBuf>,
    options: Options,
}

impl Asked {
    fn of(py: Python<'_>, robot: &Robot, options: &str) -> PyResult<Asked> {
        let options = read(options).map_err(|failure| failure.raise(py))?;
        Ok(Asked {
            robot: robot.inner.clone(),
            folder: robot.folder.clone(),
            options,
        })
    }
}

/// All groups of a fleet, and what they say together.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct FleetFound {
    fleet: Fleet,
    summary: Summary,
    asked: Asked,
}

impl FleetFound {
    fn of(fleet: Fleet, asked: Asked) -> FleetFound {
        let known = || fleet::population(&fleet.rows, &asked.robot, &asked.options).ok();
        // Why there is none is said to those who ask for it.
        let population = asked.options.information.then(known).flatten();
        let summary = summary(&fleet.rows, population);
        FleetFound {
            fleet,
            summary,
            asked,
        }
    }
}

#[pymethods]
impl FleetFound {
    /// Work on all groups with the threads of this machine.
    #[staticmethod]
    #[pyo3(signature = (robot, options, groups, store=None, show=None, threads=None))]
    fn run(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        options: &str,
        groups: Vec<String>,
        store: Option<PathBuf>,
        show: Option<Py<PyAny>>,
        threads: Option<usize>,
    ) -> PyResult<FleetFound> {
        let asked = Asked::of(py, &robot, options)?;
        let groups: Result<Vec<Group>, Failure> = groups.iter().map(|g| parsed(g)).collect();
        let groups = groups.map_err(|failure| failure.raise(py))?;
        let mut request = Request::new(asked.robot.clone(), groups);
        request.options = asked.options.clone();
        request.store = store.map(Store::new);
        request.threads = threads;
        watched(py, show, Stopped::Abandoned, move |watch| {
            let found = fleet::run(&request, watch).during(Doing::Fit)?;
            Ok(FleetFound::of(found, asked))
        })
    }

    /// Put together what groups came to, in any order.
    #[staticmethod]
    fn gathered(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        options: &str,
        done: Vec<String>,
    ) -> PyResult<FleetFound> {
        let asked = Asked::of(py, &robot, options)?;
        detached(py, || {
            let done: Result<Vec<_>, Failure> = done.iter().map(|one| parsed(one)).collect();
            Ok(FleetFound::of(fleet::gathered(done?), asked))
        })
    }

    /// The fleet of what `packed` gave.
    #[staticmethod]
    fn unpacked(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        options: &str,
        packed: &str,
    ) -> PyResult<FleetFound> {
        let asked = Asked::of(py, &robot, options)?;
        detached(py, || Ok(FleetFound::of(parsed(packed)?, asked)))
    }

    /// Everything that was found, for `unpacked`.
    fn packed(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || compact(&self.fleet))
    }

    /// The rows as JSON, a list of lists of values in the order of `FLEET_COLUMNS`.
    fn rows(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            compact(&self.fleet.rows.iter().map(fleet::cells).collect::<Vec<_>>())
        })
    }

    /// What `sesc fleet --json` prints.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || json(&report::answer(&self.fleet, &self.summary)))
    }

    /// What `sesc fleet` prints.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || Ok(report::text(&self.fleet, &self.summary, false)))
    }

    /// Write the table, as Parquet or CSV.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        detached(py, || {
            fleet::write(&path, &self.fleet.rows).during(Doing::Fit)
        })
    }

    /// The page of the fleet for a file of this name, the folder beside it, and names and pages
    /// of robots for that: of so many robots, 2000 unless given, those to look at first before
    /// others.
    #[pyo3(signature = (file, robots=None))]
    fn pages(
        &self,
        py: Python<'_>,
        file: &str,
        robots: Option<usize>,
    ) -> PyResult<(String, String, Vec<NamedText>)> {
        detached(py, || {
            let made = "sesc.fleet.run(…)";
            let (fleet, asked) = (&self.fleet, &self.asked);
            let folder = asked.folder.as_deref();
            let drawn = report::skeleton(fleet, &asked.robot, &asked.options, folder);
            let words = (made, file);
            let robots = robots.unwrap_or(report::ROBOTS);
            let pages = report::pages(fleet, &self.summary, drawn.as_ref(), words, robots)
                .map_err(Failure::internal)?;
            Ok((pages.fleet, pages.folder, pages.robots))
        })
    }

    /// The file of what is known of the next robot.
    fn population(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            match &self.summary.population {
                Some(known) => known.to_toml(),
                None => fleet::population(&self.fleet.rows, &self.asked.robot, &self.asked.options)
                    .and_then(|found| found.to_toml()),
            }
            .during(Doing::Fit)
        })
    }
}
