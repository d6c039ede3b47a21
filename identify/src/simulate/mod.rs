//! Posture logs of an ideal robot: uniform postures, or a motion through the joints' ranges,
//! and Gaussian CoP noise.

mod waves;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, Normal};
use sesc_model::tree::Dof;
use sesc_model::{Function, Model};

use crate::evaluate::{Evaluator, MotionPredictor};
use crate::logs::{LogSource, PostureWriter, Row, Sidecar, Table, Written};
use crate::observations::motion_use::MotionModel;
use crate::watch::{Watch, tell};
use crate::{Error, Setting, message};
use waves::{Moment, Waves};

/// Why a posture has no CoP.
const BEYOND: &str = "a drawn posture has no finite CoP: an angle is beyond 2^20 rad, where \
                      sines mean nothing, or an effect of the model file has a value that no \
                      robot has; give narrower joint limits or other values";
/// Postures evaluated together.
const BLOCK: usize = 4096;

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
        if let Some(range) = self.range.filter(|r| !(r.is_finite() && *r > 0.0)) {
            let remedy = format!(" {range}: give an angle above zero");
            return Err(Error::request(message![Setting::Range, remedy]));
        }
        let dof = self.model.dof();
        let given = self.postures.as_ref().map(Vec::len);
        if let Some(given) = given.filter(|given| *given != dof * self.poses) {
            let remedy =
                format!(": {given} positions given; one of each of {dof} joints is needed");
            let poses = format!(" {}", self.poses);
            return Err(Error::request(message![Setting::Poses, poses, remedy]));
        }
        if let Some(rate) = self.rate.filter(|r| !(1e-3..=1e6).contains(r)) {
            let remedy = format!(" {rate}: give rows per second, 0.001 to 1e6");
            return Err(Error::request(message![Setting::Rate, remedy]));
        }
        let noise = self.noise;
        if !(noise.is_finite() && noise >= 0.0) {
            let remedy = format!(" {noise}: give metres, zero or more");
            return Err(Error::request(message![Setting::Noise, remedy]));
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
        let evaluator = Evaluator::new(model, Function::Cop);
        let dof = model.dof();
        let numbers = self.numbers.as_ref().filter(|all| all.len() == self.poses);
        let waves = self.rate.map(|_| simulator.waves());
        let zmp = match self.motion {
            MotionModel::Auto => waves.as_ref().map(|_| MotionPredictor::new(model)),
            MotionModel::Off => None,
        };
        for start in (0..self.poses).step_by(BLOCK) {
            tell(watch, "simulating", start as u64, self.poses as u64)?;
            let n = BLOCK.min(self.poses - start);
            let time = |k: usize| self.rate.map_or(0.0, |rate| (start + k) as f64 / rate);
            let mut moment = Moment::default();
            match &waves {
                Some(waves) => (0..n).for_each(|k| waves.at(time(k), &mut moment)),
                None => {
                    moment.q = match &self.postures {
                        Some(given) => given[start * dof..(start + n) * dof].to_vec(),
                        None => simulator.batch(n),
                    }
                }
            }
            let q = moment.q;
            let readings = match &zmp {
                Some(zmp) => {
                    let motion = (&moment.rates[..], &moment.accelerations[..]);
                    zmp.readings(&q, n, motion)
                }
                None => evaluator.run(&q, n),
            };
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

    fn columns(&self) -> Written {
        Written {
            t: self.rate.is_some(),
            cop: true,
            cop_std: self.noise > 0.0,
            ..Written::default()
        }
    }

    fn sidecar(&self) -> Sidecar {
        let tree = &self.model.tree;
        Sidecar {
            robot: Some(tree.robot.clone()),
            support: Some(tree.links[tree.support].name.clone()),
            ..Sidecar::default()
        }
    }
}

/// A simulated log in memory, as a file of it would be read.
///
/// ```
/// use sesc_identify::robot::Robot;
/// use sesc_identify::simulate::{Request, simulate};
/// use sesc_identify::stance::Stance;
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
/// use sesc_identify::stance::Stance;
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
    request.check()?;
    let dofs = &request.model.tree.dofs;
    let mut log = PostureWriter::create(path, dofs, request.columns())?;
    request.run(watch, |row| log.row(row))?;
    log.finish(&request.sidecar())?;
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
    request.check()?;
    let dofs = &request.model.tree.dofs;
    let mut log = PostureWriter::stream(name, to, dofs, request.columns())?;
    request.run(watch, |row| log.row(row))?;
    log.finish(&request.sidecar()).map(drop)
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

    /// A motion through the ranges.
    fn waves(&mut self) -> Waves {
        Waves::draw(&self.ranges, &mut self.postures)
    }

    /// The next posture, rad or m.
    pub fn posture(&mut self) -> Vec<f64> {
        let rng = &mut self.postures;
        self.ranges
            .iter()
            .map(|&(lower, upper)| lower + (upper - lower) * rng.random::<f64>())
            .collect()
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
    match range {
        Some(range) if !dof.prismatic => {
            let (lower, upper) = (dof.lower.max(-range), dof.upper.min(range));
            if lower < upper {
                (lower, upper)
            } else {
                (dof.lower, dof.upper)
            }
        }
        _ => (dof.lower, dof.upper),
    }
}
