//! All groups of a fleet: the work on one of them wherever that is done, and what they came to,
//! put together in whatever order they come.
//!
//! On one machine each thread works on one group at a time: its logs are read, looked up in the
//! store by what they hold, and evaluated if they are not there. Memory is that of the rows, and
//! of one group's logs a thread.

use std::ops::ControlFlow::{Break, Continue};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::Options;
use super::evaluate::row;
use super::inputs::Group;
use super::log::{Failed, Log, each_once, name_of_log, name_of_urdf, read_urdf};
use super::log::{Store, key, row_of};
use super::row::Row;
use super::row::assembled;
use crate::Error;
use crate::robot::Robot;
use crate::threads::processors;
use crate::watch::{Progress, Watch, tell};

/// How often the caller is asked whether to go on, while no group ends.
const EVERY: Duration = Duration::from_millis(10);

/// The error of logs that made the library panic; the row is not kept.
const DEFECT: &str = "these logs meet a defect of sesc; please report it";

/// A fleet and how it is looked at.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot of every log that has no URDF of its own.
    pub robot: Arc<Robot>,
    /// The logs, by robot and day.
    pub groups: Vec<Group>,
    /// How every group is looked at.
    pub options: Options,
    /// Where rows are kept.
    pub store: Option<Store>,
    /// Threads; as many as there are cores unless given.
    pub threads: Option<usize>,
}

impl Request {
    /// These logs of this robot, by the usual options.
    pub fn new(robot: Arc<Robot>, groups: Vec<Group>) -> Request {
        Request {
            robot,
            groups,
            options: Options::default(),
            store: None,
            threads: None,
        }
    }
}

/// A log that was given before under another name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Twice {
    /// The file.
    pub input: String,
    /// The file with the same bytes.
    pub same_as: String,
    /// Whether both count once, as logs of one robot and day.
    pub counted_once: bool,
}

/// Everything that was found, group by group.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
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
}

/// What a group came to: its row, and what is known of its files where it was worked on.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Done {
    /// The row.
    pub row: Row,
    /// Logs with errors.
    pub failed: Vec<Failed>,
    /// Hash and path of every log.
    pub read: Vec<(String, PathBuf)>,
    /// Whether the row was in the store.
    pub from_store: bool,
}

/// Look at every group.
///
/// ```
/// use std::sync::Arc;
/// use sesc_identify::fleet::{Request, groups, inputs, run};
/// use sesc_identify::robot::Robot;
/// # let urdf = "<robot name='rod'><link name='foot'/>\
/// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
/// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
/// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
/// #     </robot>";
/// let robot = Arc::new(Robot::parse(urdf, "rod.urdf")?);
/// # let folder = std::env::temp_dir().join(format!("sesc-fleet-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).unwrap();
/// let log = folder.join("r17_monday.csv");
/// std::fs::write(&log, "cop_x,cop_y\n0,0\n").unwrap();
/// let groups = groups(&inputs(&[log.display().to_string()], &["robot".into(), "day".into()])?);
/// // A log that cannot be read is a row with its error, never the end of the run.
/// let mut request = Request::new(robot, groups);
/// request.options.support = Some("foot".into());
/// let fleet = run(&request, &mut ())?;
/// assert_eq!(fleet.rows[0].robot, "r17");
/// assert!(fleet.rows[0].error.as_deref().is_some_and(|error| error.contains("hip")));
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// When the store cannot be written; the kind `Interrupted` where `watch` stops the run. What
/// is wrong with a log is in its row.
pub fn run(request: &Request, watch: &mut dyn Watch) -> Result<Fleet, Error> {
    let (robot, options, groups) = (&request.robot, &request.options, &request.groups);
    let threads = request.threads.unwrap_or_else(processors);
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (send, receive) = mpsc::channel();
    let all = thread::scope(|scope| {
        for _ in 0..threads.clamp(1, groups.len().max(1)) {
            let (send, next, stop) = (send.clone(), &next, &stop);
            scope.spawn(move || {
                let mut stopped = |_: Progress| {
                    if stop.load(Ordering::Relaxed) {
                        Break(())
                    } else {
                        Continue(())
                    }
                };
                while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let done = work(robot, options, group, request.store.as_ref(), &mut stopped);
                    // Nobody receives it any more where the run was stopped.
                    if send.send(done).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut all = Vec::new();
        let received = loop {
            let told = tell(watch, "diagnosing", all.len() as u64, groups.len() as u64);
            match told.map(|()| receive.recv_timeout(EVERY)) {
                Ok(Ok(Ok(done))) => all.push(done),
                Ok(Err(RecvTimeoutError::Timeout)) => {}
                Ok(Err(RecvTimeoutError::Disconnected)) => break Ok(all),
                Ok(Ok(Err(error))) | Err(error) => break Err(error),
            }
        };
        drop(receive);
        stop.store(true, Ordering::Relaxed);
        received
    })?;
    Ok(gathered(all))
}

/// Work on one group: read its logs, and evaluate them unless the store has their row. `robot` is
/// that of groups without a URDF of their own.
///
/// # Errors
/// When the store cannot be written; the kind `Interrupted` where `watch` stops the call. What
/// is wrong with a log is in the row.
pub fn work(
    robot: &Arc<Robot>,
    options: &Options,
    group: &Group,
    store: Option<&Store>,
    watch: &mut dyn Watch,
) -> Result<Done, Error> {
    let mut options = options.clone();
    options.support = group.support.clone().or(options.support);
    let mut done = Done::default();
    let mut logs = Vec::new();
    for path in &group.logs {
        tell(watch, "diagnosing", 0, 1)?;
        match Log::read(path) {
            Ok(log) => {
                done.read.push((log.hash.clone(), path.clone()));
                logs.push(log);
            }
            Err(error) => done.failed.push(Failed::reading(path, &error)),
        }
    }
    let logs = each_once(&logs);
    let mut errors: Vec<String> = done.failed.iter().map(|f| f.error.clone()).collect();
    let name = (group.robot.as_str(), group.day.as_str());
    done.row = row_of(name, &logs);
    let robot = match group.urdf.as_deref().map(|path| (path, read_urdf(path))) {
        None => Arc::clone(robot),
        Some((_, Ok(own))) => Arc::new(own),
        Some((path, Err(error))) => {
            done.failed.push(Failed::reading(path, &error));
            done.row.error = Some("its URDF cannot be used".to_string());
            return Ok(done);
        }
    };
    let key = key(&robot, &options, name, &logs);
    let known = store.and_then(|store| store.get(&key));
    // What stands under the right key of a store that was merged or half restored may be another's.
    let known = known.filter(|row| {
        (&row.robot, &row.day, &row.inputs) == (&done.row.robot, &done.row.day, &done.row.inputs)
            && row.urdf_hash == robot.description.hash
            && (options.support.as_ref()).is_none_or(|support| row.support == *support)
    });
    done.from_store = known.is_some();
    if let Some(known) = known {
        done.row = known;
    } else {
        let made = AssertUnwindSafe(|| row(&robot, &options, name, &logs, watch));
        match catch_unwind(made) {
            Ok(made) => {
                done.row = made?;
                // A run that was stopped writes nothing any more.
                tell(watch, "diagnosing", 1, 1)?;
                store.map_or(Ok(()), |store| store.put(&key, &done.row))?;
            }
            Err(_) => done.row.error = Some(DEFECT.to_string()),
        }
    }
    if let Some(error) = &done.row.error {
        done.failed.extend(named(error, &done.read, group, &robot));
        errors.insert(0, error.clone());
    }
    done.row.set_errors(errors);
    Ok(done)
}

/// The error of a row, with the names of files for the hashes of logs.
fn named(error: &str, read: &[(String, PathBuf)], group: &Group, robot: &Robot) -> Vec<Failed> {
    let urdf = &robot.description;
    let mut error = error.replace(&name_of_urdf(&urdf.hash), &urdf.file);
    let mut inputs = Vec::new();
    for (hash, path) in read {
        let (name, path) = (name_of_log(hash), path.display().to_string());
        if error.contains(&name) {
            error = error.replace(&name, &path);
            inputs.push(path);
        }
    }
    if inputs.is_empty() {
        inputs.extend(group.logs.first().map(|path| path.display().to_string()));
    }
    let failed = |input| Failed {
        input,
        error: error.clone(),
    };
    inputs.into_iter().map(failed).collect()
}

/// What groups came to, in any order, put together.
pub fn gathered(all: Vec<Done>) -> Fleet {
    let mut fleet = Fleet::default();
    // Every log: the hash of its content, its path, its robot and day.
    let mut read: Vec<(String, String, [String; 2])> = Vec::new();
    for done in all {
        let row = done.row;
        fleet.failed.extend(done.failed);
        fleet.from_store += usize::from(done.from_store);
        for (hash, path) in done.read {
            let of = [row.robot.clone(), row.day.clone()];
            read.push((hash, path.display().to_string(), of));
        }
        fleet.rows.push(row);
    }
    read.sort();
    for same in read.chunk_by(|a, b| a.0 == b.0) {
        let (_, first, of) = &same[0];
        fleet.twice.extend(same[1..].iter().map(|other| Twice {
            input: other.1.clone(),
            same_as: first.clone(),
            counted_once: other.2 == *of,
        }));
    }
    fleet.failed.sort();
    fleet.twice.sort();
    fleet.rows = assembled(fleet.rows);
    fleet
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::ROD;

    /// Under a right key and with a right hash.
    #[test]
    fn a_kept_row_of_another_group_is_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("r_1.csv");
        std::fs::write(&log, "pose,hip,cop_x,cop_y\n0,0,0,0\n").unwrap();
        let robot = Arc::new(Robot::parse(ROD, "rod.urdf").unwrap());
        let group = Group {
            robot: "r".into(),
            day: "1".into(),
            urdf: None,
            logs: vec![log],
            support: Some("foot".into()),
        };
        let (options, store) = (Options::default(), Store::new(folder.path().join("store")));
        let work = || work(&robot, &options, &group, Some(&store), &mut ()).unwrap();
        let own = work().row;
        assert!(work().from_store);
        let logs = [Log::read(&group.logs[0]).unwrap()];
        let asked = Options {
            support: group.support.clone(),
            ..options.clone()
        };
        let key = key(&robot, &asked, ("r", "1"), &logs);
        let others: [fn(&mut Row); 5] = [
            |row| row.robot = "../../evil".into(),
            |row| row.day = "2".into(),
            |row| row.urdf_hash = "0".into(),
            |row| row.support = "leg".into(),
            |row| row.inputs.clear(),
        ];
        for change in others {
            let mut other = own.clone();
            change(&mut other);
            store.put(&key, &other).unwrap();
            let done = work();
            assert!(!done.from_store && done.row == own, "{other:?}");
        }
    }

    /// Whether a row is kept is not judged by the words of its error, which may quote a log.
    #[test]
    fn a_log_that_says_what_a_defect_says_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("r_1.csv");
        std::fs::write(&log, "pose,hip,cop_x,cop_y\n0,0,0,0\n").unwrap();
        let sidecar = format!("support = '''{DEFECT}'''\n");
        std::fs::write(folder.path().join("r_1.csv.toml"), sidecar).unwrap();
        let robot = Arc::new(Robot::parse(ROD, "rod.urdf").unwrap());
        let group = Group {
            robot: "r".into(),
            day: "1".into(),
            urdf: None,
            logs: vec![log],
            support: None,
        };
        let store = Store::new(folder.path().join("store"));
        let again = [false, true].map(|_| {
            let options = Options::default();
            let done = work(&robot, &options, &group, Some(&store), &mut ()).unwrap();
            assert!(done.row.error.unwrap().contains(DEFECT));
            done.from_store
        });
        assert_eq!(again, [false, true]);
    }
}
