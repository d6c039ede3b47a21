//! All groups of a fleet on the cores of one machine.
//!
//! One group at a time a core: its logs are read, looked up in the store by what they hold,
//! and diagnosed if they are not there. Memory is that of the rows, and of one group's logs a
//! core.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use serde::Serialize;

use super::content::Log;
use super::evaluate::row;
use super::groups::{Group, groups};
use super::manifest::Input;
use super::options::Options;
use super::row::Row;
use super::store::Store;
use super::table::assembled;
use crate::robot::Robot;
use crate::watch::{Progress, Watch, tell};
use crate::{Error, ErrorKind};

/// A fleet and how it is looked at.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot of every log that has no URDF of its own.
    pub robot: Arc<Robot>,
    /// The logs.
    pub inputs: Vec<Input>,
    /// How every group is looked at.
    pub options: Options,
    /// Where rows are kept.
    pub store: Option<Store>,
    /// Threads; as many as there are cores unless given.
    pub threads: Option<usize>,
}

impl Request {
    /// These logs of this robot, by the usual options.
    pub fn new(robot: Arc<Robot>, inputs: Vec<Input>) -> Request {
        Request {
            robot,
            inputs,
            options: Options::default(),
            store: None,
            threads: None,
        }
    }
}

/// A log, or a group, that came to nothing or to less than it should.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[non_exhaustive]
pub struct Failed {
    /// The file.
    pub input: String,
    /// What is wrong with it.
    pub error: String,
}

/// A log that was given before under another name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[non_exhaustive]
pub struct Twice {
    /// The file.
    pub input: String,
    /// The file with the same bytes.
    pub same_as: String,
    /// Whether both are of one robot and day, where they count once.
    pub counted_once: bool,
}

/// Everything that was found, group by group.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Fleet {
    /// A row per robot and day, sorted.
    pub rows: Vec<Row>,
    /// Logs with errors, sorted by name.
    pub failed: Vec<Failed>,
    /// Logs that came more than once, sorted by name.
    pub twice: Vec<Twice>,
    /// Rows that were in the store.
    pub from_store: usize,
    /// Names of the base parameters, by the hash of the URDF and the support.
    pub names: BTreeMap<(String, String), Vec<String>>,
}

/// What a group came to, with what only this machine knows of it.
struct Done {
    row: Row,
    failed: Vec<Failed>,
    /// Hash and path of every log that was read.
    read: Vec<(String, PathBuf)>,
    from_store: bool,
    robot: Option<Arc<Robot>>,
}

/// Look at every group.
///
/// # Errors
/// When the store cannot be written; the kind `Interrupted` where `watch` stops the run. What
/// is wrong with a log is in its row.
pub fn run(request: &Request, watch: &mut dyn Watch) -> Result<Fleet, Error> {
    let groups = groups(&request.inputs);
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let threads = request
        .threads
        .unwrap_or(cores)
        .clamp(1, groups.len().max(1));
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut done: Vec<Done> = Vec::with_capacity(groups.len());
    let total = groups.len() as u64;
    thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, next, stop, groups) = (send.clone(), &next, &stop, &groups);
            scope.spawn(move || {
                let mut stopped = |_: Progress| match stop.load(Ordering::Relaxed) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed))
                    && !stop.load(Ordering::Relaxed)
                    && send.send(one(request, group, &mut stopped)).is_ok()
                {}
            });
        }
        drop(send);
        let all = gather(&receive, &mut done, total, watch);
        stop.store(true, Ordering::Relaxed);
        all
    })?;
    Ok(put_together(done))
}

/// Receive what threads send, and tell how far they are.
fn gather(
    receive: &mpsc::Receiver<Result<Done, Error>>,
    done: &mut Vec<Done>,
    total: u64,
    watch: &mut dyn Watch,
) -> Result<(), Error> {
    tell(watch, "diagnosing", 0, total)?;
    while let Ok(group) = receive.recv() {
        done.push(group?);
        tell(watch, "diagnosing", done.len() as u64, total)?;
    }
    Ok(())
}

/// One group.
fn one(request: &Request, group: &Group, watch: &mut dyn Watch) -> Result<Done, Error> {
    let mut options = request.options.clone();
    options.support = group.support.clone().or(options.support);
    let name = (group.robot.as_str(), group.day.as_str());
    let (mut logs, mut read, mut failed) = (Vec::new(), Vec::new(), Vec::new());
    let mut errors = Vec::new();
    for path in &group.logs {
        match Log::read(path) {
            Ok(log) => {
                read.push((log.hash.clone(), path.clone()));
                logs.push(log);
            }
            Err(error) => {
                let said = with_cause(&error);
                failed.push(Failed {
                    input: path.display().to_string(),
                    error: said.clone(),
                });
                errors.push(said);
            }
        }
    }
    let robot = match &group.urdf {
        None => Ok(Arc::clone(&request.robot)),
        Some(path) => Robot::read(path).map(Arc::new),
    };
    let robot = match robot {
        Ok(robot) => robot,
        Err(error) => {
            let input = group.urdf.as_deref().unwrap_or(Path::new("")).display();
            failed.push(Failed {
                input: input.to_string(),
                error: error.to_string(),
            });
            let row = Row {
                robot: group.robot.clone(),
                day: group.day.clone(),
                inputs: super::content::each_once(&logs)
                    .into_iter()
                    .map(|l| l.hash)
                    .collect(),
                error: Some("its URDF cannot be used".to_string()),
                version: env!("CARGO_PKG_VERSION").to_string(),
                ..Row::default()
            };
            return Ok(Done {
                row,
                failed,
                read,
                from_store: false,
                robot: None,
            });
        }
    };
    let key = request
        .store
        .as_ref()
        .map(|store| (store, Store::key(&robot, &options, name, &logs)));
    let known = key.as_ref().and_then(|(store, key)| store.get(key));
    let from_store = known.is_some();
    let mut found = match known {
        Some(row) => row,
        None => {
            let found = row(&robot, &options, name, &logs, watch)?;
            if let Some((store, key)) = &key {
                store.put(key, &found)?;
            }
            found
        }
    };
    if let Some(error) = &found.error {
        failed.extend(named(error, &read, group));
        errors.insert(0, error.clone());
    }
    found.error = (!errors.is_empty()).then(|| errors.join("; "));
    Ok(Done {
        row: found,
        failed,
        read,
        from_store,
        robot: Some(robot),
    })
}

fn with_cause(error: &Error) -> String {
    match std::error::Error::source(error) {
        Some(cause) if error.kind() == ErrorKind::Read => format!("{error}: {cause}"),
        _ => error.to_string(),
    }
}

/// The error of a row, with the names of files for the hashes of logs.
fn named(error: &str, read: &[(String, PathBuf)], group: &Group) -> Vec<Failed> {
    let called = |hash: &str| format!("log {}", &hash[..12]);
    let faulty = read
        .iter()
        .filter(|(hash, _)| error.contains(&called(hash)));
    let mut faulty: Vec<&(String, PathBuf)> = faulty.collect();
    faulty.dedup_by(|a, b| a.0 == b.0);
    let say = |path: &Path| {
        let mut said = error.to_string();
        for (hash, path) in read {
            said = said.replace(&called(hash), &path.display().to_string());
        }
        Failed {
            input: path.display().to_string(),
            error: said,
        }
    };
    match faulty.is_empty() {
        false => faulty.into_iter().map(|(_, path)| say(path)).collect(),
        true => group.logs.iter().take(1).map(|path| say(path)).collect(),
    }
}

/// A path with its robot and day.
type Place = (String, (String, String));

fn put_together(done: Vec<Done>) -> Fleet {
    let mut fleet = Fleet::default();
    let mut rows = Vec::with_capacity(done.len());
    let mut places: BTreeMap<String, Vec<Place>> = BTreeMap::new();
    for Done {
        row,
        failed,
        read,
        from_store,
        robot,
    } in done
    {
        fleet.failed.extend(failed);
        fleet.from_store += usize::from(from_store);
        for (hash, path) in read {
            let of = (row.robot.clone(), row.day.clone());
            let place = (path.display().to_string(), of);
            places.entry(hash).or_default().push(place);
        }
        let key = (row.urdf_hash.clone(), row.support.clone());
        if let Some(robot) =
            robot.filter(|_| !row.params.is_empty() && !fleet.names.contains_key(&key))
        {
            let model = robot.model(&row.support, sesc_model::Snapping::default(), None);
            let names =
                model.map(|model| model.base.params.iter().map(|p| p.name.clone()).collect());
            fleet.names.insert(key, names.unwrap_or_default());
        }
        rows.push(row);
    }
    for mut same in places.into_values() {
        same.sort();
        let (first, of) = same[0].clone();
        for (input, its) in same.drain(1..) {
            fleet.twice.push(Twice {
                input,
                same_as: first.clone(),
                counted_once: its == of,
            });
        }
    }
    fleet.failed.sort();
    fleet.twice.sort();
    fleet.rows = assembled(rows);
    fleet
}
