//! Effects that the list does not have: functions at a site, hidden in a virtual robot.
//!
//! A log of postures a few seconds apart is diagnosed; the model that is written is judged on
//! postures that it has not seen, without noise, over the same time.

use std::f64::consts::TAU;
use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_identify::diagnose::{self, Diagnosis, Verdict};
use sesc_identify::logs::LogSource;
use sesc_identify::predict::{self, Predictions};
use sesc_identify::robot::Stance;
use sesc_model::{ModelFile, Quantity};
use sesc_reference::World;

use super::Failure;
use super::bought::bought;
use crate::recording::Recording;
use crate::stage::Stage;

/// Postures of the log, of the healthy one, and of those that judge.
const POSTURES: usize = 120;
/// Those that say how large an effect is.
const FEW: usize = 24;
const HEALTHY: usize = 200;
const JUDGED: usize = 500;
/// Between postures, s.
const APART_S: f64 = 4.0;
/// Deviation of a posture's mean reading on the OP2, m.
const NOISE_M: f64 = 0.0005;

/// What is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// An encoder that errs once a turn.
    Eccentricity,
    /// An encoder that errs a few times a turn.
    Ripple,
    /// A joint that follows another.
    Coupling,
    /// An error by the square of the angle.
    Curvature,
    /// A joint that stays behind.
    Hysteresis,
    /// An encoder that drifts.
    Drift,
    /// An encoder that slips once.
    Slip,
    /// A joint that errs from an angle on.
    Stop,
    /// A spring by the root of its moment.
    Hardening,
    /// A spring by the square of its moment.
    Softening,
    /// A joint that gives way to the moment at another.
    CrossCompliance,
    /// Readings by their square.
    Nonlinearity,
    /// Readings that follow those of the other axis.
    Crosstalk,
    /// Readings with a kink.
    Kink,
    /// A zero that decays.
    Warmup,
    /// Ground that gives way.
    SoftGround,
    /// A product of two angles; this and what follows is no function of the table.
    Product,
    /// An error about one angle.
    Bump,
    /// An error that saturates.
    Saturating,
    /// An encoder of coarse steps.
    Stepped,
    /// Readings that err about a place.
    SensorBump,
    /// Readings that saturate.
    SensorSaturating,
}

impl Kind {
    /// All that functions of the table are, then those that none is.
    pub const ALL: [Kind; 22] = [
        Kind::Eccentricity,
        Kind::Ripple,
        Kind::Coupling,
        Kind::Curvature,
        Kind::Hysteresis,
        Kind::Drift,
        Kind::Slip,
        Kind::Stop,
        Kind::Hardening,
        Kind::Softening,
        Kind::CrossCompliance,
        Kind::Nonlinearity,
        Kind::Crosstalk,
        Kind::Kink,
        Kind::Warmup,
        Kind::SoftGround,
        Kind::Product,
        Kind::Bump,
        Kind::Saturating,
        Kind::Stepped,
        Kind::SensorBump,
        Kind::SensorSaturating,
    ];

    /// Whether a function of the table is its form.
    pub fn is_in_table(self) -> bool {
        Kind::ALL[..16].contains(&self)
    }

    /// Its name in diagnoses, where it has one.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Eccentricity => "encoder_eccentricity",
            Kind::Ripple => "encoder_ripple",
            Kind::Coupling => "joint_coupling",
            Kind::Curvature => "joint_curvature",
            Kind::Hysteresis => "joint_hysteresis",
            Kind::Drift => "joint_drift",
            Kind::Slip => "joint_slip",
            Kind::Stop => "joint_stop",
            Kind::Hardening => "spring_hardening",
            Kind::Softening => "spring_softening",
            Kind::CrossCompliance => "cross_compliance",
            Kind::Nonlinearity => "sensor_nonlinearity",
            Kind::Crosstalk => "sensor_crosstalk",
            Kind::Kink => "sensor_kink",
            Kind::Warmup => "sensor_warmup",
            Kind::SoftGround => "soft_ground",
            _ => "-",
        }
    }

    fn is_of_joint(self) -> bool {
        !self.is_of_sensor() && self != Kind::SoftGround
    }

    fn is_of_moments(self) -> bool {
        matches!(
            self,
            Kind::Hardening | Kind::Softening | Kind::CrossCompliance
        )
    }

    fn is_of_sensor(self) -> bool {
        matches!(
            self,
            Kind::Nonlinearity
                | Kind::Crosstalk
                | Kind::Kink
                | Kind::Warmup
                | Kind::SensorBump
                | Kind::SensorSaturating
        )
    }

    /// Unknowns of its form.
    fn unknowns(self) -> f64 {
        match self {
            Kind::Eccentricity
            | Kind::Ripple
            | Kind::Slip
            | Kind::Stop
            | Kind::Kink
            | Kind::Warmup => 2.0,
            _ => 1.0,
        }
    }
}

/// An effect with its places and its shape.
#[derive(Debug, Clone, Copy)]
struct Hidden {
    kind: Kind,
    /// Joint, or axis.
    at: usize,
    other: usize,
    /// Where it begins, as a part of the range.
    from: f64,
    phase: f64,
    waves: f64,
}

/// What the log has of a posture beside its joints.
#[derive(Debug, Clone, Copy)]
struct Now {
    /// Part of the log that is over.
    part: f64,
    /// From which side the joint came.
    side: f64,
}

impl Hidden {
    /// How far a joint is moved, of one that bears `moments`, over its size.
    fn of_joint(self, q: &[f64], moments: &[f64], now: Now) -> f64 {
        let begins = 0.4 * (self.from - 0.5);
        let (q, other) = (q[self.at], q[self.other]);
        match self.kind {
            Kind::Eccentricity => (q + self.phase).sin(),
            Kind::Ripple => (self.waves * q + self.phase).sin(),
            Kind::Coupling => other,
            Kind::Curvature => q * q,
            Kind::Hysteresis => now.side,
            Kind::Drift => now.part,
            Kind::Slip => f64::from(u8::from(now.part > self.from)),
            Kind::Stop => (q - begins).max(0.0),
            Kind::Hardening => moments[self.at].signum() * moments[self.at].abs().sqrt(),
            Kind::Softening => moments[self.at] * moments[self.at].abs(),
            Kind::CrossCompliance => moments[self.other],
            Kind::Product => q * other,
            Kind::Bump => (-(6.0 * (q - begins)).powi(2)).exp(),
            Kind::Saturating => (8.0 * (q - begins)).tanh(),
            _ => (5.0 * q).round() / 5.0 - q,
        }
    }

    /// What is added to a reading, both in half lengths of a sole, over its size.
    fn of_sensor(self, reading: [f64; 2], now: Now) -> f64 {
        let (along, across) = (reading[self.at], reading[1 - self.at]);
        let begins = 0.5 * (self.from - 0.5);
        match self.kind {
            Kind::Nonlinearity => along * along,
            Kind::Crosstalk => across,
            Kind::Kink => (along - begins).max(0.0),
            Kind::Warmup => (-now.part / 0.25).exp(),
            Kind::SensorBump => (-(4.0 * (along - begins)).powi(2)).exp(),
            _ => (4.0 * (along - begins)).tanh(),
        }
    }
}

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Found {
    /// What is hidden and what is said.
    pub said: String,
    /// The steps act where it is hidden, and nowhere else.
    pub place: bool,
    /// They do, or an explanation that the data cannot tell apart does.
    pub listed: bool,
    /// They have its name, or an explanation that the data cannot tell apart has.
    pub form: bool,
    /// CoP and CoM gaps on fresh postures over those of CAD.
    pub cop: f64,
    /// That of the CoM; NaN where none of it is hidden.
    pub com: f64,
    /// Whether the CoM is further off than 1.05 times CAD's and three deviations that the effects
    /// of the model state.
    pub worse: bool,
    /// The goal for them: 6 %, or what noise allows.
    pub goal: f64,
    /// Of the diagnosis.
    pub seconds: f64,
    /// Unexplained, or nothing found.
    pub silent: bool,
}

struct Bench<'s> {
    stage: &'s Stage,
    world: World,
    joints: Vec<String>,
}

impl Bench<'_> {
    /// Readings and CoMs of postures in their order.
    fn read(&self, q: &[Vec<f64>], hidden: Option<(Hidden, f64)>) -> Vec<([f64; 2], [f64; 3])> {
        let foot = 0.03 * self.stage.size;
        let bent = hidden.map(|(own, size)| self.bent(own, size, foot));
        let world = bent.as_ref().unwrap_or(&self.world);
        let at = |k: usize| {
            let mut q_true = q[k].clone();
            let mut added = [0.0; 2];
            if let Some((own, size)) = hidden {
                let side = match (k, own.kind.is_of_joint()) {
                    (0, _) | (_, false) => 0.0,
                    _ => (q[k][own.at] - q[k - 1][own.at]).signum(),
                };
                let now = Now {
                    part: k as f64 / (q.len() - 1) as f64,
                    side,
                };
                if own.kind.is_of_sensor() {
                    let reading = world.cop(&q_true).map(|x| x / foot);
                    added[own.at] = size * foot * own.of_sensor(reading, now);
                } else if own.kind.is_of_joint() && !own.kind.is_of_moments() {
                    q_true[own.at] += size * own.of_joint(&q[k], &[], now);
                }
            }
            let cop = world.cop(&q_true);
            (
                [cop[0] + added[0], cop[1] + added[1]],
                world.com(&q_true).into(),
            )
        };
        (0..q.len()).map(at).collect()
    }

    /// The robot with what depends on where it ends: moments, and the pressure on the ground.
    fn bent(&self, own: Hidden, size: f64, foot: f64) -> World {
        let world = self.world.clone();
        match own.kind {
            Kind::SoftGround => world.ground_function(own.at, move |cop| size * cop[own.at] / foot),
            kind if kind.is_of_moments() => {
                let now = Now {
                    part: 0.0,
                    side: 0.0,
                };
                let error = move |q: &[f64], moments: &[f64]| size * own.of_joint(q, moments, now);
                let bent = world.joint_function(&self.joints[own.at], error);
                bent.expect("a joint of the robot")
            }
            _ => world,
        }
    }

    /// A place where an effect of a size that robots have is seen with a χ² of 100 to 20,000 in
    /// `q`, its size there, and that χ².
    fn hide(
        &self,
        kind: Kind,
        q: &[Vec<f64>],
        sigma: f64,
        random: &mut ChaCha8Rng,
    ) -> ((Hidden, f64), f64) {
        // A few postures in a row: effects may depend on the one before.
        let few = &q[..FEW];
        let sound = self.read(few, None);
        loop {
            let wanted = 10_f64.powf(random.random_range(2.0..4.3));
            let own = Hidden {
                kind,
                at: match kind.is_of_joint() {
                    true => random.random_range(0..self.joints.len()),
                    false => random.random_range(0..2),
                },
                other: random.random_range(0..self.joints.len()),
                from: random.random_range(0.25..0.75),
                phase: TAU * random.random::<f64>(),
                waves: [2.0, 3.0, 4.0, 6.0, 8.0][random.random_range(0..5)],
            };
            if own.other == own.at {
                continue;
            }
            let chi2 = |size: f64| -> f64 {
                let bent = self.read(few, Some((own, size)));
                let gaps = bent.iter().zip(&sound);
                let gaps = gaps.flat_map(|(a, b)| [0, 1].map(|axis| a.0[axis] - b.0[axis]));
                let all: f64 = gaps.map(|gap| (gap / sigma).powi(2)).sum();
                all * POSTURES as f64 / FEW as f64
            };
            let mut size = 1e-3;
            for _ in 0..3 {
                let now = chi2(size);
                if !(now > 0.0 && now.is_finite()) {
                    break;
                }
                size *= (wanted / now).sqrt();
                if size > 0.5 {
                    break;
                }
            }
            // No robot errs by more than 10° or a third of its sole.
            let largest = if kind.is_of_joint() { 0.17 } else { 0.33 };
            let is_near = |chi2: f64| (0.8..1.25).contains(&(chi2 / wanted));
            if size < largest && is_near(chi2(size)) {
                return ((own, size), wanted);
            }
        }
    }
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = values.collect();
    (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt()
}

/// A log with an effect hidden, and postures without noise that judge what is made of it.
#[derive(Debug)]
pub struct Trial {
    /// Joint or axis at which the effect acts; none for a sound robot.
    pub place: Option<String>,
    /// Another joint that it depends on.
    pub other: Option<String>,
    /// χ² of the effect in the log.
    pub chi2: f64,
    /// Deviation of a reading, m.
    pub noise_m: f64,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// The log: joint positions and CoP.
    pub log: Vec<(Vec<f64>, [f64; 2])>,
    /// A log of the healthy robot, of one as it is bought.
    pub healthy: Vec<(Vec<f64>, [f64; 2])>,
    /// Fresh postures over the same time, with the true CoP and CoM.
    pub fresh: Vec<(Vec<f64>, [f64; 2], [f64; 3])>,
    hidden: Option<(Hidden, f64)>,
}

impl Trial {
    /// Hide a kind of effect in the robot of `stage`, none for a sound robot; in one as it is
    /// bought, with a log of when it was healthy, where `is_bought`.
    ///
    /// # Errors
    /// Where there is no such robot.
    pub fn new(
        stage: &Stage,
        kind: Option<Kind>,
        is_bought: bool,
        seed: u64,
    ) -> Result<Trial, Failure> {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let cad = stage.world();
        let world = match is_bought {
            true => World::new(&bought(&stage.robot, random), stage.support)?,
            false => cad.clone(),
        };
        let bench = Bench {
            stage,
            world,
            joints: stage.joint_names(),
        };
        let sigma = NOISE_M * stage.size;
        let q = stage.balanced(POSTURES, random);
        let (hidden, chi2) = match kind {
            Some(kind) => {
                let (hidden, chi2) = bench.hide(kind, &q, sigma, random);
                (Some(hidden), chi2)
            }
            None => (None, 0.0),
        };
        let mut noisy = |q: Vec<Vec<f64>>, hidden| -> Vec<(Vec<f64>, [f64; 2])> {
            let read = bench.read(&q, hidden);
            let mut gauss = || -> f64 { StandardNormal.sample(random) };
            let postures = q.into_iter().zip(read);
            postures
                .map(|(q, (cop, _))| (q, cop.map(|x| x + sigma * gauss())))
                .collect()
        };
        let log = noisy(q, hidden);
        let healthy = match is_bought {
            true => stage.balanced(HEALTHY, &mut ChaCha8Rng::seed_from_u64(!seed)),
            false => Vec::new(),
        };
        let healthy = noisy(healthy, None);
        let fresh = stage.balanced(JUDGED, &mut ChaCha8Rng::seed_from_u64(seed ^ 0x5eed));
        let truth = bench.read(&fresh, hidden);
        let fresh = fresh.into_iter().zip(truth);
        Ok(Trial {
            place: hidden.map(|(own, _)| match own.kind.is_of_joint() {
                true => bench.joints[own.at].clone(),
                false => ["x", "y"][own.at].to_owned(),
            }),
            other: hidden.map(|(own, _)| bench.joints[own.other].clone()),
            chi2,
            noise_m: sigma,
            log,
            healthy,
            fresh: fresh.map(|(q, (cop, com))| (q, cop, com)).collect(),
            joints: bench.joints,
            hidden,
        })
    }

    /// Seconds between postures of the log, and of the fresh ones.
    pub fn apart_s(&self) -> [f64; 2] {
        let over = APART_S * (POSTURES - 1) as f64 / (JUDGED - 1) as f64;
        [APART_S, over]
    }

    /// Rows of a log as a table.
    fn table<'r>(
        &self,
        rows: impl Iterator<Item = (&'r Vec<f64>, &'r [f64; 2])>,
        apart_s: f64,
    ) -> LogSource {
        let (q, cop): (Vec<_>, Vec<_>) = rows.map(|(q, cop)| (q.clone(), *cop)).unzip();
        let count = |by: f64| (0..q.len()).map(|k| by * k as f64).collect();
        let recording = Recording {
            joints: self.joints.clone(),
            t: count(apart_s),
            pose: Some(count(1.0)),
            q,
            cop,
        };
        super::log(&recording, true)
    }
}

/// How far masses within CAD's tolerances move the CoM of a sound robot, in noises of a reading.
const OF_MASSES: f64 = 0.3;

/// Diagnose the log of a [`Trial`].
///
/// # Errors
/// Where the log cannot be taken or diagnosed.
pub fn examine(
    stage: &Stage,
    kind: Option<Kind>,
    is_bought: bool,
    seed: u64,
) -> Result<Found, Failure> {
    let trial = Trial::new(stage, kind, is_bought, seed)?;
    let hidden = trial.hidden;
    let [apart_s, fresh_apart_s] = trial.apart_s();
    let rows = |rows: &[(Vec<f64>, [f64; 2])]| {
        let rows = rows.iter().map(|(q, cop)| (q, cop));
        trial.table(rows, apart_s)
    };
    let robot = super::robot(stage)?;
    let mut request = diagnose::Request::new(Arc::clone(&robot), rows(&trial.log));
    request.support = Some(stage.support.into());
    request.noise = Some(trial.noise_m);
    if is_bought {
        request.healthy = vec![rows(&trial.healthy)];
    }
    let begun = std::time::Instant::now();
    let report = diagnose::diagnose(&request, &mut ())?;
    let seconds = begun.elapsed().as_secs_f64();
    let file = ModelFile::parse(&toml::to_string(&report.model_file)?, "model.toml")?;
    let predicted = |file: Option<ModelFile>| -> Result<Predictions, Failure> {
        let mut stance = Stance::new(Arc::clone(&robot)).on(stage.support);
        if let Some(file) = file {
            stance = stance.with_parameters(file)?;
        }
        let fresh = trial.fresh.iter().map(|(q, cop, _)| (q, cop));
        let request = predict::Request::new(stance, trial.table(fresh, fresh_apart_s));
        Ok(predict::predict(&request, &mut ())?)
    };
    let gaps = |found: &Predictions| {
        let cop = found.cop_m.iter().zip(&trial.fresh);
        let cop = rms(cop.flat_map(|(p, (_, y, _))| [p[0] - y[0], p[1] - y[1]]));
        let com = found.com_m.iter().zip(&trial.fresh);
        let com = rms(com.flat_map(|(p, (_, _, c))| [p[0] - c[0], p[1] - c[1]]));
        [cop, com]
    };
    let cad = predicted(None)?;
    let corrected = predicted(Some(file.clone()))?;
    let (before, after) = (gaps(&cad), gaps(&corrected));
    // How far the CoM moves as each parameter of an effect does by its deviation.
    let mut squares = 0.0;
    for (k, effect) in file.effects.iter().enumerate() {
        for (name, own) in &effect.parameters {
            let mut moved = file.clone();
            let value = own.value + own.std.unwrap_or(0.0);
            moved.effects[k].parameters.insert(
                name.clone(),
                Quantity {
                    value,
                    std: own.std,
                },
            );
            // What gives way no longer comes to rest there.
            let Ok(moved) = predicted(Some(moved)) else {
                continue;
            };
            let com = moved.com_m.iter().zip(&corrected.com_m);
            squares += rms(com.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]])).powi(2);
        }
    }
    // What the masses leave once they are known is none of the effect's.
    let of_kind = |kind: Kind| (0.06_f64).max(2.0 * (kind.unknowns() / trial.chi2).sqrt());
    let diagnosis = &report.diagnosis;
    Ok(Found {
        place: is_at(diagnosis, hidden.map(|own| own.0), &trial.joints),
        listed: is_listed(diagnosis, hidden.map(|own| own.0), &trial.joints),
        form: kind.is_some_and(|kind| has_form(diagnosis, kind)),
        said: format!(
            "{:?} {kind:?} {} chi2 {:.0}: {:?} {:?}, CoP {:.3} CoM {:.3}, {seconds:.2} s",
            stage.platform,
            hidden.map_or(String::new(), |(own, size)| format!(
                "{} ({}) {size:.4}",
                trial.place.as_deref().unwrap_or_default(),
                trial.joints[own.other]
            )),
            trial.chi2,
            diagnosis.verdict,
            diagnosis
                .indistinguishable
                .iter()
                .take(3)
                .collect::<Vec<_>>(),
            after[0] / before[0],
            after[1] / before[1],
        ),
        cop: after[0] / before[0],
        com: match kind {
            Some(kind) if !kind.is_of_joint() => f64::NAN,
            _ => after[1] / before[1],
        },
        worse: after[1] > 1.05 * before[1] + 3.0 * squares.sqrt() + OF_MASSES * trial.noise_m,
        goal: kind.map_or(f64::NAN, of_kind),
        seconds,
        silent: diagnosis.steps.is_empty() || diagnosis.verdict == Verdict::Unexplained,
    })
}

/// Whether the steps act where an effect is hidden, and nowhere else.
fn is_at(found: &Diagnosis, hidden: Option<Hidden>, joints: &[String]) -> bool {
    let steps = found.steps.iter().map(|step| (step.effect, &*step.target));
    act_at(&steps.collect::<Vec<_>>(), hidden, joints)
}

/// Whether the steps or an explanation of the class do.
fn is_listed(found: &Diagnosis, hidden: Option<Hidden>, joints: &[String]) -> bool {
    let mut groups = found.indistinguishable.iter().map(|group| {
        let labels = group.iter();
        let labels = labels.map(|label| label.split_once(':').unwrap_or((label, "-")));
        act_at(&labels.collect::<Vec<_>>(), hidden, joints)
    });
    is_at(found, hidden, joints) || groups.any(|own| own)
}

fn act_at(steps: &[(&str, &str)], hidden: Option<Hidden>, joints: &[String]) -> bool {
    let Some(own) = hidden else {
        return steps.is_empty();
    };
    let joint = &joints[own.at];
    let is_right = |(effect, target): &(&str, &str)| match own.kind {
        _ if *effect == "mass_distribution" => true,
        kind if kind.is_of_joint() => target == joint || target.starts_with(&format!("{joint},")),
        kind if kind.is_of_sensor() => effect.starts_with("sensor_"),
        _ => effect.contains("ground"),
    };
    let is_free = |(effect, _): &(&str, &str)| *effect == "mass_distribution";
    steps.iter().all(is_right) && !steps.iter().all(is_free)
}

fn has_form(found: &Diagnosis, kind: Kind) -> bool {
    let groups = found.indistinguishable.iter().flatten();
    let steps = found.steps.iter().map(|step| step.effect);
    let mut names = groups
        .map(|label| label.split(':').next().unwrap_or_default())
        .chain(steps);
    names.any(|name| name == kind.name())
}
