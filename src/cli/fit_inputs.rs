//! What `sesc fit` reads: logs, and factor files that logs were gathered into.

use std::path::{Path, PathBuf};

use sesc_model::Snapping;

use super::fit::{Arguments, RobustLoss};
use super::{Bar, notes};
use crate::Error;
use sesc_identify::fit::Identification;
use sesc_identify::fit::gather::Gathered;
use sesc_identify::fit::logs::Logs;
use sesc_identify::fit::part::{About, Part};
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::residuals::{self, Residual};
use sesc_identify::fit::robust::Loss;
use sesc_identify::logs::{Angles, Options, Readings};
use sesc_identify::observations::rows::Measurement;
use sesc_identify::robot::Robot;

/// Folds of the cross-validation unless given.
const FOLDS: usize = 10;

pub(super) fn snapping(literal: bool) -> Snapping {
    match literal {
        true => Snapping::Off,
        false => Snapping::default(),
    }
}

/// The factors of all logs and parts.
pub(super) fn gathered(arguments: &Arguments) -> Result<Part, Error> {
    let is_part = |path: &&PathBuf| path.extension().is_some_and(|e| e == "part");
    let (parts, robots): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.inputs.iter().partition(|path| is_part(path));
    if robots.len() > 1 {
        return Err(Error::Usage(format!(
            "{} and {} both stand where the URDF goes; logs are given with --data, \
             factor files end in .part",
            robots[0].display(),
            robots[1].display()
        )));
    }
    if parts.is_empty() && arguments.data.is_empty() {
        return Err(Error::Usage(
            "nothing to fit: add --data LOG, or factor files of `sesc fit --partial`".into(),
        ));
    }
    let mut whole: Option<Part> = None;
    for path in parts {
        let part = Part::read(path)?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.merge(part, path)?,
        }
    }
    if let Some(whole) = &whole {
        check_settled(arguments, whole)?;
    }
    if !arguments.data.is_empty() {
        let part = from_logs(arguments, robots.first().copied(), whole.as_ref())?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.merge(part, Path::new("--data"))?,
        }
    } else if let (Some(path), Some(whole)) = (robots.first(), &whole) {
        let robot = Robot::read(path)?;
        if robot.description.hash != whole.hash {
            return Err(Error::Usage(format!(
                "{} (hash {}) is not the robot of the factor files ({}, hash {})",
                path.display(),
                robot.description.hash,
                whole.urdf_file,
                whole.hash
            )));
        }
    }
    whole.ok_or_else(|| Error::Usage("nothing to fit".into()))
}

/// Whether what is asked for agrees with what was settled when parts were gathered.
fn check_settled(arguments: &Arguments, whole: &Part) -> Result<(), Error> {
    let settled = |what: String| {
        Err(Error::Usage(format!(
            "{what}, or give it when the parts are gathered with --partial"
        )))
    };
    if arguments.robust.is_some() {
        return settled("--robust needs the postures themselves: give all logs with --data".into());
    }
    if arguments.degrees && arguments.data.is_empty() {
        return settled(
            "--degrees is about logs, and factor files hold no angles: leave it out".into(),
        );
    }
    if arguments.no_snap && whole.snapped {
        return settled(
            "--no-snap, but the parts were gathered with right angles made exact: leave it out"
                .into(),
        );
    }
    let folds = whole.gathered.folds.len();
    match arguments.folds {
        Some(asked) if asked != folds as u64 => settled(format!(
            "--folds {asked}, but the parts were gathered in {folds}: leave it out"
        )),
        _ => Ok(()),
    }
}

fn from_logs(
    arguments: &Arguments,
    urdf: Option<&PathBuf>,
    parts: Option<&Part>,
) -> Result<Part, Error> {
    let robot = match (urdf, parts) {
        (Some(path), _) => Robot::read(path)?,
        (None, Some(part)) => Robot::parse(&part.urdf, &part.urdf_file)?,
        (None, None) => {
            return Err(Error::Usage("no robot: give the URDF before --data".into()));
        }
    };
    let support = arguments.support.clone();
    let support = support.or_else(|| parts.map(|part| part.support.clone()));
    let folds = parts.map(|part| part.gathered.folds.len());
    let logs = logs(arguments, &robot, support, folds);
    let loss = arguments.robust.map(|robust| match robust {
        RobustLoss::Huber => Loss::Huber,
        RobustLoss::Tukey => Loss::Tukey,
    });
    let mut bar = Bar::new("reading");
    let (measurement, gathered): (_, Gathered) = logs.gather(
        loss,
        &|model| Prior::named(&arguments.prior, model),
        &mut bar,
    )?;
    drop(bar);
    notes(measurement.model());
    let about = About {
        hash: robot.description.hash.clone(),
        urdf_file: robot.description.file.clone(),
        urdf: robot.text().to_string(),
        support: measurement.supports()[0].to_string(),
        supports: measurement
            .supports()
            .iter()
            .map(|s| s.to_string())
            .collect(),
        snapped: !arguments.no_snap,
    };
    Ok(Part::new(about, gathered))
}

/// The logs of the command line, in as many folds as the parts they go with.
fn logs<'r>(
    arguments: &'r Arguments,
    robot: &'r Robot,
    support: Option<String>,
    folds: Option<usize>,
) -> Logs<'r> {
    let asked = arguments.folds.and_then(|k| usize::try_from(k).ok());
    let links = robot.description.robot.links.iter();
    Logs {
        robot,
        files: &arguments.data,
        options: Options {
            angles: arguments.degrees.then_some(Angles::Deg),
            readings: Readings::Required,
            links: links.map(|link| link.name.clone()).collect(),
            support: arguments.support.clone(),
            ..Options::default()
        },
        support,
        snapping: snapping(arguments.no_snap),
        folds: folds.or(asked).unwrap_or(FOLDS),
    }
}

/// A sample of readings beside their predictions; none of factor files.
pub(super) fn residuals(
    arguments: &Arguments,
    robot: &Robot,
    support: &str,
    found: &Identification,
) -> Result<Vec<Residual>, Error> {
    let logs = logs(arguments, robot, Some(support.to_string()), None);
    let mut measurement = Measurement::new(robot, support, logs.snapping)?;
    let mut bar = Bar::new("residuals");
    let found = residuals::sample(&logs, &mut measurement, &found.estimate.params, &mut bar);
    drop(bar);
    Ok(found?)
}
