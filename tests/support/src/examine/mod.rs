//! Virtual robots examined by the library: what `fit` and `diagnose` answer, beside the truth.

pub mod bought;
pub mod com;
pub mod labs;
pub mod recordings;
pub mod unlisted;

use std::collections::BTreeMap;
use std::sync::Arc;

use sesc_identify::diagnose::{self, Diagnosis, Report};
use sesc_identify::fit::{self, Identification};
use sesc_identify::logs::{LogSource, Options, PostureReader, Table};
use sesc_identify::predict;
use sesc_identify::robot::{Robot, Stance};
use sesc_model::ModelFile;

use crate::recording::Recording;
use crate::stage::Stage;

/// An error of the library, or of a file.
pub type Failure = Box<dyn std::error::Error>;

/// ± this many deviations hold 95 %.
pub const OF_95: f64 = 1.959_964;

/// A recording as a log in memory.
pub fn log(recording: &Recording, timed: bool) -> LogSource {
    let columns = recording.columns(timed).into_iter();
    let table = Table::new("recording");
    let table = columns.fold(table, |table, (name, values)| table.numbers(&name, values));
    table.into()
}

/// The robot of a stage, from its URDF.
///
/// # Errors
/// Of the URDF.
pub fn robot(stage: &Stage) -> Result<Arc<Robot>, Failure> {
    Ok(Arc::new(Robot::read(&stage.urdf)?))
}

/// The diagnosis of `diagnose --prior tight`.
///
/// # Errors
/// Of the log.
pub fn diagnosed(
    robot: &Arc<Robot>,
    support: &str,
    log: LogSource,
    noise: Option<f64>,
) -> Result<Diagnosis, Failure> {
    let mut request = diagnose::Request::new(Arc::clone(robot), log);
    request.support = Some(support.into());
    request.noise = noise;
    request.prior = "tight".into();
    Ok(diagnose::diagnose(&request, &mut ())?.diagnosis)
}

/// The identification of `fit --prior`.
///
/// # Errors
/// Of the log.
pub fn fitted(
    robot: &Arc<Robot>,
    support: &str,
    log: LogSource,
    noise: Option<f64>,
    prior: &str,
) -> Result<Identification, Failure> {
    let mut request = fit::Request::default();
    request.robot = Some(Arc::clone(robot));
    request.logs = vec![log];
    request.support = Some(support.into());
    request.noise = noise;
    request.prior = prior.into();
    Ok(fit::fit(&request, &mut ())?.identification)
}

/// Parameters whose 95 % interval holds the truth, of those that have one.
pub fn intervals(found: &Identification, truth: &[f64]) -> (usize, usize) {
    let known = found.parameters.iter().zip(truth);
    let holds: Vec<bool> = known
        .filter_map(|(p, truth)| Some((p.value - truth).abs() <= OF_95 * p.std?))
        .collect();
    (holds.iter().filter(|holds| **holds).count(), holds.len())
}

/// Gap that `predict` with the written model leaves of the log that it came from, m RMS, without
/// the postures that the diagnosis leaves out.
///
/// # Errors
/// Of the file or the log.
pub fn left_by_file(
    report: &Report,
    robot: &Arc<Robot>,
    support: &str,
    log: &LogSource,
) -> Result<f64, Failure> {
    let file = ModelFile::parse(&toml::to_string(&report.model_file)?, "model.toml")?;
    let stance = Stance::new(Arc::clone(robot)).on(support);
    let dofs = stance.model()?.tree.dofs.clone();
    let request = predict::Request::new(stance.with_parameters(file)?, log.clone());
    let predicted = predict::predict(&request, &mut ())?.cop_m;
    let block = PostureReader::open(log, &dofs, &Options::default())?.block(usize::MAX / 2)?;
    let read = block.reading.unwrap_or_default();
    let mut sums: BTreeMap<i64, ([f64; 2], f64)> = BTreeMap::new();
    for ((pose, y), p) in block.pose.iter().zip(&read).zip(&predicted) {
        let (sum, rows) = sums.entry(*pose).or_default();
        *sum = [0, 1].map(|axis| sum[axis] + y[axis] - p[axis]);
        *rows += 1.0;
    }
    for pose in &report.diagnosis.model_on_log.left_out {
        sums.remove(pose);
    }
    let squares = sums
        .values()
        .flat_map(|(sum, rows)| sum.map(|sum| (sum / rows).powi(2)));
    Ok((squares.sum::<f64>() / (2 * sums.len()) as f64).sqrt())
}
