//! One call from logs, or from what was gathered of them, to everything that is said
//! of a fit and made from it.
//!
//! ```text
//! logs ─▶ read, looked at ─▶ gathered ─▶ part ─┐
//! parts ───────────────────────────────────────┴▶ joined ─▶ fit ─▶ report ─▶ model file, URDF, residuals
//! ```

use std::sync::Arc;

use sesc_model::{Model, ModelFile, MotionCounted, Snapping};

use super::corrected::{Corrected, check_positive, correct, masses_of};
use super::estimate::{identify, over_range};
use super::identification::{Identification, Settings};
use super::logs::Logs;
use super::masses::{Limits, Masses};
use super::offset;
use super::part::{FORMAT, Part, PartOptions};
use super::prior::Prior;
use super::request::{Duplicates, Request};
use super::residuals::{self, Sample};
use super::timing::Timing;
use crate::logs::Stays;
use crate::observations::motion_use::MotionModel;
use crate::robot::Robot;
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
    /// Where they were wanted; none of parts alone.
    pub residuals: Sample,
    /// What is to be known of the robot.
    pub notes: Vec<String>,
    /// The robot that was fitted.
    pub robot: Arc<Robot>,
    /// Its model on the support, with CAD masses.
    pub model: Arc<Model>,
    /// Whether decimals of right angles were made exact.
    pub snapping: Snapping,
    prior: Prior,
    /// What is known of the noise and the motion of each log.
    timings: Vec<Timing>,
}

impl Report {
    /// The URDF whose masses and centres of mass give the parameters; the robot weighs
    /// `total_mass` kg, as in CAD unless given.
    ///
    /// # Errors
    /// When no masses give them.
    pub fn corrected_urdf(&self, total_mass: Option<f64>) -> Result<Corrected, Error> {
        let (robot, model, target) = (&self.robot, &self.model, self.target());
        correct(robot, model, self.snapping, target, &self.prior, total_mass)
    }

    /// Parts of the whole of [`sesc_model::standard`] that a corrected URDF is made of; none
    /// where no masses give the parameters. What [`correct`] takes where this report is no more.
    #[doc(hidden)]
    pub fn masses(&self) -> Option<Vec<f64>> {
        let masses = masses_of(&self.robot, &self.model, self.target(), &self.prior);
        Some(masses.ok()?.theta.as_slice().to_vec())
    }

    /// Parameters of the corrected URDF, and masses that give them where they are known.
    fn target(&self) -> (&[f64], Option<&Masses>) {
        let found = &self.identification;
        (found.estimate.params.as_slice(), found.masses.as_ref())
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
    check_positive(Setting::Noise, request.noise, " m")?;
    check_positive(Setting::Range, request.range.map(f64::to_degrees), "°")?;
    let offset = offset::tried(request.offset)?;
    let watch = &mut Recorder::new(watch);
    let (logs, part) = joined(request, is_alone(request), watch)?;
    // The robot of the logs is read already; that of parts is in them.
    let is_it =
        |robot: &&Arc<Robot>| robot.text() == part.urdf && robot.description.file == part.urdf_file;
    let robot = match request.robot.as_ref().filter(is_it) {
        Some(robot) => Arc::clone(robot),
        None => Arc::new(part.robot()?),
    };
    let snapping = part.snapping();
    let model = robot.model(&part.support, snapping, None)?;
    part.check_robot(&robot, &model)?;
    let mut settings = Settings {
        noise: request.noise,
        range: request.range,
        offset,
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
    settings.limits = request.physical.then(|| Limits::of(&robot)).transpose()?;
    let place = format!("{} {snapping:?} {:?}", part.support, settings.range);
    let over_range = robot
        .over_range
        .get(&place, || over_range(&model, settings.range));
    settings.over_range = Some(over_range);
    let mut found = identify(&model, &part.supports, &part.gathered, &settings);
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
    let mut model_file = found.model_file(&model);
    if request.motion == MotionModel::Off {
        model_file.motion = Some(MotionCounted::Static);
    }
    check_result(&model_file)?;
    let mut report = Report {
        model_file,
        residuals: Sample::default(),
        notes: model.tree.notes.clone(),
        identification: found,
        robot,
        model: Arc::new(model),
        snapping,
        prior: settings.prior,
        timings: Vec::new(),
    };
    if let Some(logs) = logs {
        if request.residuals {
            report.residuals = residuals::sample(&logs, &report.identification, watch)?;
        }
        report.timings = logs.timings;
    }
    Ok(report)
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
/// Those of [`fit`](super::fit).
pub fn gather(request: &Request, watch: &mut dyn Watch) -> Result<Part, Error> {
    gather_as(request, is_alone(request), watch)
}

/// [`gather`] of logs that are fitted with others, or `alone`.
pub(crate) fn gather_as(
    request: &Request,
    alone: bool,
    watch: &mut dyn Watch,
) -> Result<Part, Error> {
    Ok(joined(request, alone, watch)?.1)
}

/// Whether the request is about one log and nothing else.
fn is_alone(request: &Request) -> bool {
    request.logs.len() == 1 && request.parts.is_empty()
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
    let found = &report.identification;
    let settled = (Some(found.support.clone()), None);
    let robot = Arc::clone(&report.robot);
    let mut logs = Logs::read(request, robot, settled, is_alone(request), watch)?;
    logs.timings.clone_from(&report.timings);
    residuals::sample(&logs, found, watch)
}

/// All logs and parts as one part; beside it the logs, if there are any.
fn joined<'r>(
    request: &'r Request,
    alone: bool,
    watch: &mut dyn Watch,
) -> Result<(Option<Logs<'r>>, Part), Error> {
    let mut whole: Option<Part> = None;
    let add = |whole: &mut Option<Part>, part: Part, name: &str| {
        match (whole.as_mut(), request.duplicates) {
            (None, _) => *whole = Some(part),
            (Some(whole), Duplicates::Refuse) => whole.merge(part, name)?,
            (Some(whole), Duplicates::Skip) => whole.merge_new(part, name)?,
        }
        Ok::<_, Error>(())
    };
    for (name, part) in &request.parts {
        add(&mut whole, part.clone(), name)?;
    }
    if let Some(whole) = &whole {
        check_settled(request, whole)?;
    }
    let mut logs = None;
    if !request.logs.is_empty() {
        let (own, part) = of_logs(request, whole.as_ref(), alone, watch)?;
        add(&mut whole, part, "the logs")?;
        logs = Some(own);
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
    if let Some(unit) = &request.unit {
        whole.claim(unit)?;
    }
    if let Some(support) = &request.support {
        whole.stand_on(support)?;
    }
    Ok((logs, whole))
}

/// The logs of a request, and what they contribute beside `parts`.
fn of_logs<'r>(
    request: &'r Request,
    parts: Option<&Part>,
    alone: bool,
    watch: &mut dyn Watch,
) -> Result<(Logs<'r>, Part), Error> {
    let robot = match (&request.robot, parts) {
        (Some(robot), _) => Arc::clone(robot),
        (None, Some(part)) => Arc::new(part.robot()?),
        (None, None) => return Err(Error::request("no robot: give the URDF before the logs")),
    };
    let support = request.support.clone();
    let support = support.or_else(|| parts.map(|part| part.support.clone()));
    let folds = parts.map(|part| part.gathered.folds.len());
    let settled = (support, folds);
    let mut logs = Logs::read(request, Arc::clone(&robot), settled, alone, watch)?;
    let (supports, gathered) = logs.gather(watch)?;
    let part = Part {
        format: FORMAT.to_string(),
        hash: robot.description.hash.clone(),
        urdf_file: robot.description.file.clone(),
        urdf: robot.text().to_string(),
        support: supports[0].clone(),
        supports,
        snapped: request.snapping != Snapping::Off,
        unit: request.unit.clone(),
        options: PartOptions {
            motion: request.motion,
            stays: request.stays,
            robust: request.robust,
        },
        gathered,
    };
    Ok((logs, part))
}

/// Whether what is asked for agrees with what was settled when parts were gathered.
fn check_settled(request: &Request, whole: &Part) -> Result<(), Error> {
    let (own, folds) = (whole.options, whole.gathered.folds.len());
    let parts_alone = request.logs.is_empty();
    let other_motion = request.motion != MotionModel::Auto && request.motion != own.motion;
    let other_stays = request.stays != Stays::default() && request.stays != own.stays;
    let otherwise = ", but the parts were gathered otherwise: leave it out";
    let reason = if request.robust.is_some() {
        let needs = " needs the postures themselves: give all logs by ";
        message![Setting::Robust, needs, Setting::Data]
    } else if parts_alone && request.angles.is_some() {
        let about = " is about logs, and factor files hold no angles: leave it out";
        message![Setting::Angles, about]
    } else if request.snapping == Snapping::Off && whole.snapped {
        let but = ", but the parts were gathered with right angles made exact: leave it out";
        message![Setting::Snapping, but]
    } else if parts_alone && other_motion {
        message![Setting::Motion, otherwise]
    } else if parts_alone && other_stays {
        message![Setting::Settle, otherwise]
    } else if let Some(asked) = request.folds.filter(|asked| *asked != folds) {
        let but = format!(" {asked}, but the parts were gathered in {folds}: leave it out");
        message![Setting::Folds, but]
    } else {
        return Ok(());
    };
    let remedy = ", or give it when the parts are gathered with ";
    Err(Error::request(reason.and(remedy).and(Setting::Partial)))
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

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use super::*;
    use crate::logs::{LogSource, Table};
    use crate::robot::ROD;
    use crate::watch::Progress;
    use crate::{ErrorKind, Message};

    /// Warnings, in their order; a call is stopped after `left` steps.
    #[derive(Default)]
    struct Listener {
        warnings: Vec<String>,
        left: Option<usize>,
    }

    impl Watch for Listener {
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
            self.warnings.push(warning.to_string());
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

    /// The rows of a log in memory are screened as those of its file are.
    #[test]
    fn copied_rows_are_left_out_and_warnings_are_given_once() {
        for (copied, left) in [(0, 200), (40, 160)] {
            let mut listener = Listener::default();
            let part = gather(&request(200, copied), &mut listener).unwrap();
            assert_eq!(part.gathered.readings, left);
            assert_eq!(part.health().len(), usize::from(copied > 0));
            assert_eq!(listener.warnings.len(), 1, "{:?}", listener.warnings);
        }
    }

    #[test]
    fn a_watch_stops_the_call() {
        for left in 0..4 {
            let mut listener = Listener {
                left: Some(left),
                ..Listener::default()
            };
            let stopped = gather(&request(200, 0), &mut listener).map(|_| ());
            match stopped {
                Err(error) => assert_eq!(error.kind(), ErrorKind::Interrupted),
                Ok(()) => assert!(left > 1),
            }
        }
    }

    /// What is wrong with a log by itself is said of logs that are fitted together, too.
    #[test]
    fn a_log_of_one_row_in_copies_is_refused_by_its_name() {
        let mut request = request(200, 0);
        let still = Table::new("still")
            .numbers("cop_x", vec![0.01; 50])
            .numbers("cop_y", vec![0.02; 50])
            .numbers("hip", vec![0.1; 50]);
        request.logs.push(LogSource::from(still));
        let error = gather(&request, &mut ()).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains("still"), "{error}");
    }
}
