//! A fleet: its groups, the work on one of them wherever that is done, and all together.
//!
//! Groups, options and what groups came to travel as JSON.

use std::collections::BTreeMap;
use std::io;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::exceptions::PyFileNotFoundError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sesc::report::fleet as report;
use sesc_identify::Error;
use sesc_identify::fleet::summary::{Summary, summary};
use sesc_identify::fleet::{
    self, Disk, Failed, Fleet, Gathering, Group, Input, Job, Local, Options, Request, Row, Stamp,
    Store, Twice,
};
use sesc_identify::robot;

use crate::calls::{Stop, Stopped, detached, watched, watched_until};
use crate::errors::{Doing, Failure};
use crate::model::json;
use crate::robot::Robot;

/// The name of a file, and its text.
type NamedText = (String, String);

fn parsed<T: DeserializeOwned>(json: &str) -> Result<T, Failure> {
    let found = serde_json::from_str(json);
    found.map_err(|error| Failure::plain(Doing::Fit, format!("no such value: {error}")))
}

fn text(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(|error| Failure::internal(error.to_string()))
}

/// The groups of patterns, folders, lists and manifests, and of a table of paths with what is
/// said of each; `window` puts so many days together.
#[pyfunction]
#[pyo3(signature = (data, table, by, window=None))]
pub fn fleet_groups(
    py: Python<'_>,
    data: Vec<String>,
    table: Vec<(PathBuf, BTreeMap<String, String>)>,
    by: Vec<String>,
    window: Option<NonZeroU32>,
) -> PyResult<Vec<String>> {
    detached(py, || {
        let found = fleet::inputs(&data, &by);
        let mut inputs = found.map_err(|error| Failure::of(&error, Doing::Log))?;
        let rows = table.into_iter();
        inputs.extend(rows.map(|(path, said)| Input::new(path, &said, &by)));
        if let Some(days) = window {
            let found = fleet::windows(inputs, days);
            inputs = found.map_err(|error| Failure::of(&error, Doing::Fit))?;
        }
        fleet::groups(&inputs).iter().map(text).collect()
    })
}

/// Files that Python reads and writes: an object with `stamp`, `read` and `write`.
#[derive(Debug)]
struct PythonDisk(Py<PyAny>);

impl PythonDisk {
    fn call<T>(&self, of: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>) -> io::Result<T> {
        Python::attach(|py| {
            of(self.0.bind(py)).map_err(|error| {
                let kind = match error.is_instance_of::<PyFileNotFoundError>(py) {
                    true => io::ErrorKind::NotFound,
                    false => io::ErrorKind::Other,
                };
                io::Error::new(kind, error.value(py).to_string())
            })
        })
    }
}

/// Addresses are Python's, everything else is this machine's.
impl Disk for PythonDisk {
    fn stamp(&self, log: &Path) -> Option<Stamp> {
        if is_here(log) {
            return Local.stamp(log);
        }
        let found = self.call(|disk| disk.call_method1("stamp", (text_of(log),))?.extract());
        let (size, tag): (u64, String) = found.ok().flatten()?;
        Some(Stamp {
            size,
            changed: None,
            tag,
        })
    }

    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        if is_here(path) {
            return Local.read(path, most);
        }
        let bytes: Vec<u8> =
            self.call(|disk| disk.call_method1("read", (text_of(path),))?.extract())?;
        match bytes.len() as u64 > most {
            true => Err(io::Error::other(format!(
                "it has more than {most} bytes, more than such a file can need"
            ))),
            false => Ok(bytes),
        }
    }

    fn write(&self, entries: &[(PathBuf, Vec<u8>)]) -> Result<(), Error> {
        if entries.iter().all(|(path, _)| is_here(path)) {
            return Local.write(entries);
        }
        for (path, bytes) in entries {
            let path = text_of(path);
            self.call(|disk| {
                let bytes = PyBytes::new(disk.py(), bytes);
                disk.call_method1("write", (&path, bytes)).map(drop)
            })
            .map_err(|error| Error::request(format!("cannot write {path}: {error}")))?;
        }
        Ok(())
    }
}

/// Files of this machine are read and written without Python.
fn is_here(path: &Path) -> bool {
    !fleet::is_address(&path.to_string_lossy())
}

fn text_of(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

fn disk_of(disk: Option<Py<PyAny>>) -> Box<dyn Disk> {
    match disk {
        None => Box::new(Local),
        Some(disk) => Box::new(PythonDisk(disk)),
    }
}

/// What one group comes to, unless `stop` is set meanwhile.
#[pyfunction]
#[pyo3(signature = (robot, options, group, store=None, disk=None, stop=None))]
pub fn fleet_work(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    options: String,
    group: String,
    store: Option<PathBuf>,
    disk: Option<Py<PyAny>>,
    stop: Option<PyRef<'_, Stop>>,
) -> PyResult<String> {
    let robot = robot.inner.clone();
    let disk = disk_of(disk);
    let stop = stop.map(|stop| stop.flag()).unwrap_or_default();
    let (done, _) = watched_until(py, None, Stopped::Abandoned, &stop, move |watch| {
        let (options, group): (Options, Group) = (parsed(&options)?, parsed(&group)?);
        let store = store.map(Store::new);
        let job = Job {
            robot: &robot,
            options: &options,
            store: store.as_ref(),
            disk: &*disk,
        };
        let done = fleet::work(job, &group, watch);
        text(&done.map_err(|error| Failure::of(&error, Doing::Fit))?)
    })?;
    Ok(done)
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
        let options = parsed(options).map_err(|failure| failure.raise(py))?;
        Ok(Asked {
            robot: robot.inner.clone(),
            folder: robot.folder.clone(),
            options,
        })
    }
}

/// A fleet on its way to another process; names are those of the base parameters, by the hash
/// of the URDF and the support.
#[derive(Serialize, Deserialize)]
struct Packed {
    rows: Vec<Row>,
    failed: Vec<Failed>,
    twice: Vec<Twice>,
    from_store: usize,
    opened: usize,
    names: Vec<((String, String), Vec<String>)>,
}

/// All groups of a fleet, and what they say together.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct FleetFound {
    fleet: Fleet,
    summary: Summary,
    robot: Arc<robot::Robot>,
    /// Where its meshes may be.
    folder: Option<PathBuf>,
    options: Options,
}

impl FleetFound {
    fn of(fleet: Fleet, asked: Asked) -> FleetFound {
        let Asked {
            robot,
            folder,
            options,
        } = asked;
        let known = || fleet::population(&fleet.rows, &robot, &options).ok();
        // Why there is none is said to those who ask for it.
        let population = options.information.then(known).flatten();
        let summary = summary(&fleet.rows, &fleet.names, population);
        FleetFound {
            fleet,
            summary,
            robot,
            folder,
            options,
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
        let request = || -> Result<Request, Failure> {
            let groups: Result<Vec<Group>, Failure> = groups.iter().map(|g| parsed(g)).collect();
            let mut request = Request::new(asked.robot.clone(), groups?);
            request.options = asked.options.clone();
            request.store = store.map(Store::new);
            request.threads = threads;
            Ok(request)
        };
        let request = request().map_err(|failure| failure.raise(py))?;
        let (found, _) = watched(py, show, Stopped::Abandoned, move |watch| {
            let found = fleet::run(&request, watch);
            let found = found.map_err(|error| Failure::of(&error, Doing::Fit))?;
            Ok(FleetFound::of(found, asked))
        })?;
        Ok(found)
    }

    /// Put together what groups came to, in any order.
    #[staticmethod]
    #[pyo3(signature = (robot, options, done, disk=None))]
    fn gathered(
        py: Python<'_>,
        robot: PyRef<'_, Robot>,
        options: &str,
        done: Vec<String>,
        disk: Option<Py<PyAny>>,
    ) -> PyResult<FleetFound> {
        let asked = Asked::of(py, &robot, options)?;
        let disk = disk_of(disk);
        detached(py, || {
            let mut gathering = Gathering::default();
            for group in &done {
                gathering.add(parsed(group)?);
            }
            let fleet = gathering.finish(&asked.robot, &*disk);
            Ok(FleetFound::of(fleet, asked))
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
        detached(py, || {
            let packed: Packed = parsed(packed)?;
            let mut fleet = Fleet::default();
            fleet.rows = packed.rows;
            fleet.failed = packed.failed;
            fleet.twice = packed.twice;
            fleet.from_store = packed.from_store;
            fleet.opened = packed.opened;
            fleet.names = packed.names.into_iter().collect();
            Ok(FleetFound::of(fleet, asked))
        })
    }

    /// Everything that was found, for `unpacked`.
    fn packed(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let fleet = &self.fleet;
            let names = fleet.names.iter();
            text(&Packed {
                rows: fleet.rows.clone(),
                failed: fleet.failed.clone(),
                twice: fleet.twice.clone(),
                from_store: fleet.from_store,
                opened: fleet.opened,
                names: names
                    .map(|(key, names)| (key.clone(), names.clone()))
                    .collect(),
            })
        })
    }

    /// The rows as JSON, a list of objects with the columns of the table.
    fn rows(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let of_table = |row: &Row| {
                let mut row = row.clone();
                row.covariance = Vec::new();
                row
            };
            text(&self.fleet.rows.iter().map(of_table).collect::<Vec<Row>>())
        })
    }

    /// What `sesc fleet --json` prints.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || json(&report::answer(&self.fleet, &self.summary)))
    }

    /// Write the table, as Parquet or CSV.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        detached(py, || {
            let written = fleet::write(&path, &self.fleet.rows);
            written.map_err(|error| Failure::of(&error, Doing::Fit))
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
            let (fleet, folder) = (&self.fleet, self.folder.as_deref());
            let drawn = report::skeleton(fleet, &self.robot, &self.options, folder);
            let words = (made, file);
            let robots = robots.unwrap_or(report::ROBOTS);
            let pages = report::pages(fleet, &self.summary, drawn.as_ref(), words, robots);
            let pages = pages.map_err(|error| Failure::internal(error.to_string()))?;
            Ok((pages.fleet, pages.folder, pages.robots))
        })
    }

    /// The file of what is known of the next robot.
    fn population(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let text = match &self.summary.population {
                Some(known) => known.to_toml(),
                None => fleet::population(&self.fleet.rows, &self.robot, &self.options)
                    .and_then(|found| found.to_toml()),
            };
            text.map_err(|error| Failure::of(&error, Doing::Fit))
        })
    }
}
