//! Posture logs of an ideal robot: uniform postures, or a motion through the joints' ranges,
//! and Gaussian CoP noise.
//!
//! # Motion
//!
//! A motion goes through the range of every joint:
//!
//! ```text
//! q_j(t) = m_j + a_j/2 Σ_k sin(ω_k t + φ_k)        two sines a joint, 0.05 to 0.25 Hz
//! ```
//!
//! `m_j ± a_j` is the joint's range. Velocities and accelerations are those of the sines.
//!
//! # Hidden effects
//!
//! A simulated robot may have effects, such as `joint_offset:r_knee=1.5deg`.
//!
//! ```text
//! EFFECT[:TARGET][=VALUE[UNIT][,VALUE[UNIT]…]]      values in the order of its parameters
//! ```
//!
//! A number without its unit that was hardly meant in rad, m or kg is refused.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_model::effects::{Catalog, EffectContext, Parameter, Unit};
use sesc_model::tree::Dof;
use sesc_model::{EffectRecord, Model, ModelFile, Quantity};

use crate::evaluate::{InLog, MotionPredictor, ReadingPredictor};
use crate::logs::{BLOCK, LogSource, PostureWriter, Row, Sidecar, Table, Written};
use crate::observations::approach::Approach;
use crate::observations::motion_use::MotionModel;
use crate::watch::{Watch, tell};
use crate::{Error, Setting, message};

/// Why a posture has no CoP.
const BEYOND: &str = "a drawn posture has no finite CoP: an angle is beyond 2^20 rad, where \
                      sines mean nothing, or an effect of the model file has a value that no \
                      robot has; give narrower joint limits or other values";

/// What is to be simulated.
#[derive(Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot on its support, with the parameters and effects it really has.
    pub model: Arc<Model>,
    /// Number of postures.
    pub poses: usize,
    /// The postures, `q[posture * dof + joint]`, rad or m; drawn unless given.
    pub postures: Option<Vec<f64>>,
    /// The numbers of the given postures, of which two that are equal are visits of one; from 0
    /// unless given.
    pub numbers: Option<Vec<i64>>,
    /// Draw revolute joints within ± this of zero and within their limits, rad; else
    /// within their limits.
    pub range: Option<f64>,
    /// Standard deviation of the CoP noise, m.
    pub noise: f64,
    /// Seed of postures and noise.
    pub seed: u64,
    /// Rows per second of a robot that moves, Hz; postures at rest unless given.
    pub rate: Option<f64>,
    /// Whether readings of a robot that moves are those of the ZMP.
    pub motion: MotionModel,
}

impl Request {
    /// A request for `poses` postures within the joint limits, without noise.
    pub fn new(model: impl Into<Arc<Model>>, poses: usize) -> Request {
        Request {
            model: model.into(),
            poses,
            postures: None,
            numbers: None,
            range: None,
            noise: 0.0,
            seed: 1,
            rate: None,
            motion: MotionModel::Auto,
        }
    }

    fn check(&self) -> Result<(), Error> {
        let refused = |setting: Setting, what: String| Err(Error::request(message![setting, what]));
        if let Some(range) = self.range.filter(|r| !(r.is_finite() && *r > 0.0)) {
            let what = format!(" {range}: give an angle above zero");
            return refused(Setting::Range, what);
        }
        let (dof, poses, noise) = (self.model.dof(), self.poses, self.noise);
        let given = self.postures.as_ref().map_or(dof * poses, Vec::len);
        if given != dof * poses {
            let what =
                format!(" {poses}: {given} positions given; one of each of {dof} joints is needed");
            return refused(Setting::Poses, what);
        }
        if let Some(rate) = self.rate.filter(|r| !(1e-3..=1e6).contains(r)) {
            let what = format!(" {rate}: give rows per second, 0.001 to 1e6");
            return refused(Setting::Rate, what);
        }
        if !(noise.is_finite() && noise >= 0.0) {
            let what = format!(" {noise}: give metres, zero or more");
            return refused(Setting::Noise, what);
        }
        Ok(())
    }

    /// Simulate posture by posture.
    fn run(
        &self,
        watch: &mut dyn Watch,
        mut take: impl FnMut(&Row) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let model = &*self.model;
        let mut simulator = Simulator::new(&model.tree.dofs, self.range, self.seed);
        let predictor = ReadingPredictor::new(model);
        let dof = model.dof();
        let mut approach = Approach::of(&model.tree.dofs);
        let numbers = self.numbers.as_ref().filter(|all| all.len() == self.poses);
        let waves = self.rate.map(|_| simulator.waves());
        let moves = waves.is_some() && matches!(self.motion, MotionModel::Auto);
        let zmp = moves.then(|| MotionPredictor::new(model));
        for start in (0..self.poses).step_by(BLOCK) {
            tell(watch, "simulating", start as u64, self.poses as u64)?;
            let n = BLOCK.min(self.poses - start);
            let time = |k: usize| self.rate.map_or(0.0, |rate| (start + k) as f64 / rate);
            let [mut q, mut rates, mut accelerations] = [(); 3].map(|()| Vec::new());
            match (&waves, &self.postures) {
                (Some(waves), _) => {
                    for moment in (0..n).flat_map(|k| waves.iter().map(move |w| w.at(time(k)))) {
                        q.push(moment[0]);
                        rates.push(moment[1]);
                        accelerations.push(moment[2]);
                    }
                }
                (None, Some(given)) => q = given[start * dof..(start + n) * dof].to_vec(),
                (None, None) => q = simulator.batch(n),
            }
            let motion = (&rates[..], &accelerations[..]);
            let shifts = zmp.as_ref().map(|zmp| zmp.shifts(&q, n, motion));
            let times = self.rate.map(|_| (0..n).map(time).collect());
            let postures = q.chunks_exact(dof.max(1));
            let log = InLog {
                since_s: times.unwrap_or_default(),
                sides: postures.flat_map(|q| approach.at(q).to_vec()).collect(),
            };
            let (_, readings) = predictor.run((&q, n), &log, &[], &shifts.unwrap_or_default());
            if readings.iter().any(|x| !x.is_finite()) {
                return Err(Error::request(BEYOND));
            }
            for (k, cop) in readings.chunks_exact(2).enumerate() {
                take(&Row {
                    pose: numbers.map_or((start + k) as i64, |numbers| numbers[start + k]),
                    t: time(k),
                    q: &q[k * dof..(k + 1) * dof],
                    cop: [cop[0], cop[1]].map(|x| x + simulator.gauss(self.noise)),
                    cop_std: [self.noise; 2],
                    ..Row::default()
                })?;
            }
        }
        Ok(())
    }

    /// Simulate into the log that `begin` begins.
    fn log(
        &self,
        watch: &mut dyn Watch,
        begin: impl FnOnce(&[Dof], Written) -> Result<PostureWriter, Error>,
    ) -> Result<(), Error> {
        self.check()?;
        let columns = Written {
            t: self.rate.is_some(),
            cop: true,
            cop_std: self.noise > 0.0,
            ..Written::default()
        };
        let mut log = begin(&self.model.tree.dofs, columns)?;
        self.run(watch, |row| log.row(row))?;
        log.finish(&self.sidecar()).map(drop)
    }

    fn sidecar(&self) -> Sidecar {
        Sidecar {
            robot: Some(self.model.tree.robot.clone()),
            support: Some(self.model.support().to_string()),
            ..Sidecar::default()
        }
    }
}

/// A simulated log in memory, as a file of it would be read.
///
/// ```
/// use sesc_identify::robot::Robot;
/// use sesc_identify::simulate::{Request, simulate};
/// use sesc_identify::robot::Stance;
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <mass value='2'/></inertial></link><joint name='hip' type='revolute'>\
/// #   <parent link='foot'/><child link='top'/><origin xyz='0.1 0 1'/><axis xyz='0 1 0'/>\
/// #   <limit lower='-1' upper='1'/></joint></robot>";
/// let robot = Robot::parse(urdf, "pole.urdf")?;
/// let mut request = Request::new(Stance::new(robot).on("foot").model()?, 100);
/// request.noise = 0.001;
/// let log = simulate(&request, &mut ())?;
/// assert_eq!(log.sidecar()?.0.support.as_deref(), Some("foot"));
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// A request that makes no sense.
pub fn simulate(request: &Request, watch: &mut dyn Watch) -> Result<LogSource, Error> {
    request.check()?;
    let dofs = &request.model.tree.dofs;
    let mut poses = Vec::with_capacity(request.poses);
    let mut times = Vec::new();
    let mut columns = vec![Vec::with_capacity(request.poses); dofs.len() + 2];
    request.run(watch, |row| {
        poses.push(row.pose);
        times.push(row.t);
        let numbers = row.q.iter().chain(&row.cop);
        for (column, x) in columns.iter_mut().zip(numbers) {
            column.push(*x);
        }
        Ok(())
    })?;
    let mut table = Table::new("simulation").integers("pose", poses);
    if request.rate.is_some() {
        table = table.numbers("t", times);
    }
    let names = dofs.iter().map(|dof| dof.joint.as_str());
    for (name, column) in names.chain(["cop_x", "cop_y"]).zip(columns) {
        table = table.numbers(name, column);
    }
    if request.noise > 0.0 {
        for name in ["cop_x_std", "cop_y_std"] {
            table = table.numbers(name, vec![request.noise; request.poses]);
        }
    }
    Ok(LogSource::from(table).with_sidecar(request.sidecar()))
}

/// Simulate a log of any length into the file at `path`; gives back where its sidecar is.
///
/// ```
/// use sesc_identify::robot::Robot;
/// use sesc_identify::simulate::{Request, write};
/// use sesc_identify::robot::Stance;
/// # let urdf = "<robot name='rod'><link name='foot'/>\
/// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
/// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
/// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
/// #     </robot>";
/// let model = Stance::new(Robot::parse(urdf, "rod.urdf")?).on("foot").model()?;
/// let mut request = Request::new(model, 30);
/// request.noise = 0.0005;
/// # let folder = std::env::temp_dir().join(format!("sesc-doc-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).unwrap();
/// let sidecar = write(&request, &folder.join("rod.csv"), &mut ())?;
/// assert!(sidecar.ends_with("rod.csv.toml"));
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// A request that makes no sense, a file that cannot be written.
pub fn write(request: &Request, path: &Path, watch: &mut dyn Watch) -> Result<PathBuf, Error> {
    request.log(watch, |dofs, columns| {
        PostureWriter::create(path, dofs, columns)
    })?;
    Ok(Sidecar::path(path))
}

/// Simulate a log of any length as CSV on a stream, which `name` stands for in messages; what
/// its sidecar would say is left to the caller.
///
/// # Errors
/// A request that makes no sense, a stream that takes nothing.
pub fn stream(
    request: &Request,
    name: &str,
    to: impl std::io::Write + Send + 'static,
    watch: &mut dyn Watch,
) -> Result<(), Error> {
    request.log(watch, |dofs, columns| {
        PostureWriter::stream(name, to, dofs, columns)
    })
}

/// Seeded postures and noise; the same numbers on every machine.
pub struct Simulator {
    postures: ChaCha8Rng,
    noise: ChaCha8Rng,
    ranges: Vec<(f64, f64)>,
}

impl Simulator {
    /// Postures uniform within the limits, and within ±`range` rad of zero
    /// where one is given (revolute joints only).
    pub fn new(dofs: &[Dof], range: Option<f64>, seed: u64) -> Simulator {
        // Two streams: more noise draws never change the postures.
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        noise.set_stream(1);
        Simulator {
            postures: ChaCha8Rng::seed_from_u64(seed),
            noise,
            ranges: dofs.iter().map(|dof| narrowed(dof, range)).collect(),
        }
    }

    /// A motion through the ranges, joint by joint.
    fn waves(&mut self) -> Vec<Wave> {
        let mut draw = || self.postures.random::<f64>();
        let wave = |&(lower, upper): &(f64, f64)| Wave {
            middle: 0.5 * (lower + upper),
            amplitude: 0.25 * (upper - lower),
            sines: [(); 2].map(|()| {
                let hertz = 0.05 + (0.25 - 0.05) * draw();
                [TAU * hertz, TAU * draw()]
            }),
        };
        self.ranges.iter().map(wave).collect()
    }

    /// The next posture, rad or m.
    pub fn posture(&mut self) -> Vec<f64> {
        let mut draw = || self.postures.random::<f64>();
        let ranges = self.ranges.iter();
        let draws = ranges.map(|(lower, upper)| lower + (upper - lower) * draw());
        draws.collect()
    }

    /// The next `count` postures, one after the other.
    pub fn batch(&mut self, count: usize) -> Vec<f64> {
        (0..count).flat_map(|_| self.posture()).collect()
    }

    /// Gaussian noise of standard deviation `std`.
    pub fn gauss(&mut self, std: f64) -> f64 {
        Normal::new(0.0, 1.0).map_or(0.0, |normal| std * normal.sample(&mut self.noise))
    }
}

/// The limits, cut to ±range; a joint whose limits exclude that keeps its own.
fn narrowed(dof: &Dof, range: Option<f64>) -> (f64, f64) {
    let range = range.filter(|_| !dof.prismatic).unwrap_or(f64::INFINITY);
    let narrow = (dof.lower.max(-range), dof.upper.min(range));
    if narrow.0 < narrow.1 {
        narrow
    } else {
        (dof.lower, dof.upper)
    }
}

/// How a joint moves.
struct Wave {
    middle: f64,
    amplitude: f64,
    /// rad/s and rad of each sine.
    sines: [[f64; 2]; 2],
}

impl Wave {
    /// Position, velocity and acceleration `t` seconds after the start.
    fn at(&self, t: f64) -> [f64; 3] {
        let [mut q, mut rate, mut acceleration] = [self.middle, 0.0, 0.0];
        for [w, phase] in self.sines {
            let (sin, cos) = (w * t + phase).sin_cos();
            q += self.amplitude * sin;
            rate += self.amplitude * w * cos;
            acceleration -= self.amplitude * w * w * sin;
        }
        [q, rate, acceleration]
    }
}

/// The model with effects hidden in it, in the words of the module's head.
///
/// ```
/// use sesc_identify::simulate::hide;
/// use sesc_identify::robot::{Robot, Stance};
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <mass value='2'/></inertial></link><joint name='hip' type='revolute'>\
/// #   <parent link='foot'/><child link='top'/><origin xyz='0 0 1'/><axis xyz='0 1 0'/>\
/// #   <limit lower='-1' upper='1'/></joint></robot>";
/// let model = Stance::new(Robot::parse(urdf, "pole.urdf")?).on("foot").model()?;
/// let hidden = hide(model, &["joint_offset:hip=1.5deg", "sensor_offset=3mm,0"])?;
/// assert_eq!(hidden.effects.len(), 2);
/// assert!((hidden.effects[0].1[0] - 1.5_f64.to_radians()).abs() < 1e-15);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// An effect, target, value or unit that is none, in a sentence with the remedy.
pub fn hide<S: AsRef<str>>(model: Model, effects: &[S]) -> Result<Model, Error> {
    if effects.is_empty() {
        return Ok(model);
    }
    let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
    let context = EffectContext::new(&model, cells, false, Catalog::standard());
    let robot_kg = model.tree.mass;
    let records = effects.iter();
    let records = records.map(|text| hidden(&context, robot_kg, text.as_ref()));
    let records: Vec<EffectRecord> = records.collect::<Result<_, _>>()?;
    let mut file = match &model.file {
        Some(file) => file.clone(),
        None => ModelFile::from_values(&model, &model.params(), None, "cad"),
    };
    // Messages about them begin so.
    file.file = "hidden effects".to_string();
    file.effects.extend(records);
    // No file says them.
    let hidden = model.clone().with_file(file);
    hidden.map_err(|error| Error::request(error.to_string()))
}

/// One effect as a model file has it.
fn hidden(context: &EffectContext, robot_kg: f64, text: &str) -> Result<EffectRecord, Error> {
    let bad = |reason: String| Error::request(format!("`{text}`: {reason}"));
    let (name, values) = match text.rsplit_once('=') {
        Some((name, values)) => (name, values.split(',').collect()),
        None => (text, Vec::new()),
    };
    let (effect, target) = name.split_once(':').unwrap_or((name, "-"));
    let mut record = EffectRecord {
        effect: effect.to_string(),
        target: target.to_string(),
        parameters: BTreeMap::new(),
        ..EffectRecord::default()
    };
    // What is wrong with the name or the target, the model file will say.
    let known = context.catalog.named(effect);
    if let Some(effect) = known
        && effect.targets(context).is_empty()
    {
        let mut moving = context.clone();
        moving.times = true;
        let reason = if effect.targets(&moving).is_empty() {
            "acts on the cells of a foot, and this robot has none; give a model file with `cells`, \
             or take another effect"
        } else {
            "acts on joint angles over time, which are logged as they are; to try it, shift the \
             joint columns of a log against its readings"
        };
        return Err(bad(reason.to_string()));
    }
    let target = known.and_then(|effect| context.target_named(effect, target));
    let (Some(effect), Some(target)) = (known, target) else {
        return Ok(record);
    };
    let parameters = effect.parameters(context, &target);
    if values.len() != parameters.len() {
        let names: Vec<&str> = parameters.iter().map(|p| p.name).collect();
        return Err(bad(match names.is_empty() {
            true => "takes no value; leave out what follows `=`".to_string(),
            false => format!(
                "has {} values where {} are wanted: {}",
                values.len(),
                names.len(),
                names.join(", ")
            ),
        }));
    }
    for (parameter, value) in parameters.iter().zip(values) {
        let value = quantity(parameter, robot_kg, value.trim()).map_err(bad)?;
        let value = Quantity { value, std: None };
        record.parameters.insert(parameter.name.to_string(), value);
    }
    Ok(record)
}

/// `1.5deg` of a parameter in radians.
fn quantity(parameter: &Parameter, robot_kg: f64, text: &str) -> Result<f64, String> {
    let units = parameter.unit.spellings();
    let unit = units.iter().find(|(unit, _)| text.ends_with(unit));
    let (number, factor) = match unit {
        Some((unit, factor)) => (&text[..text.len() - unit.len()], *factor),
        None => (text, 1.0),
    };
    let value = number.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    let value = value.ok_or_else(|| {
        let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
        format!(
            "`{text}` is no value of {}; give a number, with one of the units {} or none",
            parameter.name,
            names.join(", ")
        )
    })?;
    // Given without their unit an angle, a length and a mass are hardly larger.
    let bound = match parameter.unit {
        Unit::Radian => Some((0.6, "deg", "rad", format!("{:.0}°", value.to_degrees()))),
        Unit::Metre => Some((1.0, "mm", "m", format!("{} mm", 1e3 * value))),
        Unit::Kilogram => {
            let shown = format!("the robot weighs {robot_kg:.3} kg");
            Some((3.0 * robot_kg, "g", "kg", shown))
        }
        _ => None,
    };
    match bound.filter(|(most, ..)| unit.is_none() && value.abs() > *most) {
        Some((_, meant, own, shown)) => Err(format!(
            "{text} of {} is {text} {own} ({shown}); give its unit: {text}{meant}, or {text}{own} \
             if that is meant",
            parameter.name
        )),
        None => Ok(factor * value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{Robot, Stance};

    fn model() -> Model {
        let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
            <mass value='2'/></inertial></link><link name='bob'><inertial><mass value='1'/>\
            </inertial></link><joint name='hip' type='revolute'><parent link='foot'/>\
            <child link='top'/><origin xyz='0 0 1'/><axis xyz='0 1 0'/>\
            <limit lower='-1' upper='1'/></joint><joint name='lift' type='prismatic'>\
            <parent link='top'/><child link='bob'/><axis xyz='0 0 1'/>\
            <limit lower='0' upper='1'/></joint></robot>";
        let robot = Robot::parse(urdf, "pole.urdf").unwrap();
        Stance::new(robot).on("foot").model().unwrap()
    }

    fn values(text: &str) -> BTreeMap<String, f64> {
        let hidden = hide(model(), &[text]).unwrap();
        let record = &hidden.file.as_ref().unwrap().effects[0];
        let parameters = record.parameters.iter();
        parameters
            .map(|(name, x)| (name.clone(), x.value))
            .collect()
    }

    #[test]
    fn values_are_taken_with_their_units() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
        let quarter = values("joint_offset:hip=90deg")["offset_rad"];
        near(quarter, std::f64::consts::FRAC_PI_2);
        near(values("joint_offset:hip=0.02")["offset_rad"], 0.02);
        near(values("joint_offset:lift=3mm")["offset_m"], 3e-3);
        near(values("joint_scale:hip=-2%")["scale"], -0.02);
        let payload = values("payload:bob=200g,1cm,0,-2e-2");
        near(payload["mass_kg"], 0.2);
        near(payload["z_m"], -0.02);
        assert!(values("joint_sign:hip").is_empty());
        assert_eq!(values("backlash:all=0.9°").len(), 1);
    }

    #[test]
    fn what_is_no_effect_is_refused_with_the_remedy() {
        let wanted = "has 0 values where 1 are wanted: offset_rad";
        for (text, words) in [
            ("joint_ofset:hip=1", "known are sensor_offset"),
            ("joint_ofset:hip=1", "did you mean `joint_offset`?"),
            ("joint_offset:hib=1", "it has hip, lift"),
            ("joint_offset:hib=1", "did you mean `hip`?"),
            ("joint_offset:hip=1kg", "units deg, °, rad or none"),
            ("joint_offset:hip", wanted),
            ("joint_sign:hip=1", "takes no value"),
            ("joint_offset:hip=NaN", "no value of offset_rad"),
            (
                "joint_offset:hip=1.2",
                "is 1.2 rad (69°); give its unit: 1.2deg, or 1.2rad",
            ),
            (
                "joint_offset:lift=-3",
                "is -3 m (-3000 mm); give its unit: -3mm",
            ),
            (
                "payload:bob=200,0,0,0",
                "the robot weighs 3.000 kg); give its unit: 200g",
            ),
            ("time_delay=20ms", "shift the joint columns"),
            ("cell_gain:0=1%", "give a model file with `cells`"),
        ] {
            crate::tests::says(hide(model(), &[text]).unwrap_err(), &[words]);
        }
    }
}
