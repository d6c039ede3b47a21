//! One call from logs, or from what was gathered of them, to everything that is said
//! of a fit and made from it.
//!
//! ```text
//! logs ─▶ gather ─▶ part ─┐
//! parts ──────────────────┴▶ joined ─▶ fit ─▶ report ─▶ model file, URDF, residuals
//! ```

use std::sync::Arc;

use sesc_model::{Model, ModelFile, Snapping};

use super::corrected::{Corrected, check_positive, check_total, correct, masses_of};
use super::estimate::identify_within;
use super::identification::{Identification, Settings};
use super::joined::logs;
use super::limits::Limits;
use super::looked::{is_alone, looked_and_joined};
use super::masses::Masses;
use super::prior::Prior;
use super::request::Request;
use super::residuals::{self, Sample};
use super::summary::over_range;
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::threads::processors;
use crate::watch::{Recorder, Watch};
use crate::{Error, Setting, message};

/// Everything that was found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// What was found, as it is printed.
    pub identification: Identification,
    /// The parameters, for predictions and generated code.
    pub model_file: ModelFile,
    /// Where it was wanted.
    pub corrected: Option<Corrected>,
    /// Where they were wanted; none of parts alone.
    pub residuals: Sample,
    /// What is to be known of the robot.
    pub notes: Vec<String>,
    robot: Arc<Robot>,
    model: Arc<Model>,
    snapping: Snapping,
    prior: Prior,
}

impl Report {
    /// Its model on the support, with CAD masses.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The robot that was fitted.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Whether decimals of right angles were made exact.
    pub fn is_snapped(&self) -> bool {
        self.snapping != Snapping::Off
    }

    /// The URDF whose masses and centres of mass give the parameters; the robot weighs
    /// `total_mass` kg, as in CAD unless given.
    ///
    /// # Errors
    /// When no masses give them.
    pub fn corrected_urdf(&self, total_mass: Option<f64>) -> Result<Corrected, Error> {
        check_total(total_mass)?;
        correct(
            &self.robot,
            &self.model,
            self.snapping,
            &self.identification,
            &self.prior,
            total_mass,
        )
    }

    /// Parts of the whole of [`sesc_model::standard`] that a corrected URDF is made of; none
    /// where no masses give the parameters. What [`corrected_of`](super::corrected::corrected_of)
    /// takes where this report is no more.
    #[doc(hidden)]
    pub fn masses(&self) -> Option<Vec<f64>> {
        let found = &self.identification;
        let masses = masses_of(
            &self.robot,
            &self.model,
            &found.parameters.iter().map(|p| p.value).collect::<Vec<_>>(),
            found.masses.as_ref(),
            &self.prior,
        );
        let theta = |masses: Masses| masses.theta.iter().copied().collect();
        masses.ok().map(theta)
    }
}

/// Some of the readings beside their predictions; none of parts alone.
///
/// ```
/// use std::sync::Arc;
/// use sesc_identify::fit::{Request, fit, residuals};
/// use sesc_identify::logs::Table;
/// use sesc_identify::robot::Robot;
/// # let urdf = "<robot name='rod'><link name='foot'/>\
/// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
/// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
/// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
/// #     </robot>";
/// # let hip: Vec<f64> = (0..30).map(|k| 0.6 * (0.7 * f64::from(k)).sin()).collect();
/// # let log = Table::new("rod.csv")
/// #     .numbers("cop_x", hip.iter().map(|q| 0.11 * q.sin()).collect::<Vec<f64>>())
/// #     .numbers("cop_y", vec![0.0; 30])
/// #     .numbers("hip", hip);
/// # let mut request = Request::default();
/// # request.robot = Some(Arc::new(Robot::parse(urdf, "rod.urdf")?));
/// # request.logs = vec![log.into()];
/// # request.support = Some("foot".into());
/// # request.noise = Some(1e-5);
/// let report = fit(&request, &mut ())?;
/// let sample = residuals(&request, &report, &mut ())?;
/// let row = &sample.rows[1];
/// let miss = |predicted: [f64; 2]| (predicted[0] - row.measured[0]).abs();
/// assert!(miss(row.fitted) < 0.01 * miss(row.cad));
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// When a log cannot be read again; the kind `Interrupted` where `watch` stops it.
pub fn residuals(
    request: &Request,
    report: &Report,
    watch: &mut dyn Watch,
) -> Result<Sample, Error> {
    if request.logs.is_empty() {
        return Ok(Sample::default());
    }
    let support = &report.identification.support;
    let logs = logs(request, &report.robot, Some(support.clone()), None);
    let mut measurement = Measurement::new(&report.robot, support, report.snapping)?;
    let found = &report.identification;
    let known = (&found.estimate.params, &found.plans[..]);
    residuals::sample(&logs, &mut measurement, known, watch)
}

/// Fit the parameters of a robot.
///
/// ```
/// use std::sync::Arc;
/// use sesc_identify::fit::{Request, fit};
/// use sesc_identify::logs::Table;
/// use sesc_identify::robot::Robot;
///
/// let urdf = "<robot name='rod'><link name='foot'/>\
///     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
///     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
///     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
///     </robot>";
/// // The CoM of the leg is 0.11 m along it, not 0.1 m.
/// let hip: Vec<f64> = (0..30).map(|k| 0.6 * (0.7 * f64::from(k)).sin()).collect();
/// let log = Table::new("rod.csv")
///     .numbers("cop_x", hip.iter().map(|q| 0.11 * q.sin()).collect::<Vec<f64>>())
///     .numbers("cop_y", vec![0.0; 30])
///     .numbers("hip", hip);
/// let mut request = Request::default();
/// request.robot = Some(Arc::new(Robot::parse(urdf, "rod.urdf")?));
/// request.logs = vec![log.into()];
/// request.support = Some("foot".into());
/// request.noise = Some(1e-5);
/// let report = fit(&request, &mut ())?;
/// let leg = report.identification.parameters.iter().find(|p| (p.cad - 0.1).abs() < 1e-9);
/// assert!((leg.unwrap().value - 0.11).abs() < 1e-4);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// What is wrong with a log, a part, the robot or the request; the kind `Interrupted`
/// where `watch` stops it.
pub fn fit(request: &Request, watch: &mut dyn Watch) -> Result<Report, Error> {
    for (setting, value, unit) in [
        (Setting::Noise, request.noise, " m"),
        (Setting::Range, request.range.map(f64::to_degrees), "°"),
        (Setting::TotalMass, request.total_mass, " kg"),
    ] {
        check_positive(setting, value, unit)?;
    }
    let watch = &mut Recorder::new(watch);
    let (request, part) = looked_and_joined(request, is_alone(request), processors(), watch)?;
    let request = &*request;
    // The robot of the logs is read already; that of parts is in them.
    let is_it =
        |robot: &&Arc<Robot>| robot.text() == part.urdf && robot.description.file == part.urdf_file;
    let robot = match request.robot.as_ref().filter(is_it) {
        Some(robot) => Arc::clone(robot),
        None => Arc::new(Robot::parse(&part.urdf, &part.urdf_file)?),
    };
    let snapping = match part.snapped {
        true => Snapping::default(),
        false => Snapping::Off,
    };
    let model = robot.model(&part.support, snapping, None)?;
    part.check_robot(&robot, &model)?;
    let settings = Settings {
        noise: request.noise,
        range: request.range,
        ..Settings::new(request.prior.of(&model)?)
    };
    if request.physical && matches!(settings.prior, Prior::Population(_) | Prior::Fitted(_)) {
        return Err(Error::request(message![
            Setting::Physical,
            " needs to know how far masses of links may be off CAD, and neither a population of \
             robots nor an earlier fit tells: give ",
            Setting::Prior,
            " cad"
        ]));
    }
    for log in &part.gathered.logs {
        settings.prior.check_other(&log.file, &log.hash)?;
    }
    let supports: Vec<&str> = part.supports.iter().map(String::as_str).collect();
    let limits = request.physical.then(|| Limits::of(&robot)).transpose()?;
    let place = format!("{} {snapping:?} {:?}", part.support, settings.range);
    let over_range = robot
        .over_range
        .get(&place, || over_range(&model, settings.range));
    let mut found = identify_within(
        (&model, &over_range),
        &supports,
        &part.gathered,
        &settings,
        limits.as_ref(),
    );
    if request.physical && found.masses.is_none() {
        return Err(Error::request(message![
            Setting::Physical,
            format!(": {}; fit without it, or with ", found.warnings.join("; ")),
            Setting::Prior,
            " cad"
        ]));
    }
    found.warnings_of_logs = watch.warnings.len();
    let of_logs = watch.warnings.iter().map(|warning| warning.to_string());
    found.warnings.splice(0..0, of_logs);
    let model_file = found.model_file(&model);
    check_result(&model_file)?;
    let mut report = Report {
        model_file,
        corrected: None,
        residuals: Sample::default(),
        notes: model.tree.notes.clone(),
        identification: found,
        robot,
        model: Arc::new(model),
        snapping,
        prior: settings.prior,
    };
    if request.corrected_urdf {
        report.corrected = Some(report.corrected_urdf(request.total_mass)?);
    }
    if request.residuals {
        report.residuals = residuals(request, &report, watch)?;
    }
    Ok(report)
}

/// A result that is not finite is none.
pub(crate) fn check_result(file: &ModelFile) -> Result<(), Error> {
    match file.invalid_reason() {
        None => Ok(()),
        Some(reason) => Err(Error::request(format!(
            "these data give no result: {reason}; look for rows, deviations or tolerances that \
             are no measurements"
        ))),
    }
}
