//! One call from logs, or from what was gathered of them, to everything that is said
//! of a fit and made from it.
//!
//! ```text
//! logs ─▶ gather ─▶ part ─┐
//! parts ──────────────────┴▶ merged ─▶ fit ─▶ report ─▶ model file, URDF, residuals
//! ```

use std::borrow::Cow;
use std::sync::Arc;

use sesc_model::{Model, ModelFile, Snapping};

use super::corrected::{Corrected, correct};
use super::estimate::identify_within;
use super::identification::{Identification, Settings};
use super::limits::Limits;
use super::logs::Logs;
use super::part::{About, Part};
use super::prior::{Prior, PriorChoice};
use super::residuals::{self, Sample};
use super::revisits;
use super::robust::Loss;
use super::soles;
use crate::feet::Feet;
use crate::health::{self, Finding};
use crate::logs::{Angles, LogSource, Options, Readings, Stays};
use crate::observations::motion_use::MotionModel;
use crate::observations::rows::Measurement;
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, Setting, message};

/// Folds of the cross-validation unless given.
pub const FOLDS: usize = 10;

/// What is to be fitted, and how.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Request {
    /// The robot of the logs; that of the parts unless given.
    pub robot: Option<Arc<Robot>>,
    /// Logs: paths, bytes or tables.
    pub logs: Vec<LogSource>,
    /// What was gathered of other logs, each with the name that messages give it.
    pub parts: Vec<(String, Part)>,
    /// The link whose parameters are meant, and on the ground in rows that do not say;
    /// the first log's own unless given.
    pub support: Option<String>,
    /// Whether decimals of right angles are made exact.
    pub snapping: Snapping,
    /// Unit of revolute joints; the sidecar's, else rad, unless given.
    pub angles: Option<Angles>,
    /// How far masses may be off CAD.
    pub prior: PriorChoice,
    /// Standard deviation of a single reading on one axis, m; the log's unless given.
    pub noise: Option<f64>,
    /// Trust postures less that no noise explains.
    pub robust: Option<Loss>,
    /// Folds of the cross-validation; [`FOLDS`], or those of the parts, unless given.
    pub folds: Option<usize>,
    /// Errors are expected for joints within ± this of zero, rad; else for their limits.
    pub range: Option<f64>,
    /// Whether masses have to be possible.
    pub physical: bool,
    /// Whether the corrected URDF is wanted, and what the robot weighs in it, kg: as in
    /// CAD unless given.
    pub corrected_urdf: bool,
    /// What the robot weighs in the corrected URDF, kg; as in CAD unless given.
    pub total_mass: Option<f64>,
    /// Whether some of the readings are wanted beside their predictions.
    pub residuals: bool,
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// Which feet are on the floor; each log's own unless given.
    pub feet: Feet,
}

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
        check_positive(Setting::TotalMass, total_mass)?;
        correct(
            &self.robot,
            &self.model,
            self.snapping,
            &self.identification,
            &self.prior,
            total_mass,
        )
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

fn check_positive(setting: Setting, value: Option<f64>) -> Result<(), Error> {
    match value.filter(|x| !(1e-9..=1e6).contains(x)) {
        None => Ok(()),
        Some(x) => Err(Error::request(message![
            setting,
            format!(" {x:e}: give a number above zero that a robot can have")
        ])),
    }
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
    for (setting, value) in [
        (Setting::Noise, request.noise),
        (Setting::Range, request.range.map(f64::to_degrees)),
        (Setting::TotalMass, request.total_mass),
    ] {
        check_positive(setting, value)?;
    }
    let (request, health) = screened(request, watch)?;
    let (request, part) = (&*request, gathered(&request, health, watch)?);
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
    if request.physical && matches!(settings.prior, Prior::Population(_)) {
        return Err(Error::request(message![
            Setting::Physical,
            " needs to know how far masses of links may be off CAD, and a population of robots \
             does not tell: give ",
            Setting::Prior,
            " cad"
        ]));
    }
    let supports: Vec<&str> = part.supports.iter().map(String::as_str).collect();
    let limits = request.physical.then(|| Limits::of(&robot)).transpose()?;
    let found = identify_within(
        &model,
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
/// As [`fit`].
pub fn gather(request: &Request, watch: &mut dyn Watch) -> Result<Part, Error> {
    let (request, health) = screened(request, watch)?;
    gathered(&request, health, watch)
}

/// The request with its logs as far as they can be used, and what is wrong with them.
fn screened<'r>(
    request: &'r Request,
    watch: &mut dyn Watch,
) -> Result<(Cow<'r, Request>, Vec<Finding>), Error> {
    let parts = request.parts.first().map(|(_, part)| part);
    if request.logs.is_empty() {
        return Ok((Cow::Borrowed(request), Vec::new()));
    }
    let robot = robot_of(request, parts)?;
    let support = request.support.clone();
    let support = support.or_else(|| parts.map(|part| part.support.clone()));
    let logs = logs(request, &robot, support, None);
    let model = robot.model(&logs.first_support()?, request.snapping, None)?;
    let reading = health::Reading {
        options: &logs.options,
        snapping: request.snapping,
        noise: request.noise,
        alone: request.logs.len() == 1 && request.parts.is_empty(),
    };
    let (mut usable, mut findings) = (Vec::new(), Vec::new());
    for log in &request.logs {
        let (log, found) = health::look(log, &robot, &model, reading, watch)?;
        usable.push(log);
        findings.extend(found);
    }
    if findings.is_empty() {
        return Ok((Cow::Borrowed(request), findings));
    }
    let request = Request {
        logs: usable,
        ..request.clone()
    };
    Ok((Cow::Owned(request), findings))
}

/// The robot of the logs.
fn robot_of(request: &Request, parts: Option<&Part>) -> Result<Arc<Robot>, Error> {
    match (&request.robot, parts) {
        (Some(robot), _) => Ok(Arc::clone(robot)),
        (None, Some(part)) => Ok(Arc::new(Robot::parse(&part.urdf, &part.urdf_file)?)),
        (None, None) => Err(Error::request("no robot: give the URDF before the logs")),
    }
}

fn gathered(request: &Request, health: Vec<Finding>, watch: &mut dyn Watch) -> Result<Part, Error> {
    let mut parts = request.parts.iter();
    let mut whole = parts.next().map(|(_, part)| part.clone());
    if let Some(whole) = &mut whole {
        for (name, part) in parts {
            whole.merge(part.clone(), name)?;
        }
        check_settled(request, whole)?;
    }
    if !request.logs.is_empty() {
        let part = of_logs(request, whole.as_ref(), watch)?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.merge(part, "the logs")?,
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
    if let Some(support) = &request.support {
        whole.stand_on(support)?;
    }
    Ok(whole)
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
    };
    Ok(Part::new(about, gathered))
}

/// The logs of a request, in as many folds as the parts they go with.
fn logs<'r>(
    request: &'r Request,
    robot: &'r Robot,
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
            ..Options::default()
        },
        support,
        snapping: request.snapping,
        folds: folds.or(request.folds).unwrap_or(FOLDS),
        one_noise: request.noise.is_some(),
        motion: request.motion,
    }
}
