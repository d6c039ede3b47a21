//! The work on one group, wherever it is done: its logs are read unless the store knows them,
//! looked up there by what they hold, and diagnosed if they are not there.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::content::{Content, Log, each_once};
use super::disk::Disk;
use super::evaluate::row;
use super::groups::Group;
use super::known_logs::{Held, Seen};
use super::options::Options;
use super::row::Row;
use super::store::Store;
use crate::robot::Robot;
use crate::watch::{Watch, tell};
use crate::{Error, ErrorKind};

/// The error of logs that made the library panic; such a row is not kept.
const DEFECT: &str = "these logs meet a defect of sesc; please report it";

/// A log, or a group, that came to nothing or to less than it should.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Failed {
    /// The file.
    pub input: String,
    /// What is wrong with it.
    pub error: String,
}

/// What a group came to: its row, and what is known of its files where it was worked on.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Done {
    /// The row.
    pub row: Row,
    /// Logs with errors.
    pub failed: Vec<Failed>,
    /// Hash and path of every log.
    pub read: Vec<(String, PathBuf)>,
    /// Logs that were opened; the others are as the store knows them.
    pub opened: usize,
    /// Whether the row was in the store.
    pub from_store: bool,
    /// The URDF, where it is not the fleet's.
    pub urdf: Option<PathBuf>,
}

/// What all groups of a fleet have in common.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// The robot of groups that have no URDF of their own.
    pub robot: &'a Arc<Robot>,
    /// How every group is looked at.
    pub options: &'a Options,
    /// Where rows are kept.
    pub store: Option<&'a Store>,
    /// Where logs are, and the store.
    pub disk: &'a dyn Disk,
}

/// Work on one group.
///
/// # Errors
/// When the store cannot be written; the kind `Interrupted` where `watch` stops the call. What
/// is wrong with a log is in the row.
pub fn work(job: Job, group: &Group, watch: &mut dyn Watch) -> Result<Done, Error> {
    let Job { store, disk, .. } = job;
    let mut options = job.options.clone();
    options.support = group.support.clone().or(options.support);
    let name = (group.robot.as_str(), group.day.as_str());
    let before = store
        .map(|store| store.seen(disk, group))
        .unwrap_or_default();
    let mut logs = Logs::of(disk, group, &before);
    let robot = match &group.urdf {
        None => Ok(Arc::clone(job.robot)),
        Some(path) => disk.robot(path).map(Arc::new),
    };
    let robot = match robot {
        Ok(robot) => robot,
        Err(error) => {
            let input = group.urdf.as_deref().unwrap_or(Path::new("")).display();
            logs.failed.push(Failed {
                input: input.to_string(),
                error: error.to_string(),
            });
            let row = Row {
                robot: group.robot.clone(),
                day: group.day.clone(),
                inputs: logs.hashes(),
                error: Some("its URDF cannot be used".to_string()),
                version: env!("CARGO_PKG_VERSION").to_string(),
                ..Row::default()
            };
            return Ok(Done {
                row,
                opened: logs.opened(),
                failed: logs.failed,
                read: logs.read,
                from_store: false,
                urdf: None,
            });
        }
    };
    let key_of = |logs: &Logs| Store::key(&robot, &options, name, &logs.contents());
    let mut key = store.map(|store| (store, key_of(&logs)));
    let mut known = key.as_ref().and_then(|(store, key)| store.get(disk, key));
    if known.is_none() && logs.opened() < logs.held.len() {
        logs = Logs::of(disk, group, &Seen::default());
        key = store.map(|store| (store, key_of(&logs)));
        known = key.as_ref().and_then(|(store, key)| store.get(disk, key));
    }
    let from_store = known.is_some();
    let mut found = match known {
        Some(row) => {
            if let Some((store, _)) = key.filter(|_| logs.seen != before) {
                store.put_seen(disk, group, &logs.seen)?;
            }
            row
        }
        None => {
            let found = made(&robot, &options, name, &logs.in_memory(), watch)?;
            // Who stopped the run may be gone: nothing is written any more.
            tell(watch, "diagnosing", 1, 1)?;
            let sound = found.error.as_deref() != Some(DEFECT);
            if let Some((store, key)) = key.filter(|_| sound) {
                store.put(disk, (&key, &found), group, &logs.seen)?;
            }
            found
        }
    };
    let opened = logs.opened();
    if let Some(error) = &found.error {
        logs.failed.extend(named(error, &logs.read, group));
        logs.errors.insert(0, error.clone());
    }
    found.error = (!logs.errors.is_empty()).then(|| logs.errors.join("; "));
    Ok(Done {
        row: found,
        failed: logs.failed,
        read: logs.read,
        opened,
        from_store,
        urdf: group.urdf.clone(),
    })
}

/// The logs of a group as far as they had to be read.
#[derive(Default)]
struct Logs {
    held: Vec<Held>,
    read: Vec<(String, PathBuf)>,
    failed: Vec<Failed>,
    errors: Vec<String>,
    /// What they are known by the next time.
    seen: Seen,
}

impl Logs {
    fn of(disk: &dyn Disk, group: &Group, before: &Seen) -> Logs {
        let mut logs = Logs::default();
        for path in &group.logs {
            match before.held(disk, path, &mut logs.seen) {
                Ok(held) => {
                    logs.read.push((held.content.hash.clone(), path.clone()));
                    logs.held.push(held);
                }
                Err(error) => {
                    let said = with_cause(&error);
                    logs.failed.push(Failed {
                        input: path.display().to_string(),
                        error: said.clone(),
                    });
                    logs.errors.push(said);
                }
            }
        }
        logs
    }

    fn contents(&self) -> Vec<Content> {
        self.held.iter().map(|held| held.content.clone()).collect()
    }

    fn hashes(&self) -> Vec<String> {
        let once = each_once(&self.contents());
        once.into_iter().map(|content| content.hash).collect()
    }

    fn in_memory(&self) -> Vec<Log> {
        self.held
            .iter()
            .filter_map(|held| held.log.clone())
            .collect()
    }

    /// Logs that were opened.
    fn opened(&self) -> usize {
        self.held.iter().filter(|held| held.log.is_some()).count()
    }
}

/// The row of a group; a panic is an error in it.
fn made(
    robot: &Arc<Robot>,
    options: &Options,
    name: (&str, &str),
    logs: &[Log],
    watch: &mut dyn Watch,
) -> Result<Row, Error> {
    let made = catch_unwind(AssertUnwindSafe(|| row(robot, options, name, logs, watch)));
    made.unwrap_or_else(|_| {
        Ok(Row {
            robot: name.0.to_string(),
            day: name.1.to_string(),
            urdf_hash: robot.description.hash.clone(),
            inputs: each_once(logs).into_iter().map(|log| log.hash).collect(),
            error: Some(DEFECT.to_string()),
            version: env!("CARGO_PKG_VERSION").to_string(),
            ..Row::default()
        })
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
