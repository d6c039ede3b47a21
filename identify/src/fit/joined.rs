//! Logs and parts of a request joined into one part.

use std::sync::Arc;

use sesc_model::{Model, Snapping};

use super::logs::Logs;
use super::part::{About, Part, PartOptions};
use super::request::{Duplicates, FOLDS, Request};
use super::revisits;
use super::soles;
use crate::feet::Places;
use crate::health::Finding;
use crate::logs::{Options, Readings, Stays};
use crate::observations::motion_use::MotionModel;
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, Setting, message};

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
    if request.logs.is_empty() {
        let own = whole.options;
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
    gathered.closure = soles::worst(&logs, &gathered.logs, &request.feet, watch)?;
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
            soles: Some(Places::of(robot, request.snapping)),
            both_feet: request.feet.said(),
            ..Options::default()
        },
        support,
        snapping: request.snapping,
        folds: folds.or(request.folds).unwrap_or(FOLDS),
        one_noise: request.noise.is_some(),
        motion: request.motion,
    }
}
