//! The work on one group, wherever it is done: its logs are read unless the store knows them,
//! looked up there by what they hold, and diagnosed if they are not there.
//!
//! Of parameters alone a group needs the parts of its logs: each log is read once, its part is
//! kept, and memory holds one log at a time.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::content::{Log, each_once, name_of};
use super::desk::Desk;
use super::disk::Disk;
use super::evaluate::{Group as Logs, row};
use super::failed::{Failed, name_of_urdf, with_cause};
use super::groups::Group;
use super::options::{Only, Options};
use super::part_of_log::DEFECT;
use super::row::Row;
use super::store::Store;
use crate::Error;
use crate::robot::Robot;
use crate::watch::{Watch, tell};

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
    let mut options = job.options.clone();
    options.support = group.support.clone().or(options.support);
    let robot = match &group.urdf {
        None => Ok(Arc::clone(job.robot)),
        Some(path) => job.disk.robot(path).map(Arc::new),
    };
    let robot = match robot {
        Ok(robot) => robot,
        Err(error) => return Ok(without_robot(&job, group, &error)),
    };
    let mut desk = Desk::new((job.store, job.disk), &robot, &options, group);
    desk.open(watch)?;
    let name = (group.robot.as_str(), group.day.as_str());
    let contents = each_once(&desk.contents());
    let key = Store::key(&robot, &options, name, &contents);
    let known = job.store.and_then(|store| store.get(job.disk, &key));
    let from_store = known.is_some();
    let mut found = match known {
        Some(row) => row,
        None => {
            let logs = Logs {
                robot: &robot,
                options: &options,
                logs: &contents,
            };
            made(logs, name, &mut desk, watch)?
        }
    };
    // Who stopped the run may be gone: nothing is written any more.
    tell(watch, "diagnosing", 1, 1)?;
    let sound = desk.sound && found.error.as_deref().is_none_or(|e| !e.contains(DEFECT));
    desk.keep((!from_store && sound).then_some((&key, &found)))?;
    let Desk {
        read,
        mut failed,
        mut errors,
        opened,
        ..
    } = desk;
    if let Some(error) = &found.error {
        failed.extend(named(error, &read, (group, robot.as_ref())));
        errors.insert(0, error.clone());
    }
    found.set_errors(errors);
    Ok(Done {
        row: found,
        failed,
        read,
        opened,
        from_store,
        urdf: group.urdf.clone(),
    })
}

/// What a group comes to whose URDF cannot be used.
fn without_robot(job: &Job, group: &Group, error: &Error) -> Done {
    let mut desk = Desk::new((job.store, job.disk), job.robot, job.options, group);
    desk.look();
    let input = group.urdf.as_deref().unwrap_or(Path::new("")).display();
    let contents = each_once(&desk.contents());
    desk.failed.push(Failed {
        input: input.to_string(),
        error: with_cause(error),
    });
    let row = Row {
        robot: group.robot.clone(),
        day: group.day.clone(),
        inputs: contents.into_iter().map(|log| log.hash).collect(),
        error: Some("its URDF cannot be used".to_string()),
        version: env!("CARGO_PKG_VERSION").to_string(),
        ..Row::default()
    };
    Done {
        row,
        opened: desk.opened,
        failed: desk.failed,
        read: desk.read,
        from_store: false,
        urdf: None,
    }
}

/// The row of a group; a panic is an error in it.
fn made(
    group: Logs,
    name: (&str, &str),
    desk: &mut Desk,
    watch: &mut dyn Watch,
) -> Result<Row, Error> {
    let made = catch_unwind(AssertUnwindSafe(|| match group.options.only {
        Only::Parameters => group.row_of_parts(name, desk, watch),
        Only::All => {
            let logs: Vec<Log> = desk.in_memory(watch)?;
            row(group.robot, group.options, name, &logs, watch)
        }
    }));
    made.unwrap_or_else(|_| {
        let mut row = group.row(name);
        row.set_errors(vec![DEFECT.to_string()]);
        Ok(row)
    })
}

/// The error of a row, with the names of files for the hashes of logs.
fn named(error: &str, read: &[(String, PathBuf)], (group, robot): (&Group, &Robot)) -> Vec<Failed> {
    let urdf = &robot.description;
    let error = &error.replace(&name_of_urdf(&urdf.hash), &urdf.file);
    let faulty = read
        .iter()
        .filter(|(hash, _)| error.contains(&name_of(hash)));
    let mut faulty: Vec<&(String, PathBuf)> = faulty.collect();
    faulty.dedup_by(|a, b| a.0 == b.0);
    let say = |path: &Path| {
        let mut said = error.to_string();
        for (hash, path) in read {
            said = said.replace(&name_of(hash), &path.display().to_string());
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
