//! All groups of a fleet on the cores of one machine.
//!
//! One group at a time a core: its logs are read, looked up in the store by what they hold,
//! and diagnosed if they are not there. Memory is that of the rows, and of one group's logs a
//! core.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use super::disk::Local;
use super::gathering::{Fleet, Gathering};
use super::groups::Group;
use super::options::Options;
use super::store::Store;
use super::work::{Done, Job, work};
use crate::Error;
use crate::robot::Robot;
use crate::watch::{Progress, Watch, tell};

/// How often who waits is asked whether to go on, while no group ends.
const EVERY: Duration = Duration::from_millis(10);

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
    let groups = &request.groups;
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let threads = request
        .threads
        .unwrap_or(cores)
        .clamp(1, groups.len().max(1));
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut gathering = Gathering::default();
    let total = groups.len() as u64;
    thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..threads {
            let (send, next, stop, groups) = (send.clone(), &next, &stop, groups);
            scope.spawn(move || {
                let mut stopped = |_: Progress| match stop.load(Ordering::Relaxed) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                while let Some(group) = groups.get(next.fetch_add(1, Ordering::Relaxed))
                    && !stop.load(Ordering::Relaxed)
                    && {
                        let job = Job {
                            robot: &request.robot,
                            options: &request.options,
                            store: request.store.as_ref(),
                            disk: &Local,
                        };
                        send.send(work(job, group, &mut stopped)).is_ok()
                    }
                {}
            });
        }
        drop(send);
        let all = gather(&receive, &mut gathering, total, watch);
        stop.store(true, Ordering::Relaxed);
        all
    })?;
    Ok(gathering.finish(&request.robot, &Local))
}

/// Receive what threads send, and tell how far they are.
fn gather(
    receive: &mpsc::Receiver<Result<Done, Error>>,
    gathering: &mut Gathering,
    total: u64,
    watch: &mut dyn Watch,
) -> Result<(), Error> {
    let mut done = 0;
    loop {
        tell(watch, "diagnosing", done, total)?;
        match receive.recv_timeout(EVERY) {
            Ok(group) => {
                gathering.add(group?);
                done += 1;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
}
