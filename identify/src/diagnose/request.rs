//! One call from a log to everything that is said of it and made from it.
//!
//! ```text
//! log ─▶ postures ─▶ search ─▶ class, verdict, held-out errors ─▶ report
//! further logs ──────────────┘                                    ├▶ model file, URDF
//!                                                                 └▶ next postures, view
//! ```

use super::criteria::FLOOR_M;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hasher as _};
use std::path::PathBuf;
use std::sync::Arc;

use sesc_model::effects::{Catalog, Experiment};
use sesc_model::{DataUsed, Model, ModelFile, MotionCounted, Snapping};

use super::experiment::NextLog;
use super::findings::{About, Diagnosis, Explained, NextPostures, Score, Verdict};
use super::model_file::{model_file, on_log};
use super::problem::{Block, Problem, soles_of};
use super::remedy::{self, CorrectedUrdf, Servo};
use super::view::DiagnosisView;
use super::{experiment, motion, noise, samples, verdict};
use crate::feet::{Feet, Places};
use crate::fit::population::Fitted;
use crate::fit::prior::{Prior, PriorChoice};
use crate::fit::{Request as FitRequest, check_result, fit, gather_as, offset};
use crate::health::{self, Finding, Health, sole_of};
use crate::logs::{
    Angles, LogSource, Options, PostureReader, ROOM, Readings, Samples, Sidecar, Stays,
};
use crate::observations::motion_use::{MotionModel, MotionUse};
use crate::observations::postures::Postures;
use crate::robot::Robot;
use crate::skeleton::Skeleton;
use crate::watch::{Recorder, Watch};
use crate::{Error, Setting, message};

/// What is to be diagnosed, and how.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot with CAD masses.
    pub robot: Arc<Robot>,
    /// The log: a path, bytes or a table.
    pub log: LogSource,
    /// Logs of experiments: explanations are fitted to them, too.
    pub then: Vec<LogSource>,
    /// Logs of the same robot when it was healthy: no effect acts in them, and the masses that they
    /// tell take the place of CAD's.
    pub healthy: Vec<LogSource>,
    /// Link on the ground in rows that do not say; the sidecar's unless given.
    pub support: Option<String>,
    /// Whether decimals of right angles are made exact.
    pub snapping: Snapping,
    /// Unit of revolute joints; the sidecar's, else rad, unless given.
    pub angles: Option<Angles>,
    /// The effects that may be the cause.
    #[doc(hidden)]
    pub effects: Catalog,
    /// How far masses may be off CAD; in logs of the healthy robot at least as they usually are.
    pub prior: PriorChoice,
    /// Standard deviation of a single reading on one axis, m; the log's unless given.
    pub noise: Option<f64>,
    /// Standard deviation of an offset of readings before the data, m: 0 where it costs what every
    /// effect does; as readings of feet and plates are off unless given.
    pub offset: Option<f64>,
    /// Added to the noise of a posture in quadrature, m.
    pub floor: f64,
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// Which feet are on the floor; the sidecar's unless given.
    pub feet: Feet,
    /// Folder of the robot's meshes, for postures that touch nothing.
    pub meshes: Option<PathBuf>,
    /// Where the caller will write the next postures; the diagnosis names it.
    pub next_file: Option<PathBuf>,
    /// Servos by joint; none of joints that are not named, whose remedies say nothing of ticks.
    pub servos: BTreeMap<String, Servo>,
    /// Whether the corrected URDF is wanted.
    pub corrected_urdf: bool,
    /// What the robot without its loads weighs in the corrected URDF, kg; as in CAD unless given.
    pub total_mass: Option<f64>,
    /// How many effects are wanted as they are fitted alone, the best first.
    pub scores: usize,
    /// Whether the rows of figures are wanted.
    #[doc(hidden)]
    pub view: bool,
}

impl Request {
    /// The defaults of the command line.
    pub fn new(robot: Arc<Robot>, log: impl Into<LogSource>) -> Request {
        Request {
            robot,
            log: log.into(),
            then: Vec::new(),
            healthy: Vec::new(),
            support: None,
            snapping: Snapping::default(),
            angles: None,
            effects: Catalog::standard(),
            prior: PriorChoice::from(Prior::OF_DIAGNOSES),
            noise: None,
            offset: None,
            floor: FLOOR_M,
            motion: MotionModel::Auto,
            stays: Stays::default(),
            feet: Feet::default(),
            meshes: None,
            next_file: None,
            servos: BTreeMap::new(),
            corrected_urdf: false,
            total_mass: None,
            scores: 0,
            view: false,
        }
    }
}

/// Everything that was found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// What was found, as it is printed.
    pub diagnosis: Diagnosis,
    /// Parameters and effects, for predictions and generated code.
    pub model_file: ModelFile,
    /// Where it was wanted.
    pub corrected_urdf: Option<CorrectedUrdf>,
    /// Whether masses are part of the explanation: those of a corrected URDF then move within
    /// the usual tolerances, else within those of the request.
    pub frees_masses: bool,
    /// What of the explanation belongs to the log alone, a sentence each.
    pub of_the_log: Vec<String>,
    /// Where it was wanted.
    #[doc(hidden)]
    pub view: Option<DiagnosisView>,
    /// Postures of the experiment that would tell most, if one would tell explanations apart.
    pub next: Option<NextLog>,
    /// Effects as they are fitted alone, the best first, as many as were wanted.
    pub scores: Vec<Score>,
    /// What is to be known of the robot.
    pub notes: Vec<String>,
}

/// A hash of joint positions and readings: the same for a log under another name, packed, or
/// with its columns in another order.
fn rows_hash(postures: &Postures) -> u64 {
    let mut hasher = DefaultHasher::new();
    for value in postures.q.iter().chain(&postures.reading) {
        hasher.write_u64(value.to_bits());
    }
    hasher.finish()
}

/// Find where simulation and measurement disagree, and name what is missing.
///
/// ```
/// use std::sync::Arc;
/// use sesc_identify::diagnose::{Request, Verdict, diagnose};
/// use sesc_identify::logs::Table;
/// use sesc_identify::robot::Robot;
///
/// let urdf = "<robot name='rod'><link name='foot'/>\
///     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
///     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
///     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
///     </robot>";
/// let robot = Arc::new(Robot::parse(urdf, "rod.urdf")?);
/// // The CoM of the leg is 0.1 m along it, and noise is 0.1 mm.
/// let hip: Vec<f64> = (0..30).map(|k| 0.6 * (0.7 * f64::from(k)).sin()).collect();
/// let noise = |k: usize, step: f64| -> f64 { 1e-4 * (step * k as f64).sin() };
/// let cop = |k: usize| 0.1 * hip[k].sin() + noise(k, 7.1);
/// let log = Table::new("rod.csv")
///     .numbers("cop_x", (0..30).map(cop).collect::<Vec<f64>>())
///     .numbers("cop_y", (0..30).map(|k| noise(k, 3.3)).collect::<Vec<f64>>())
///     .numbers("hip", hip.clone());
/// let mut request = Request::new(robot, log);
/// request.support = Some("foot".into());
/// request.noise = Some(1e-4);
/// let report = diagnose(&request, &mut ())?;
/// assert_eq!(report.diagnosis.verdict, Verdict::None);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// What is wrong with a log, its sidecar, the robot or the request; the kind
/// `Interrupted` where `watch` stops it.
pub fn diagnose(request: &Request, watch: &mut dyn Watch) -> Result<Report, Error> {
    check_noise(request)?;
    let offset_stds = offset::tried(request.offset)?;
    let watch = &mut Recorder::new(watch);
    let robot = &request.robot;
    let (samples, model) = read(request, watch)?;
    let sidecar = &samples.sidecar.clone();
    let support = model.support().to_string();
    let prior = masses_before(request, &model, watch)?;
    check_healthy(request, &support, watch)?;
    let model = prior.expected(model);
    let on = (&**robot, &model);
    let (samples, rows) = health::screen(samples, on, request.noise, watch)?;
    let mut data = take(request, &model, &prior, (&samples, request.motion), watch)?;
    // A few rows on another link are rather a wrong label than a stand on another foot.
    let rows_in_all = data.rows + data.elsewhere.values().sum::<u64>();
    let (elsewhere, left_out): (BTreeMap<String, u64>, _) = std::mem::take(&mut data.elsewhere)
        .into_iter()
        .partition(|(_, rows)| 10 * rows >= rows_in_all);
    data.elsewhere = left_out;
    warn_of_left_out(&samples, &data, watch);
    let stands = stands(request, &model, &prior, elsewhere.keys())?;
    let others = further_blocks(request, (&model, &prior), (&samples, &data), &stands, watch)?;
    let names = names([&request.log].into_iter().chain(&request.then));
    let explain = |data: &Postures, motion: MotionModel, watch: &mut dyn Watch| {
        let (mut data, health) = examined(request, &model, (data, motion));
        let health = health.after(rows.clone());
        if let Some(stuck) = &health.stuck {
            data.put_joint(stuck.joint, &stuck.positions, &stuck.less_known);
            motion::again(&mut data, &model);
        }
        let about = About {
            robot: sidecar.robot.as_deref().unwrap_or(&model.tree.robot),
            support: &support,
            log: &names,
            prior: prior.sentence(),
            usable: health.is_usable(),
            health: health.findings,
            scores: request.scores,
            sole: sole_of(&request.robot, &model),
        };
        let closure = soles_of(&request.feet, sidecar, &model, &mut data, watch)?;
        let first = Block::new(&model, data, closure, &request.effects);
        let others = others.iter().cloned();
        let others = others.map(|(block, experiment)| block.beside(&first, experiment));
        let blocks = [first.clone()].into_iter().chain(others).collect();
        let mut problem = Problem::new(blocks, &prior);
        problem.offset_stds.clone_from(&offset_stds);
        samples::explained(problem, &about, watch)
    };
    let (mut problem, mut found, mut correlation) = explain(&data, request.motion, watch)?;
    let share = motion::said(&problem, &found.best);
    if share.used && share.share.is_some_and(|share| share.is_missing()) {
        let standing = (&samples, MotionModel::Off);
        data = take(request, &model, &prior, standing, watch)?;
        data.motion_use = MotionUse {
            used: false,
            rows_left_out: 0,
            ..share
        }
        .told();
        (problem, found, correlation) = explain(&data, MotionModel::Off, watch)?;
    }
    found.diagnosis.samples = samples::of_logs(&problem, &correlation);
    found.diagnosis.motion = motion::said(&problem, &found.best);
    let open = found.diagnosis.closure.as_ref();
    if let Some(open) = open.filter(|closure| !closure.closes) {
        watch.warning(&open.sentence.clone().into());
    }
    let overstated = noise::overstated(&problem, &found);
    found.diagnosis.health.extend(overstated);
    let meshes = request.meshes.as_deref();
    found.diagnosis.times = times(&problem);
    let name = sidecar.robot.as_deref().unwrap_or(&model.tree.robot);
    let named = (&**robot, name);
    let proposed = experiment::proposed(&problem, &found, named, request.snapping, meshes);
    let why = experiment::why(&proposed, &found);
    let (experiments, logs): (Vec<_>, Vec<_>) = proposed.into_iter().unzip();
    let tells = experiments.first().is_some_and(|best| best.splits > 0);
    let next = logs.into_iter().next().filter(|_| tells);
    let file = next.as_ref().and(request.next_file.as_ref());
    found.diagnosis.next_postures = NextPostures {
        file: file.map(|path| path.display().to_string()),
        why,
        experiments,
    };
    let corrected = request
        .corrected_urdf
        .then(|| {
            let (snapping, total) = (request.snapping, request.total_mass);
            remedy::corrected_urdf(&problem, &found, robot, snapping, &prior, total)
        })
        .transpose()?;
    remedy::add(&problem, &mut found, &robot.description, &request.servos);
    found.diagnosis.left_out_of_urdf = corrected.as_ref().map(|urdf| urdf.left_out.clone());
    let model_file = with_data(request, &problem, &found);
    if found.diagnosis.verdict != Verdict::Unusable {
        check_result(&model_file)?;
    }
    found.diagnosis.model_on_log = on_log(&problem, &found.written, &model_file)?;
    verdict::state(&problem, &mut found);
    let warnings = watch.warnings.iter().map(|warning| warning.to_string());
    found.diagnosis.warnings = warnings.collect();
    Ok(Report {
        model_file,
        corrected_urdf: corrected,
        frees_masses: found.written.frees_masses(),
        of_the_log: remedy::of_the_log(&found),
        view: request.view.then(|| {
            let skeleton = Skeleton::of(&model, &robot.description, meshes);
            DiagnosisView::of(&problem, &found, skeleton)
        }),
        next,
        scores: found.scores,
        notes: model.tree.notes.clone(),
        diagnosis: found.diagnosis,
    })
}

/// The robot as it stands in each further log, and in rows on `elsewhere` of the log at hand, which
/// are a log of their own.
fn stands<'a>(
    request: &Request,
    model: &Model,
    prior: &Prior,
    elsewhere: impl Iterator<Item = &'a String>,
) -> Result<Vec<(Experiment, Model)>, Error> {
    let further = request.then.iter();
    let further = further.map(|log| stand(request, model.support(), log));
    let elsewhere = elsewhere.map(|link| {
        let model = request.robot.model(link, request.snapping, None)?;
        Ok((Experiment::OtherFoot, model))
    });
    let stands = further.chain(elsewhere).map(|stand| {
        let (experiment, own) = stand?;
        Ok((experiment, prior.seen_from(model, &own).expected(own)))
    });
    stands.collect()
}

/// A block of each of `stands`, beside the log `samples` with its postures `data`.
///
/// # Errors
/// What is wrong with a log; one whose rows are those of another.
fn further_blocks<'m>(
    request: &Request,
    (model, prior): (&Model, &Prior),
    (samples, data): (&Samples, &Postures),
    stands: &'m [(Experiment, Model)],
    watch: &mut dyn Watch,
) -> Result<Vec<(Block<'m>, Experiment)>, Error> {
    let hash = |postures: &Postures| postures.summary.as_ref().map(|found| found.hash.clone());
    let mut before = vec![(hash(data), rows_hash(data))];
    if let Some(own) = &before[0].0 {
        prior.check_other(request.log.name(), own)?;
    }
    let mut room = ROOM.saturating_sub(samples.size());
    let mut blocks = Vec::new();
    for (at, (experiment, there)) in stands.iter().enumerate() {
        let prior = prior.seen_from(model, there);
        let further = request.then.get(at).map(|log| {
            let options = reading(request, Some(there.support().to_string()));
            let own = Samples::read(log, &request.robot.description, &options, room, watch)?;
            let (own, rows) = health::screen(own, (&request.robot, there), request.noise, watch)?;
            for finding in rows {
                watch.warning(&format!("{}: {}", log.name(), finding.sentence).into());
            }
            Ok::<Samples, Error>(own)
        });
        let further = further.transpose()?;
        let source = further.as_ref().unwrap_or(samples);
        let mut postures = take(request, there, &prior, (source, request.motion), watch)?;
        let mut closure = None;
        if let Some(source) = &further {
            room = room.saturating_sub(source.size());
            let own = (hash(&postures), rows_hash(&postures));
            let same = |other: &(Option<String>, u64)| {
                own.1 == other.1 || own.0.is_some() && own.0 == other.0
            };
            if before.iter().any(same) {
                return Err(Error::log(
                    source.log.name(),
                    None,
                    "has the same rows as a log before it, which would count twice; give the log \
                     of the experiment",
                ));
            }
            before.push(own);
            warn_of_left_out(source, &postures, watch);
            let feet = Feet::default();
            closure = soles_of(&feet, &source.sidecar, there, &mut postures, watch)?;
        }
        let block = Block::new(there, postures, closure, &request.effects);
        blocks.push((block, *experiment));
    }
    Ok(blocks)
}

/// What a diagnosis finds wrong with the data of its log before any hypothesis.
///
/// # Errors
/// As [`diagnose`].
pub fn look(request: &Request, watch: &mut dyn Watch) -> Result<Vec<Finding>, Error> {
    check_noise(request)?;
    let (samples, model) = read(request, watch)?;
    let prior = masses_before(request, &model, watch)?;
    let model = prior.expected(model);
    let on = (&*request.robot, &model);
    let (samples, rows) = health::screen(samples, on, request.noise, watch)?;
    let data = take(request, &model, &prior, (&samples, request.motion), watch)?;
    let (_, health) = examined(request, &model, (&data, request.motion));
    Ok(health.after(rows).findings)
}

/// What is known of the masses before the log: what logs of the healthy robot tell, or the prior
/// alone.
fn masses_before(request: &Request, model: &Model, watch: &mut dyn Watch) -> Result<Prior, Error> {
    if request.healthy.is_empty() {
        return request.prior.of(model);
    }
    let common = FitRequest {
        robot: Some(Arc::clone(&request.robot)),
        snapping: request.snapping,
        noise: request.noise,
        offset: request.offset,
        motion: request.motion,
        stays: request.stays,
        prior: prior_of_healthy(request),
        ..FitRequest::default()
    };
    let mut parts = Vec::new();
    for log in &request.healthy {
        let own = FitRequest {
            logs: vec![log.clone()],
            support: Some(support_of_log(request, log, model.support())),
            angles: request.angles,
            ..common.clone()
        };
        let alone = request.healthy.len() == 1;
        parts.push((log.name().to_string(), gather_as(&own, alone, watch)?));
    }
    let of_parts = FitRequest {
        parts,
        support: Some(model.support().to_string()),
        ..common
    };
    let healthy = fit(&of_parts, watch)?;
    let names = names(request.healthy.iter());
    let fitted = Fitted::new(&healthy.model_file, model, &names)?;
    Ok(Prior::Fitted(Box::new(fitted)))
}

/// Names of logs as one.
fn names<'l>(logs: impl Iterator<Item = &'l LogSource>) -> String {
    let names = logs.map(LogSource::file_name);
    names.collect::<Vec<_>>().join(" + ")
}

/// The link on the ground in another log: as it says itself, else that of the log at hand.
fn support_of_log(request: &Request, log: &LogSource, support: &str) -> String {
    let options = reading(request, None);
    let first = PostureReader::of_robot(log, &request.robot.description, &options);
    let first = first.and_then(PostureReader::first_support).ok().flatten();
    let first = first.filter(|link| !link.is_empty());
    first.map_or_else(|| support.to_string(), |link| link.to_string())
}

/// How far the masses of a healthy robot may be off: held tight, they would leave nothing to learn.
fn prior_of_healthy(request: &Request) -> PriorChoice {
    match &request.prior {
        PriorChoice::Tight => PriorChoice::Cad,
        other => other.clone(),
    }
}

/// Warn of a log of the healthy robot that shows an effect by itself: what it shares with the other
/// log is not found by comparing the two.
fn check_healthy(request: &Request, support: &str, watch: &mut dyn Watch) -> Result<(), Error> {
    for log in &request.healthy {
        let support = support_of_log(request, log, support);
        let own = Request {
            log: log.clone(),
            support: Some(support),
            then: Vec::new(),
            healthy: Vec::new(),
            prior: prior_of_healthy(request),
            feet: Feet::default(),
            next_file: None,
            corrected_urdf: false,
            view: false,
            ..request.clone()
        };
        let found = diagnose(&own, watch)?.diagnosis;
        let shown = match (found.verdict, found.steps.first()) {
            (Verdict::Named | Verdict::Class, Some(step)) => match step.target.as_str() {
                "-" => format!("shows `{}`", step.effect),
                target => format!("shows `{}:{target}`", step.effect),
            },
            (Verdict::Unexplained, _) => "shows what nothing known explains".to_string(),
            _ => continue,
        };
        let warning = format!(
            "{}: this log of the healthy robot {shown} itself; what both logs share is not found: \
             diagnose it alone first",
            log.name()
        );
        watch.warning(&warning.into());
    }
    Ok(())
}

/// The log, and the robot on the link on the ground: as was asked, else as the sidecar says, else
/// that of the first row.
fn read(request: &Request, watch: &mut dyn Watch) -> Result<(Samples, Model), Error> {
    let (robot, log) = (&request.robot, &request.log);
    let (sidecar, odd) = log.sidecar()?;
    let model = |support: &str| robot.model(support, request.snapping, None);
    let named = request.support.as_ref().or(sidecar.support.as_ref());
    let known = named.map(|support| model(support)).transpose()?;
    let options = reading(request, named.cloned());
    let samples = Samples::read(log, &robot.description, &options, ROOM, watch)?;
    let model = match known {
        Some(known) => known,
        None => {
            let first = samples.first_support()?.filter(|link| !link.is_empty());
            model(&first.ok_or_else(|| robot.no_support(&odd))?)?
        }
    };
    Ok((samples, model))
}

/// What is wrong with postures, and these compared with the ZMP where that alone shows a stuck
/// encoder.
fn examined(
    request: &Request,
    model: &Model,
    (data, motion): (&Postures, MotionModel),
) -> (Postures, Health) {
    let examine = |data: &Postures| health::examine(&request.robot, model, request.snapping, data);
    let health = examine(data);
    if health.findings.is_empty()
        && motion == MotionModel::Auto
        && let Some(moving) = motion::anyway(data, model)
    {
        let health = examine(&moving);
        if health.stuck.is_some() {
            return (moving, health);
        }
    }
    (data.clone(), health)
}

fn check_noise(request: &Request) -> Result<(), Error> {
    let of = |setting: Setting, value: f64, least: f64| match (least..=1.0).contains(&value) {
        true => Ok(()),
        false => Err(Error::request(message![
            setting,
            format!(" {value:e}: give metres, {least:e} to 1")
        ])),
    };
    of(Setting::Noise, request.noise.unwrap_or(1.0), 1e-9)?;
    of(Setting::Floor, request.floor, 0.0)
}

/// How a log is read whose rows stand on `support` where they do not say.
fn reading(request: &Request, support: Option<String>) -> Options {
    let links = request.robot.description.links.iter();
    Options {
        angles: request.angles,
        readings: Readings::Required,
        links: links.map(|link| link.name.clone()).collect(),
        support,
        any_unit: true,
        stays: request.stays,
        soles: Some(Places::of(&request.robot, request.snapping)),
        both_feet: request.feet.said(),
        ..Options::default()
    }
}

/// A log on the model's support; its warnings are passed on.
fn take(
    request: &Request,
    model: &Model,
    prior: &Prior,
    (samples, motion): (&Samples, MotionModel),
    watch: &mut dyn Watch,
) -> Result<Postures, Error> {
    let mut data = Postures::read(samples, model, (request.noise, request.floor), watch)?;
    motion::account(&mut data, model, prior, motion);
    for warning in &data.warnings {
        watch.warning(warning);
    }
    Ok(data)
}

/// Warn of rows that stand on another link where they are no log of their own.
fn warn_of_left_out(samples: &Samples, postures: &Postures, watch: &mut dyn Watch) {
    for (link, rows) in &postures.elsewhere {
        let warning = format!(
            "{}: {rows} rows stand on `{link}` and are left out; give them as a file of their own",
            samples.log.name()
        );
        watch.warning(&warning.into());
    }
}

/// What a further log is of, and the robot as it stands there.
fn stand(request: &Request, first: &str, log: &LogSource) -> Result<(Experiment, Model), Error> {
    let (sidecar, _) = log.sidecar()?;
    let file = || -> String {
        match log.path() {
            Some(path) => Sidecar::of_log(path).display().to_string(),
            None => log.name().to_string(),
        }
    };
    let support = &*support_of_log(request, log, first);
    let experiment = match &sidecar.experiment {
        Some(name) => experiment::of_log(name).ok_or_else(|| {
            let message = message![
                format!(
                    "experiment `{name}` cannot be taken together with another log; known are \
                     postures, turned, other_foot, raw_cells, untouched. Diagnose it alone with "
                ),
                Setting::Data
            ];
            Error::log(file(), None, message)
        })?,
        None if support != first => Experiment::OtherFoot,
        None => Experiment::Postures,
    };
    if (experiment == Experiment::OtherFoot) == (support == first) {
        let name = experiment.name();
        let message = format!(
            "experiment `{name}` on `{support}`, and the first log is on `{first}`; mend \
             `experiment` or `support`"
        );
        return Err(Error::log(file(), None, message));
    }
    let model = request.robot.model(support, request.snapping, None)?;
    Ok((experiment, model))
}

/// The model file, with all logs that it was found in.
fn with_data(request: &Request, problem: &Problem, found: &Explained) -> ModelFile {
    let mut file = model_file(problem, &found.written);
    if request.motion == MotionModel::Off {
        file.motion = Some(MotionCounted::Static);
    }
    let logs = [&request.log].into_iter().chain(&request.then);
    file.data = logs
        .zip(problem.blocks.iter())
        .filter_map(|(log, block)| {
            let summary = block.data.summary.as_ref()?;
            Some(DataUsed {
                file: log.file_name().to_string(),
                hash: summary.hash.clone(),
                rows: summary.rows,
                times: summary.times,
            })
        })
        .collect();
    file
}

/// First and last time of all logs, s.
fn times(problem: &Problem) -> Option<[f64; 2]> {
    let blocks = problem.blocks.iter();
    let known = blocks.filter_map(|block| block.data.summary.as_ref()?.times);
    known.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}
