//! Logs are looked at while they are joined into one part, where there is a processor for each.
//!
//! ```text
//! request ─┬▶ look ─────┬─ nothing to leave out ─▶ the part as it was joined
//!          └▶ joined ───┴─ rows to leave out ────▶ joined once more, without these rows
//! ```
//!
//! What comes of it is the same as if one had followed the other.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::panic;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Builder};

use sesc_model::Model;

use super::joined::{joined, logs, robot_of};
use super::part::Part;
use super::request::Request;
use crate::health::{self, Finding};
use crate::logs::{LogSource, Options};
use crate::robot::Robot;
use crate::threads::processors;
use crate::watch::{Progress, Watch};
use crate::{Error, Message};

/// Gather all logs and parts of a request into one part, on its support.
///
/// ```
/// use std::sync::Arc;
/// use sesc_identify::fit::{Request, fit, gather};
/// use sesc_identify::logs::Table;
/// use sesc_identify::robot::Robot;
/// # let urdf = "<robot name='rod'><link name='foot'/>\
/// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
/// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
/// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
/// #     </robot>";
/// # let robot = Arc::new(Robot::parse(urdf, "rod.urdf")?);
/// # let log = |name: &str, start: u32| {
/// #     let hip: Vec<f64> = (start..start + 20).map(|k| (0.7 * f64::from(k)).sin()).collect();
/// #     Table::new(name)
/// #         .numbers("cop_x", hip.iter().map(|q| 0.11 * q.sin()).collect::<Vec<f64>>())
/// #         .numbers("cop_y", vec![0.0; 20])
/// #         .numbers("hip", hip)
/// # };
/// // A part per day: a few kilobytes, however long the logs are.
/// let part = |name: &str, start| {
///     let mut day = Request::default();
///     day.robot = Some(robot.clone());
///     day.logs = vec![log(name, start).into()];
///     day.support = Some("foot".into());
///     day.noise = Some(1e-5);
///     gather(&day, &mut ())
/// };
/// let (monday, tuesday) = (part("monday", 0)?, part("tuesday", 20)?);
/// assert_eq!(monday.postures(), 20);
///
/// let mut both = Request::default();
/// both.parts = vec![("monday".into(), monday), ("tuesday".into(), tuesday)];
/// assert_eq!(fit(&both, &mut ())?.identification.postures, 40);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// Those of [`fit`](super::fit).
pub fn gather(request: &Request, watch: &mut dyn Watch) -> Result<Part, Error> {
    let (_, part) = looked_and_joined(request, is_alone(request), processors(), watch)?;
    Ok(part)
}

/// [`gather`] on one processor, beside others that gather parts. `alone`: whether the part is
/// fitted without those of other logs.
pub(crate) fn gather_as(
    request: &Request,
    alone: bool,
    watch: &mut dyn Watch,
) -> Result<Part, Error> {
    let (_, part) = looked_and_joined(request, alone, 1, watch)?;
    Ok(part)
}

/// Whether the request is about one log and nothing else.
pub(super) fn is_alone(request: &Request) -> bool {
    request.logs.len() == 1 && request.parts.is_empty()
}

/// The request with its logs as far as they can be used, and all its logs and parts as one part.
/// `alone` says whether the part is fitted without those of other logs; one after the other on one
/// of the `processors`.
///
/// # Errors
/// What is wrong with a log, a part, the robot or the request; the kind `Interrupted` where
/// `watch` stops it.
pub(super) fn looked_and_joined<'r>(
    request: &'r Request,
    alone: bool,
    processors: usize,
    watch: &mut dyn Watch,
) -> Result<(Cow<'r, Request>, Part), Error> {
    if request.logs.is_empty() {
        let part = joined(request, Vec::new(), watch)?;
        return Ok((Cow::Borrowed(request), part));
    }
    let look = Look::new(request, alone)?;
    let (usable, meanwhile) = match processors > 1
        && request
            .logs
            .iter()
            .all(LogSource::can_be_read_twice_at_once)
    {
        true => side_by_side(&look, watch)?,
        false => (look.all(watch)?, None),
    };
    let part = match meanwhile {
        Some(Meanwhile { part, told }) => {
            told.into_iter().for_each(|told| told.tell(watch));
            let mut part = part?;
            part.gathered.health.extend(usable.findings);
            part
        }
        None => joined(&usable.request, usable.findings, watch)?,
    };
    Ok((Cow::Owned(usable.request), part))
}

/// What logs are looked at with.
struct Look<'r> {
    /// The request with logs that are refused if their files change from now on.
    request: Request,
    robot: Arc<Robot>,
    model: Model,
    options: Options,
    alone: bool,
    asked: &'r Request,
}

/// Logs as far as they can be used.
struct Usable {
    request: Request,
    findings: Vec<Finding>,
}

impl Look<'_> {
    fn new(request: &Request, alone: bool) -> Result<Look<'_>, Error> {
        let parts = request.parts.first().map(|(_, part)| part);
        let robot = robot_of(request, parts)?;
        let support = request.support.clone();
        let support = support.or_else(|| parts.map(|part| part.support.clone()));
        let about = logs(request, &robot, support, None);
        let model = robot.model(&about.first_support()?, request.snapping, None)?;
        let options = about.options;
        let unchanged = request.logs.iter().map(|log| log.clone().unchanged());
        let unchanged = Request {
            logs: unchanged.collect::<Result<_, _>>()?,
            ..request.clone()
        };
        Ok(Look {
            request: unchanged,
            robot,
            model,
            options,
            alone,
            asked: request,
        })
    }

    /// Look at all logs. Also where nothing is wrong those that were looked at are those that
    /// are fitted.
    fn all(&self, watch: &mut dyn Watch) -> Result<Usable, Error> {
        let reading = health::Reading {
            options: &self.options,
            snapping: self.asked.snapping,
            noise: self.asked.noise,
            alone: self.alone,
        };
        let (mut usable, mut findings) = (Vec::new(), Vec::new());
        for log in &self.request.logs {
            let (log, found) = health::look(log, &self.robot, &self.model, reading, watch)?;
            usable.push(log);
            findings.extend(found);
        }
        let request = Request {
            logs: usable,
            ..self.request.clone()
        };
        Ok(Usable { request, findings })
    }
}

/// What logs were joined into while nothing was known of them.
struct Meanwhile {
    part: Result<Part, Error>,
    told: Vec<Told>,
}

/// Look at the logs, and join them meanwhile as if nothing were to be left out of them: none where
/// something is.
fn side_by_side(look: &Look, watch: &mut dyn Watch) -> Result<(Usable, Option<Meanwhile>), Error> {
    let (stopped, in_vain) = (AtomicBool::new(false), AtomicBool::new(false));
    let work = || {
        let usable = look.all(&mut |_: Progress| match stopped.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        });
        let whole = |usable: &Usable| !usable.request.logs.iter().any(LogSource::is_screened);
        in_vain.store(!usable.as_ref().is_ok_and(whole), Ordering::Relaxed);
        usable
    };
    let mut held = Held {
        watch,
        told: Vec::new(),
        stopped: &stopped,
        in_vain: &in_vain,
    };
    let (usable, part) = thread::scope(|scope| {
        let Ok(thread) = Builder::new().name("look".into()).spawn_scoped(scope, work) else {
            return (look.all(held.watch), None);
        };
        let part = joined(&look.request, Vec::new(), &mut held);
        let usable = thread.join();
        let usable = usable.unwrap_or_else(|reason| panic::resume_unwind(reason));
        (usable, Some(part))
    });
    let told = held.told;
    if stopped.load(Ordering::Relaxed) {
        return Err(Error::interrupted());
    }
    let usable = usable?;
    let part = part.filter(|_| !in_vain.load(Ordering::Relaxed));
    Ok((usable, part.map(|part| Meanwhile { part, told })))
}

/// What was said while it was not known whether it would hold.
enum Told {
    Note(String),
    Warning(Message),
}

impl Told {
    fn tell(self, watch: &mut dyn Watch) {
        match self {
            Told::Note(note) => watch.note(&note),
            Told::Warning(warning) => watch.warning(&warning),
        }
    }
}

/// Who waits, of a call that may be in vain: hears nothing but how far it is.
struct Held<'w> {
    watch: &'w mut dyn Watch,
    told: Vec<Told>,
    /// Who waits wants no more.
    stopped: &'w AtomicBool,
    in_vain: &'w AtomicBool,
}

impl Watch for Held<'_> {
    fn progress(&mut self, progress: Progress) -> ControlFlow<()> {
        if self.in_vain.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        let flow = self.watch.progress(progress);
        if flow.is_break() {
            self.stopped.store(true, Ordering::Relaxed);
        }
        flow
    }

    fn note(&mut self, note: &str) {
        self.told.push(Told::Note(note.to_string()));
    }

    fn warning(&mut self, warning: &Message) {
        self.told.push(Told::Warning(warning.clone()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;
    use crate::logs::Table;
    use crate::robot::ROD;

    /// What is said of a request, each in its order.
    #[derive(Default)]
    struct Said {
        told: Vec<String>,
        /// Tells how far a call is until it is stopped.
        left: Option<usize>,
    }

    impl Watch for Said {
        fn progress(&mut self, _: Progress) -> ControlFlow<()> {
            match &mut self.left {
                Some(0) => ControlFlow::Break(()),
                Some(left) => {
                    *left -= 1;
                    ControlFlow::Continue(())
                }
                None => ControlFlow::Continue(()),
            }
        }

        fn warning(&mut self, warning: &Message) {
            self.told.push(warning.to_string());
        }
    }

    /// A log of the rod, some of whose rows come from its first ones.
    fn request(rows: u32, copied: u32) -> Request {
        let row = |k: u32| f64::from(if k < copied { k } else { k - copied });
        let hip: Vec<f64> = (0..rows).map(|k| 0.6 * (0.7 * row(k)).sin()).collect();
        let noise = |k: u32, rate: f64| 1e-4 * (rate * row(k)).sin();
        let x = |k: u32| 0.11 * hip[k as usize].sin() + noise(k, 2.3);
        let log = Table::new("rod")
            .numbers("cop_x", (0..rows).map(x).collect::<Vec<_>>())
            .numbers(
                "cop_y",
                (0..rows).map(|k| noise(k, 1.9)).collect::<Vec<_>>(),
            )
            .numbers("speed", vec![0.0; rows as usize])
            .numbers("hip", hip.clone());
        Request {
            robot: Some(Arc::new(Robot::parse(ROD, "rod.urdf").unwrap())),
            logs: vec![log.into()],
            support: Some("foot".into()),
            ..Request::default()
        }
    }

    fn said(request: &Request, processors: usize) -> (bool, Part, Vec<String>) {
        let mut said = Said::default();
        let (usable, part) = looked_and_joined(request, true, processors, &mut said).unwrap();
        let screened = usable.logs.iter().any(LogSource::is_screened);
        (screened, part, said.told)
    }

    #[test]
    fn one_beside_the_other_gives_what_one_after_the_other_gives() {
        for (copied, screened) in [(0, false), (40, true)] {
            let request = request(200, copied);
            let (after, beside) = (said(&request, 1), said(&request, 2));
            assert_eq!(after.0, screened, "{:?}", after.1.gathered.health);
            assert_eq!(after.1.gathered.health.is_empty(), !screened);
            assert_eq!(after.2.len(), 1, "{:?}", after.2);
            assert_eq!(beside.0, after.0);
            assert_eq!(beside.1.gathered, after.1.gathered);
            assert_eq!(beside.2, after.2);
        }
    }

    #[test]
    fn who_waits_stops_both() {
        for processors in [1, 2] {
            let mut said = Said {
                left: Some(0),
                ..Said::default()
            };
            let request = request(200, 0);
            let stopped = looked_and_joined(&request, true, processors, &mut said);
            let kind = stopped.map(|_| ()).unwrap_err().kind();
            assert_eq!(kind, ErrorKind::Interrupted);
        }
    }

    /// What the look finds comes first, as if nothing had been joined.
    #[test]
    fn an_error_of_the_look_is_that_of_the_call() {
        let mut request = request(200, 0);
        let still = Table::new("still")
            .numbers("cop_x", vec![0.01; 50])
            .numbers("cop_y", vec![0.02; 50])
            .numbers("hip", vec![0.1; 50]);
        request.logs.push(still.into());
        let errors = [1, 2].map(|processors| {
            let found = looked_and_joined(&request, false, processors, &mut ());
            found.map(|_| ()).unwrap_err().to_string()
        });
        assert_eq!(errors[0], errors[1]);
        assert!(errors[0].contains("still"), "{errors:?}");
    }
}
