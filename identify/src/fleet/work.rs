//! The work on one group, wherever it is done: its logs are read, looked up in the store by
//! what they hold, and diagnosed if they are not there.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::content::{Log, each_once};
use super::evaluate::row;
use super::groups::Group;
use super::options::Options;
use super::row::Row;
use super::store::Store;
use crate::robot::Robot;
use crate::watch::Watch;
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
    /// Hash and path of every log that was read.
    pub read: Vec<(String, PathBuf)>,
    /// Whether the row was in the store.
    pub from_store: bool,
    /// The URDF, where it is not the fleet's.
    pub urdf: Option<PathBuf>,
}

/// Work on one group, of a fleet with this robot, these options and this store.
///
/// # Errors
/// When the store cannot be written; the kind `Interrupted` where `watch` stops the call. What
/// is wrong with a log is in the row.
pub fn work(
    (robot, options, store): (&Arc<Robot>, &Options, Option<&Store>),
    group: &Group,
    watch: &mut dyn Watch,
) -> Result<Done, Error> {
    let mut options = options.clone();
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
        None => Ok(Arc::clone(robot)),
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
                inputs: each_once(&logs).into_iter().map(|l| l.hash).collect(),
                error: Some("its URDF cannot be used".to_string()),
                version: env!("CARGO_PKG_VERSION").to_string(),
                ..Row::default()
            };
            return Ok(Done {
                row,
                failed,
                read,
                from_store: false,
                urdf: None,
            });
        }
    };
    let key = store.map(|store| (store, Store::key(&robot, &options, name, &logs)));
    let known = key.as_ref().and_then(|(store, key)| store.get(key));
    let from_store = known.is_some();
    let mut found = match known {
        Some(row) => row,
        None => {
            let found = made(&robot, &options, name, &logs, watch)?;
            let sound = found.error.as_deref() != Some(DEFECT);
            if let Some((store, key)) = key.as_ref().filter(|_| sound) {
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
        urdf: group.urdf.clone(),
    })
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
