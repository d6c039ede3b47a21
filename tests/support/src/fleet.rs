//! Logs of a whole fleet: a folder for each robot and day, noise on every posture, and what
//! is wrong with some of them.
//!
//! ```text
//! logs/robot=r07/day=3/log.csv, log.csv.toml
//! ```

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Error, Robot, Track, World};

use crate::hidden::Hidden;
use crate::recording::normal;
use crate::stage::{Platform, Stage};

/// Readings of a posture.
const READINGS: f64 = 100.0;
/// Joint of the batch, and its offset in every robot of it, rad.
pub const BATCH: (&str, f64) = ("l_hip_roll", 0.035);
/// Joint that drifts, and by how much a day, rad.
pub const DRIFT: (&str, f64) = ("r_ank_pitch", 0.012);
/// Joint whose encoder is stuck.
pub const STUCK: &str = "r_knee";

/// How large a fleet is, and what is wrong with it.
#[derive(Debug, Clone, Default)]
pub struct Fleet {
    /// Number of robots.
    pub robots: usize,
    /// Days on which each is recorded.
    pub days: usize,
    /// Postures a day.
    pub postures: usize,
    /// Standard deviation of a posture's mean reading on one axis, m.
    pub noise: f64,
    /// Seed of robots, postures and noise.
    pub seed: u64,
    /// Robots with the same fault: joint [`BATCH`] is off by the same angle unless another one is
    /// given.
    pub batch: Vec<usize>,
    /// Fault of the batch.
    pub fault: Option<Hidden>,
    /// A robot whose joint [`DRIFT`] drifts from a day on.
    pub drifts: Option<(usize, usize)>,
    /// A robot whose encoder [`STUCK`] stands still.
    pub stuck: Option<usize>,
    /// A robot that has another URDF from a day on.
    pub urdf: Option<(usize, usize)>,
    /// Logs that end in the middle of a row.
    pub truncated: Vec<(usize, usize)>,
    /// A log that was delivered twice.
    pub twice: Option<(usize, usize)>,
    /// How much masses (relative) and centres of mass (m, on each axis) of links differ from
    /// robot to robot: standard deviations.
    pub spread: Option<(f64, f64)>,
}

impl Fleet {
    /// A fleet of which everything is as its URDF says: 0.1 mm of noise on each of 60 postures.
    pub fn sound(robots: usize, days: usize, seed: u64) -> Fleet {
        Fleet {
            robots,
            days,
            postures: 60,
            noise: 1e-4,
            seed,
            ..Fleet::default()
        }
    }

    /// The same with a batch of `batch` robots, a drift, a stuck encoder, a new URDF, two
    /// truncated logs and one that comes twice, each in a robot of its own.
    pub fn with_faults(self, batch: usize) -> Fleet {
        let (robots, days) = (self.robots, self.days);
        // Robots of the batch are spread over the fleet, the others stand between them.
        let step = (robots / batch.max(1)).max(1);
        let batch: Vec<usize> = (0..batch).map(|k| k * step).collect();
        let mut others = (0..robots).filter(|robot| !batch.contains(robot));
        let mut next = || others.next().unwrap_or(0);
        let half = days / 2 + 1;
        Fleet {
            drifts: Some((next(), half)),
            stuck: Some(next()),
            urdf: Some((next(), half)),
            truncated: vec![(next(), 1), (next(), days)],
            twice: Some((next(), half)),
            batch,
            ..self
        }
    }

    /// The name of a robot.
    pub fn name(robot: usize) -> String {
        format!("r{robot:02}")
    }

    /// The folder of a log, in that of the fleet.
    pub fn folder(robot: usize, day: usize) -> PathBuf {
        PathBuf::from(format!("logs/robot={}/day={day}", Fleet::name(robot)))
    }

    /// Write all logs into `folder`; gives the URDF of the fleet.
    ///
    /// # Errors
    /// What the reference does not do.
    ///
    /// # Panics
    /// Where the folder takes no files.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, Error> {
        let stage = Stage::new(Platform::Op2);
        let text = fs::read_to_string(&stage.urdf).expect("the repository's robots are readable");
        for robot in 0..self.robots {
            for day in 1..=self.days {
                let place = folder.join(Fleet::folder(robot, day));
                fs::create_dir_all(&place).expect("the folder takes files");
                self.write_log(&stage, &text, (robot, day), &place)?;
            }
        }
        Ok(stage.urdf)
    }

    fn write_log(
        &self,
        stage: &Stage,
        urdf: &str,
        (robot, day): (usize, usize),
        place: &Path,
    ) -> Result<(), Error> {
        let write = |name: &str, text: &str| {
            fs::write(place.join(name), text).expect("the folder takes files");
        };
        let seed = (self.seed * 1000 + robot as u64) * 1000 + day as u64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut world = stage.world();
        if self.spread.is_some() {
            world = World::new(&Robot::from_urdf(&self.body(urdf, robot))?, stage.support)?;
        }
        if self
            .urdf
            .is_some_and(|(own, from)| own == robot && day >= from)
        {
            let other = other_urdf(urdf);
            world = World::new(&Robot::from_urdf(&other)?, stage.support)?;
            write("robot.urdf", &other);
        }
        if self.batch.contains(&robot) {
            world = match &self.fault {
                Some(fault) => fault.hide(world)?,
                None => world.joint_offset(BATCH.0, BATCH.1)?,
            };
        }
        if let Some((_, from)) = self
            .drifts
            .filter(|(own, from)| *own == robot && day >= *from)
        {
            world = world.joint_offset(DRIFT.0, DRIFT.1 * (day - from + 1) as f64)?;
        }
        let stuck = self.stuck == Some(robot);
        let mut log = self.log(stage, &world, stuck, &mut random);
        if self.truncated.contains(&(robot, day)) {
            log.truncate(log.len() / 2);
            // In the middle of a row, whatever its length.
            let end = log.rfind(',').unwrap_or(0);
            log.truncate(end);
        }
        write("log.csv", &log);
        let sidecar = format!(
            "robot = \"op2\"\nsupport = \"{}\"\nreadings_per_pose = {READINGS}\n",
            stage.support
        );
        write("log.csv.toml", &sidecar);
        if self.twice == Some((robot, day)) {
            write("log_again.csv", &log);
            write("log_again.csv.toml", &sidecar);
        }
        Ok(())
    }

    /// The URDF of what a robot really is; its logs are those of a robot of the fleet's URDF.
    pub fn body(&self, urdf: &str, robot: usize) -> String {
        let Some((mass, com)) = self.spread else {
            return urdf.to_owned();
        };
        let seed = self.seed * 1_000_003 + robot as u64;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || normal(&mut random);
        let mut text = String::new();
        let mut rest = urdf;
        while let Some(at) = rest.find("<inertial>") {
            let end = at + rest[at..].find("</inertial>").unwrap_or(0);
            text += &rest[..at];
            let moved = edited(&rest[at..end], "xyz=\"", |x| x + com * normal());
            text += &edited(&moved, "<mass value=\"", |x| x * (1.0 + mass * normal()));
            rest = &rest[end..];
        }
        text + rest
    }

    /// The text of a log: mean readings with the standard deviation of a single one.
    fn log(&self, stage: &Stage, world: &World, stuck: bool, random: &mut ChaCha8Rng) -> String {
        let joints = stage.joint_names();
        let place = joints.iter().position(|joint| joint == STUCK);
        let postures = stage.balanced(self.postures, random);
        let held = place.map_or(0.0, |k| postures[0][k]);
        let mut text = format!(
            "pose,{},cop_x,cop_y,cop_x_std,cop_y_std\n",
            joints.join(",")
        );
        let readings = world.readings(&Track::still(postures.clone()));
        for (pose, (q, reading)) in postures.iter().zip(readings).enumerate() {
            let mut normal = || normal(random);
            let _ = write!(text, "{pose}");
            for (k, q) in q.iter().enumerate() {
                let shown = if stuck && Some(k) == place { held } else { *q };
                let _ = write!(text, ",{shown:.6}");
            }
            for axis in reading.cop {
                let _ = write!(text, ",{:.7}", axis + self.noise * normal());
            }
            for _ in 0..2 {
                // A sample's standard deviation scatters by 1/√(2n).
                let seen = 1.0 + normal() / (2.0 * READINGS).sqrt();
                let _ = write!(text, ",{:.7}", self.noise * READINGS.sqrt() * seen);
            }
            text.push('\n');
        }
        text
    }
}

/// A text with other numbers in the first attribute that begins so.
fn edited(text: &str, attribute: &str, mut to: impl FnMut(f64) -> f64) -> String {
    let Some(start) = text.find(attribute).map(|at| at + attribute.len()) else {
        return text.to_owned();
    };
    let end = start + text[start..].find('"').unwrap_or(0);
    let numbers = text[start..end].split_whitespace();
    let numbers = numbers.map(|number| to(number.parse().expect("URDFs have numbers")).to_string());
    let numbers: Vec<String> = numbers.collect();
    format!("{}{}{}", &text[..start], numbers.join(" "), &text[end..])
}

/// The URDF of a robot that carries a heavier head.
fn other_urdf(urdf: &str) -> String {
    let (before, head) = urdf
        .split_once("<link name=\"head_tilt_link\"")
        .expect("a head");
    let heavier = edited(head, "<mass value=\"", |_| 0.4);
    format!("{before}<link name=\"head_tilt_link\"{heavier}")
}
