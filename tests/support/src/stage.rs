//! Robots on one foot, and postures for them.
//!
//! `bench` postures keep the CoP in a box over the sole (|x|, |y| < 23 mm on the
//! OP2, larger robots in proportion to their feet), `wide` ones are uniform
//! within ±30°, `motion` sweeps slowly with time.

use std::f64::consts::TAU;
use std::path::PathBuf;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Robot, World};

/// Largest |x| and |y| of a balanced CoP on the OP2, m.
const BOX_M: f64 = 0.023;
/// Standard deviation of one reading on the OP2, m.
const NOISE_M: f64 = 0.00493;
/// Half length and half width of the rectangle of cells on the OP2, m.
const CELLS_M: [f64; 2] = [0.0315, 0.0245];
/// ±30°.
const WIDE: f64 = 0.523_598_775_598_298_8;

/// A robot that studies stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Platform {
    /// The OP2 on its right sole.
    Op2,
    /// A humanoid of 30 joints with skew axes.
    Skew,
    /// One with axes along coordinates.
    Plain,
}

/// Kinds of postures, and how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Postures {
    /// Balanced, within ranges of a bench.
    Bench(usize),
    /// Within ±30° of every joint, balanced or not.
    Wide(usize),
    /// On the way of a slow motion.
    Motion(usize),
}

impl Postures {
    /// How many.
    pub fn count(self) -> usize {
        match self {
            Self::Bench(count) | Self::Wide(count) | Self::Motion(count) => count,
        }
    }
}

/// A robot standing, and how large everything about it is.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Which robot.
    pub platform: Platform,
    /// Its URDF.
    pub urdf: PathBuf,
    /// The link on the ground.
    pub support: &'static str,
    /// The robot.
    pub robot: Robot,
    /// Foot against the OP2's.
    pub size: f64,
    /// Ranges of balanced postures, rad.
    ranges: Vec<(f64, f64)>,
    /// Where joints are that stand still in all postures, rad.
    held: Vec<Option<f64>>,
}

/// The OP2's ranges on the bench, rad: of the right leg, which carries, of the
/// left leg and of everything above.
const OP2_RANGES: [(&str, f64, f64); 20] = [
    ("head_pan", -1.2, 1.2),
    ("head_tilt", -0.4, 0.25),
    ("l_hip_yaw", -0.3, 0.5),
    ("l_hip_roll", -0.5, 0.05),
    ("l_hip_pitch", -0.25, 1.0),
    ("l_knee", -1.4, 0.0),
    ("l_ank_pitch", -0.8, 0.45),
    ("l_ank_roll", -0.35, 0.55),
    ("l_sho_pitch", -1.7, 1.7),
    ("l_sho_roll", -0.7, 1.1),
    ("l_el", -1.6, 0.0),
    ("r_hip_yaw", -0.5, 0.3),
    ("r_hip_roll", -0.42, 0.42),
    ("r_hip_pitch", -0.65, 0.25),
    ("r_knee", 0.0, 0.95),
    ("r_ank_pitch", -0.1, 0.5),
    ("r_ank_roll", -0.45, -0.05),
    ("r_sho_pitch", -1.7, 1.7),
    ("r_sho_roll", -1.1, 0.7),
    ("r_el", 0.0, 1.6),
];

impl Stage {
    /// The robot `platform` on its sole.
    pub fn new(platform: Platform) -> Stage {
        let (name, support, size) = match platform {
            Platform::Op2 => ("op2", "r_sole", 1.0),
            Platform::Skew => ("skew_humanoid", "right_sole", 2.2),
            Platform::Plain => ("plain_humanoid", "right_sole", 2.2),
        };
        let root = env!("CARGO_MANIFEST_DIR");
        let urdf = PathBuf::from(format!("{root}/../../robots/{name}/{name}.urdf"));
        let robot = Robot::from_file(&urdf).expect("the repository's robots are readable");
        let ranges = robot.movable_joints().map(|joint| {
            let given = OP2_RANGES.iter().find(|(name, ..)| *name == joint.name);
            match given {
                Some(&(_, low, high)) if platform == Platform::Op2 => (low, high),
                _ => (joint.range().0.max(-WIDE), joint.range().1.min(WIDE)),
            }
        });
        let ranges: Vec<(f64, f64)> = ranges.collect();
        Stage {
            platform,
            support,
            size,
            held: vec![None; ranges.len()],
            ranges,
            urdf,
            robot,
        }
    }

    /// The same robot, each of whose joints stands still with probability `share`: where it is in
    /// some balanced posture.
    pub fn holding(mut self, share: f64, random: &mut ChaCha8Rng) -> Stage {
        let balanced = self.balanced(1, random).concat();
        for (held, at) in self.held.iter_mut().zip(balanced) {
            *held = random.random_bool(share).then_some(at);
        }
        self
    }

    /// Positions with the joints that stand still where they are held.
    pub fn held(&self, mut q: Vec<f64>) -> Vec<f64> {
        for (q, held) in q.iter_mut().zip(&self.held) {
            *q = held.unwrap_or(*q);
        }
        q
    }

    /// The middle of a joint's balanced positions, rad.
    pub fn middle(&self, joint: &str) -> f64 {
        let joints = self.robot.movable_joints().zip(&self.ranges);
        let mut found = joints.filter(|(found, _)| found.name == joint);
        found
            .next()
            .map_or(0.0, |(_, (low, high))| 0.5 * (low + high))
    }

    /// The robot as its URDF has it, on its cells.
    pub fn world(&self) -> World {
        let world = World::new(&self.robot, self.support).expect("the stage names a sole");
        world.cells(&self.cells()).expect("a rectangle carries")
    }

    /// True for the joints of the leg that stands.
    pub fn carries(&self, joint: &str) -> bool {
        joint.starts_with("r_") || joint.starts_with("right_")
    }

    /// Names of the joints that move.
    pub fn joint_names(&self) -> Vec<String> {
        let joints = self.robot.movable_joints();
        joints.map(|joint| joint.name.clone()).collect()
    }

    /// Places of the force cells in the sole, m.
    pub fn cells(&self) -> [[f64; 2]; 4] {
        let [x, y] = CELLS_M.map(|half| half * self.size);
        [[x, y], [x, -y], [-x, -y], [-x, y]]
    }

    /// Standard deviation of one reading of the CoP, m.
    pub fn reading_std(&self) -> f64 {
        NOISE_M * self.size
    }

    /// Standard deviation of one reading of a cell, N: as much noise in x.
    pub fn cell_std(&self, weight_n: f64) -> f64 {
        self.reading_std() * weight_n / (2.0 * CELLS_M[0] * self.size)
    }

    /// `count` postures whose CoP stays within the sole.
    pub fn balanced(&self, count: usize, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let world = self.world();
        let within = BOX_M * self.size;
        let mut postures = Vec::with_capacity(count);
        while postures.len() < count {
            let q = self.held(draw(&self.ranges, random));
            if world.cop(&q).iter().all(|x| x.abs() < within) {
                postures.push(q);
            }
        }
        postures
    }

    /// `count` postures within ±30°.
    pub fn wide(&self, count: usize, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        let ranges = self.robot.movable_joints().map(|joint| {
            let (low, high) = joint.range();
            (low.max(-WIDE), high.min(WIDE))
        });
        let ranges: Vec<_> = ranges.collect();
        let one = |_| self.held(draw(&ranges, random));
        (0..count).map(one).collect()
    }

    /// Two slow sines a joint, at most 0.1 Hz.
    pub fn motion(&self, random: &mut ChaCha8Rng) -> impl Fn(f64) -> Vec<f64> + Clone + 'static {
        let waves: Vec<[[f64; 3]; 2]> = (0..self.ranges.len())
            .map(|_| {
                [(); 2].map(|()| {
                    let rate = TAU * (0.02 + 0.08 * random.random::<f64>());
                    [
                        0.2 * random.random::<f64>(),
                        rate,
                        TAU * random.random::<f64>(),
                    ]
                })
            })
            .collect();
        let held = self.held.clone();
        move |t| {
            let of = |[a, w, p]: &[f64; 3]| a * (w * t + p).sin();
            let joints = waves.iter().zip(&held);
            let at = joints.map(|(waves, at)| at.unwrap_or_else(|| waves.iter().map(of).sum()));
            at.collect()
        }
    }
}

fn draw(ranges: &[(f64, f64)], random: &mut ChaCha8Rng) -> Vec<f64> {
    let ranges = ranges.iter();
    ranges
        .map(|(low, high)| low + (high - low) * random.random::<f64>())
        .collect()
}
