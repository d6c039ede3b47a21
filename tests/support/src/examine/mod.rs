//! Virtual robots examined by the library: what `fit` and `diagnose` answer, beside the truth.

pub mod ankles;
pub mod bought;
pub mod com;
pub mod labs;
pub mod recordings;
pub mod unlisted;

use std::collections::BTreeMap;
use std::sync::Arc;

use sesc_identify::diagnose::{self, Diagnosis, Report};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::fit::{self, Identification};
use sesc_identify::logs::{LogSource, Options, PostureReader};
use sesc_identify::predict;
use sesc_identify::robot::{Robot, Stance};
use sesc_model::{Function, ModelFile, Snapping};
use sesc_reference::World;

use crate::recording::Recording;
use crate::stage::Stage;

/// An error of the library, or of a file.
pub type Failure = Box<dyn std::error::Error>;

/// ± this many deviations hold 95 %.
pub const OF_95: f64 = 1.959_964;

/// A recording as a log in memory.
pub fn log(recording: &Recording, timed: bool) -> LogSource {
    recording.table(timed).into()
}

/// A model file, written and read again.
///
/// # Errors
/// Of the file.
pub fn reread(file: &ModelFile) -> Result<ModelFile, Failure> {
    Ok(ModelFile::parse(&toml::to_string(file)?, "model.toml")?)
}

/// What `predict` says of a log, with a model file or with CAD's parameters.
///
/// # Errors
/// Of the file or the log.
pub fn predicted(
    robot: &Arc<Robot>,
    support: &str,
    log: LogSource,
    file: Option<&ModelFile>,
) -> Result<predict::Predictions, Failure> {
    let mut stance = Stance::new(Arc::clone(robot)).on(support);
    if let Some(file) = file {
        stance = stance.with_parameters(file.clone())?;
    }
    Ok(predict::predict(
        &predict::Request::new(stance, log),
        &mut (),
    )?)
}

/// RMS distance of the CoMs of a model from those of the bent robot, over the directions `axes`, m.
///
/// # Errors
/// Of the file.
pub fn com_error(
    stage: &Stage,
    world: &World,
    file: Option<&ModelFile>,
    q: &[Vec<f64>],
    axes: std::ops::Range<usize>,
) -> Result<f64, Failure> {
    let model = robot(stage)?.model(stage.support, Snapping::default(), file)?;
    let com = Evaluator::new(&model, Function::Com).run(&q.concat(), q.len());
    let gaps = com.as_chunks::<3>().0.iter().zip(q).map(|(com, q)| {
        let truth = world.com(q);
        let gaps = axes.clone().map(|axis| (com[axis] - truth[axis]).powi(2));
        gaps.sum::<f64>()
    });
    Ok((gaps.sum::<f64>() / q.len() as f64).sqrt())
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
    let file = reread(&report.model_file)?;
    let dofs = Stance::new(Arc::clone(robot))
        .on(support)
        .model()?
        .tree
        .dofs
        .clone();
    let predicted = predicted(robot, support, log.clone(), Some(&file))?.cop_m;
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
