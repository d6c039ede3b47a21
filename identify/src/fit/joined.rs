//! Logs and parts of a request joined into one part.

use std::sync::Arc;

use sesc_model::{Model, Snapping};

use super::logs::Logs;
use super::looked::looked_and_joined;
use super::part::{About, Part, PartOptions};
use super::request::{Duplicates, FOLDS, Request};
use super::revisits;
use super::soles;
use crate::health::Finding;
use crate::logs::{Options, Readings, Stays};
use crate::observations::motion_use::MotionModel;
use crate::robot::Robot;
use crate::threads::processors;
use crate::watch::Watch;
use crate::{Error, Setting, message};

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

/// The robot of the logs.
pub(super) fn robot_of(request: &Request, parts: Option<&Part>) -> Result<Arc<Robot>, Error> {
    match (&request.robot, parts) {
        (Some(robot), _) => Ok(Arc::clone(robot)),
        (None, Some(part)) => Ok(Arc::new(Robot::parse(&part.urdf, &part.urdf_file)?)),
        (None, None) => Err(Error::request("no robot: give the URDF before the logs")),
    }
}

/// All logs and parts as one part.
pub(super) fn joined(
    request: &Request,
    health: Vec<Finding>,
    watch: &mut dyn Watch,
) -> Result<Part, Error> {
    let mut parts = request.parts.iter();
    let mut whole = parts.next().map(|(_, part)| part.clone());
    if let Some(whole) = &mut whole {
        for (name, part) in parts {
            add(whole, part.clone(), name, request.duplicates)?;
        }
        check_settled(request, whole)?;
    }
    if !request.logs.is_empty() {
        let part = of_logs(request, whole.as_ref(), watch)?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => add(whole, part, "the logs", request.duplicates)?,
        }
    } else if let (Some(robot), Some(whole)) = (&request.robot, &whole) {
        let about = &robot.description;
        if about.hash != whole.hash {
            return Err(Error::request(format!(
                "{} (hash {}) is not the robot of the factor files ({}, hash {})",
                about.file, about.hash, whole.urdf_file, whole.hash
            )));
        }
    }
    let nothing = message![
        "nothing to fit: add logs by ",
        Setting::Data,
        ", or factor files"
    ];
    let mut whole = whole.ok_or_else(|| Error::request(nothing))?;
    whole.gathered.health.extend(health);
    if let Some(unit) = &request.unit {
        whole.claim(unit)?;
    }
    if let Some(support) = &request.support {
        whole.stand_on(support)?;
    }
    Ok(whole)
}

fn add(whole: &mut Part, part: Part, name: &str, duplicates: Duplicates) -> Result<(), Error> {
    match duplicates {
        Duplicates::Refuse => whole.merge(part, name),
        Duplicates::Skip => whole.merge_new(part, name),
    }
}

/// Whether what is asked for agrees with what was settled when parts were gathered.
fn check_settled(request: &Request, whole: &Part) -> Result<(), Error> {
    macro_rules! settled {
        ($($piece:expr),+) => {
            Err(Error::request(message![
                $($piece),+,
                ", or give it when the parts are gathered with ",
                Setting::Partial
            ]))
        };
    }
    if request.robust.is_some() {
        let why = " needs the postures themselves: give all logs by ";
        return settled!(Setting::Robust, why, Setting::Data);
    }
    if request.angles.is_some() && request.logs.is_empty() {
        let why = " is about logs, and factor files hold no angles: leave it out";
        return settled!(Setting::Angles, why);
    }
    if request.snapping == Snapping::Off && whole.snapped {
        let why = ", but the parts were gathered with right angles made exact: leave it out";
        return settled!(Setting::Snapping, why);
    }
    if let Some(own) = whole.options.filter(|_| request.logs.is_empty()) {
        let why = ", but the parts were gathered otherwise: leave it out";
        if request.motion != MotionModel::Auto && request.motion != own.motion {
            return settled!(Setting::Motion, why);
        }
        if request.stays != Stays::default() && request.stays != own.stays {
            return settled!(Setting::Settle, why);
        }
    }
    let folds = whole.gathered.folds.len();
    match request.folds.filter(|asked| *asked != folds) {
        Some(asked) => settled!(
            Setting::Folds,
            format!(" {asked}, but the parts were gathered in {folds}: leave it out")
        ),
        None => Ok(()),
    }
}

fn of_logs(request: &Request, parts: Option<&Part>, watch: &mut dyn Watch) -> Result<Part, Error> {
    let robot = robot_of(request, parts)?;
    let support = request.support.clone();
    let support = support.or_else(|| parts.map(|part| part.support.clone()));
    let folds = parts.map(|part| part.gathered.folds.len());
    let prior = |model: &Model| request.prior.of(model);
    let logs = logs(request, &robot, support, folds);
    let (measurement, mut gathered) = logs.gather(request.robust, &prior, watch)?;
    if request.noise.is_none() {
        gathered.again = revisits::of(&logs, &gathered, watch)?;
    }
    gathered.closure = soles::worst(&logs, &request.feet, watch)?;
    let supports = measurement.supports();
    let about = About {
        hash: robot.description.hash.clone(),
        urdf_file: robot.description.file.clone(),
        urdf: robot.text().to_string(),
        support: supports[0].to_string(),
        supports: supports.iter().map(|s| s.to_string()).collect(),
        snapped: request.snapping != Snapping::Off,
        unit: request.unit.clone(),
        options: PartOptions {
            motion: request.motion,
            stays: request.stays,
            robust: request.robust,
        },
    };
    Ok(Part::new(about, gathered))
}

/// The logs of a request, in as many folds as the parts they go with.
pub(super) fn logs<'r>(
    request: &'r Request,
    robot: &'r Arc<Robot>,
    support: Option<String>,
    folds: Option<usize>,
) -> Logs<'r> {
    let links = robot.description.links.iter();
    Logs {
        robot,
        files: &request.logs,
        options: Options {
            angles: request.angles,
            readings: Readings::Required,
            links: links.map(|link| link.name.clone()).collect(),
            support: request.support.clone(),
            stays: request.stays,
            soles: request.feet.soles(robot, request.snapping),
            ..Options::default()
        },
        support,
        snapping: request.snapping,
        folds: folds.or(request.folds).unwrap_or(FOLDS),
        one_noise: request.noise.is_some(),
        motion: request.motion,
    }
}
