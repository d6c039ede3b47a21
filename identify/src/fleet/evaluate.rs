//! The row of a group: a pure function of its URDF, its options and what its logs hold.

use std::sync::Arc;

use super::content::{Log, each_once};
use super::joined_logs::together;
use super::options::{Only, Options};
use super::row::Row;
use crate::diagnose::{Request, diagnose};
use crate::fit::prior::{Prior, PriorChoice};
use crate::fit::{self, fit};
use crate::logs::{LogSource, Options as Reading, PostureReader, Readings};
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, ErrorKind};

/// Rows read at once where a log is only looked at.
const BLOCK: usize = 4096;

/// What the logs of one robot on one day come to. Logs are sorted by what they hold, and one
/// that comes twice counts once; those that cannot be read are named in the row's error, and
/// the others make up the row.
///
/// # Errors
/// The kind `Interrupted` where `watch` stops it, and no other.
pub fn row(
    robot: &Arc<Robot>,
    options: &Options,
    (name, day): (&str, &str),
    logs: &[Log],
    watch: &mut dyn Watch,
) -> Result<Row, Error> {
    let logs = each_once(logs);
    let mut row = Row {
        robot: name.to_string(),
        day: day.to_string(),
        urdf_hash: robot.description.hash.clone(),
        support: options.support.clone().unwrap_or_default(),
        inputs: logs.iter().map(|log| log.hash.clone()).collect(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        ..Row::default()
    };
    let (mut errors, mut sources) = (Vec::new(), Vec::new());
    for log in &logs {
        let single = logs.len() == 1;
        let source = log.source().and_then(|source| match single {
            // The diagnosis will say what is wrong with it.
            true => Ok(source),
            false => readable(robot, options, &source).map(|()| source),
        });
        match source {
            Ok(source) => sources.push(source),
            Err(error) => errors.push(error.to_string()),
        }
    }
    if !sources.is_empty()
        && let Err(error) = look(robot, options, &sources, &mut row, watch)
    {
        if error.kind() == ErrorKind::Interrupted {
            return Err(error);
        }
        errors.push(error.to_string());
    }
    row.error = (!errors.is_empty()).then(|| errors.join("; "));
    Ok(row)
}

/// Diagnose and fit.
fn look(
    robot: &Arc<Robot>,
    options: &Options,
    sources: &[LogSource],
    row: &mut Row,
    watch: &mut dyn Watch,
) -> Result<(), Error> {
    let support = support(robot, options, sources)?;
    row.support.clone_from(&support);
    if options.only == Only::All {
        diagnosed(robot, options, sources, row, watch)?;
        if !row.is_usable() {
            return Ok(());
        }
    }
    let request = fit::Request {
        robot: Some(Arc::clone(robot)),
        logs: sources.to_vec(),
        support: Some(support),
        snapping: options.snapping(),
        angles: options.angles,
        prior: prior(options, Prior::DEFAULT),
        noise: options.noise,
        motion: options.motion_model(),
        feet: options.feet(),
        ..fit::Request::default()
    };
    let found = fit(&request, watch)?.identification;
    if options.only == Only::Parameters {
        row.fitted(&found);
        if !found.is_usable() {
            return Ok(());
        }
    }
    row.params = found.parameters.iter().map(|p| p.value).collect();
    let finite = |x: &f64| x.is_finite();
    let parameters = found.parameters.iter();
    row.std = parameters.map(|p| p.std.filter(finite)).collect();
    if options.information {
        let covariance = &found.estimate.covariance;
        let lower = (0..covariance.nrows()).flat_map(|i| (0..=i).map(move |j| covariance[(i, j)]));
        row.covariance = lower.collect();
    }
    Ok(())
}

fn diagnosed(
    robot: &Arc<Robot>,
    options: &Options,
    sources: &[LogSource],
    row: &mut Row,
    watch: &mut dyn Watch,
) -> Result<(), Error> {
    let log = match sources {
        [one] => one.clone(),
        several => together(several, &robot.description.dofs(), &reading(robot, options))?,
    };
    let mut request = Request::new(Arc::clone(robot), log);
    request.support = Some(row.support.clone());
    request.snapping = options.snapping();
    // Several logs were put together in SI units.
    request.angles = options.angles.filter(|_| sources.len() == 1);
    request.prior = prior(options, Prior::OF_DIAGNOSES);
    request.noise = options.noise;
    request.floor = options.floor;
    request.motion = options.motion_model();
    request.feet = options.feet();
    let report = diagnose(&request, watch)?;
    row.diagnosed(&report.diagnosis);
    Ok(())
}

fn prior(options: &Options, usual: &str) -> PriorChoice {
    PriorChoice::from(options.prior.as_deref().unwrap_or(usual))
}

/// The link on the ground: that of the options, else of the first log that says.
fn support(robot: &Robot, options: &Options, sources: &[LogSource]) -> Result<String, Error> {
    if let Some(support) = &options.support {
        return Ok(support.clone());
    }
    let mut odd = Vec::new();
    for source in sources {
        let (sidecar, own) = source.sidecar()?;
        if let Some(support) = sidecar.support {
            return Ok(support);
        }
        odd.extend(own);
    }
    Err(robot.no_support(&odd))
}

fn reading(robot: &Robot, options: &Options) -> Reading {
    Reading {
        angles: options.angles,
        readings: Readings::Required,
        links: robot.description.link_names().map(str::to_string).collect(),
        support: options.support.clone(),
        ..Reading::default()
    }
}

/// Whether a log can be read to its end.
fn readable(robot: &Robot, options: &Options, log: &LogSource) -> Result<(), Error> {
    let dofs = robot.description.dofs();
    let mut reader = PostureReader::open(log, &dofs, &reading(robot, options))?;
    while !reader.block(BLOCK)?.is_empty() {}
    Ok(())
}
