//! What can be hidden: an effect, where it sits, and how large it is.
//!
//! `values` are zero where there is no effect, so that a size scales them and a
//! refit starts from nothing:
//!
//! ```text
//! sensor_offset x, y m · sensor_gain x, y less 1 · sensor_rotation rad · sensor_drift x, y m
//! cell_gain less 1 · cell_offset N · cell_exponent less 1 · cell_saturation 1/N
//! ground_slope x, y · payload m kg, m·x, m·y, m·z kg m · external_force x, y, z N
//! joint_offset rad · joint_scale less 1 · joint_compliance rad/(N m) · backlash rad
//! time_delay s · mass_distribution spread · cop_outliers m · cable its part of the joint's stiffness
//! ```

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Error, Place, World};

use crate::recording::normal;

/// The target of an effect that has none.
pub const NOWHERE: &str = "-";
/// The target of an effect on every joint.
pub const ALL: &str = "all";
/// A joint that no load bends, N m/rad.
const STIFF: f64 = 1e7;
/// The part of a log that reads wrong where `cop_outliers` are hidden.
pub const OUTLIER_FRACTION: f64 = 0.12;

/// What may be wrong with a virtual robot, its sensor or its log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// Readings off by a constant.
    SensorOffset,
    /// Readings larger or smaller by a factor.
    SensorGain,
    /// A sensor turned about the vertical.
    SensorRotation,
    /// Readings that wander with time.
    SensorDrift,
    /// A cell whose gain is off.
    CellGain,
    /// A cell with a force offset.
    CellOffset,
    /// Cells that answer by a power of the force.
    CellExponent,
    /// A cell that reads no more than a limit.
    CellSaturation,
    /// A floor that is not level.
    GroundSlope,
    /// A point mass on a link.
    Payload,
    /// A force on a link.
    ExternalForce,
    /// An encoder off by a constant.
    JointOffset,
    /// An encoder off by a factor.
    JointScale,
    /// An encoder of the wrong sign.
    JointSign,
    /// Two encoders exchanged.
    JointSwap,
    /// Joints that give way under load.
    JointCompliance,
    /// Joints that rest on either side of a dead band.
    Backlash,
    /// Readings later than postures.
    TimeDelay,
    /// Masses that are not CAD's.
    MassDistribution,
    /// Readings far from the others.
    CopOutliers,
    /// Angles in degrees or lengths in millimetres.
    Units,
    // Outside the library.
    /// A load that hangs from a link.
    HangingLoad,
    /// A knee that errs by a sine of its angle.
    KneeSine,
    /// A mass that slides on its link.
    LooseMass,
    /// A link that bends under load.
    BendingLink,
    /// A cable that becomes taut.
    Cable,
    /// A gear that errs once a tooth.
    GearError,
}

/// Name and number of parameters of each, in the order of their declaration.
const EFFECTS: [(Effect, &str, usize); 27] = [
    (Effect::SensorOffset, "sensor_offset", 2),
    (Effect::SensorGain, "sensor_gain", 2),
    (Effect::SensorRotation, "sensor_rotation", 1),
    (Effect::SensorDrift, "sensor_drift", 2),
    (Effect::CellGain, "cell_gain", 1),
    (Effect::CellOffset, "cell_offset", 1),
    (Effect::CellExponent, "cell_exponent", 1),
    (Effect::CellSaturation, "cell_saturation", 1),
    (Effect::GroundSlope, "ground_slope", 2),
    (Effect::Payload, "payload", 4),
    (Effect::ExternalForce, "external_force", 3),
    (Effect::JointOffset, "joint_offset", 1),
    (Effect::JointScale, "joint_scale", 1),
    (Effect::JointSign, "joint_sign", 0),
    (Effect::JointSwap, "joint_swap", 0),
    (Effect::JointCompliance, "joint_compliance", 1),
    (Effect::Backlash, "backlash", 1),
    (Effect::TimeDelay, "time_delay", 1),
    // As many as there are links, and more.
    (Effect::MassDistribution, "mass_distribution", 40),
    (Effect::CopOutliers, "cop_outliers", 1),
    (Effect::Units, "units", 0),
    (Effect::HangingLoad, "hanging_load", 4),
    (Effect::KneeSine, "knee_sine", 1),
    (Effect::LooseMass, "loose_mass", 1),
    (Effect::BendingLink, "bending_link", 1),
    (Effect::Cable, "cable", 1),
    (Effect::GearError, "gear_error", 1),
];

impl Effect {
    /// What the library of effects knows.
    pub fn library() -> Vec<Effect> {
        let all = EFFECTS.into_iter().map(|row| row.0);
        all.filter(|effect| !effect.is_outside()).collect()
    }

    /// What it does not know.
    pub fn outside() -> Vec<Effect> {
        let all = EFFECTS.into_iter().map(|row| row.0);
        all.filter(|effect| effect.is_outside()).collect()
    }

    /// Those of the library that move the CoM at a given reading of the encoders.
    pub const BODY: [Effect; 8] = [
        Effect::JointOffset,
        Effect::JointScale,
        Effect::JointSign,
        Effect::JointSwap,
        Effect::JointCompliance,
        Effect::Backlash,
        Effect::Payload,
        Effect::MassDistribution,
    ];

    /// The name in the diagnoser's contract; for the others our own.
    pub fn name(self) -> &'static str {
        EFFECTS[self as usize].1
    }

    /// The effect of this name.
    pub fn named(name: &str) -> Option<Effect> {
        EFFECTS.iter().find(|row| row.1 == name).map(|row| row.0)
    }

    /// Whether the library does not know it.
    pub fn is_outside(self) -> bool {
        self > Effect::Units
    }

    /// Whether it shows in forces of cells alone.
    pub fn needs_cells(self) -> bool {
        matches!(
            self,
            Self::CellGain | Self::CellOffset | Self::CellExponent | Self::CellSaturation
        )
    }

    /// The number of values that a fit would find.
    pub fn parameters(self) -> usize {
        EFFECTS[self as usize].2
    }
}

/// One effect at one place with its size.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// Which effect.
    pub effect: Effect,
    /// The joint, link or cell that it acts on.
    pub target: String,
    /// Its parameters, SI.
    pub values: Vec<f64>,
    /// Where a cable becomes taut, rad; 0 for all others.
    pub begins: f64,
    /// What is random about it beyond its values: which postures are wrong,
    /// which masses.
    pub seed: u64,
}

impl Hidden {
    /// An effect of this size.
    pub fn new(effect: Effect, target: &str, values: &[f64]) -> Hidden {
        Hidden {
            effect,
            target: target.to_owned(),
            values: values.to_vec(),
            begins: 0.0,
            seed: 1,
        }
    }

    /// Its name in JSON: `effect`, or `effect:target`.
    pub fn label(&self) -> String {
        if self.target == NOWHERE {
            self.effect.name().to_owned()
        } else {
            format!("{}:{}", self.effect.name(), self.target)
        }
    }

    /// The same effect with other `values`.
    pub fn with(&self, values: Vec<f64>) -> Hidden {
        Hidden {
            values,
            ..self.clone()
        }
    }

    /// Bends the robot.
    pub fn hide(&self, world: World) -> Result<World, Error> {
        let (v, target) = (&self.values, self.target.as_str());
        match self.effect {
            Effect::MassDistribution => self.spread_masses(world),
            Effect::CopOutliers => world.cop_outliers(OUTLIER_FRACTION, v[0], self.seed),
            Effect::HangingLoad => world.hanging_load(target, v[0], point(v), 0.1),
            Effect::KneeSine => {
                let [x, y] = self.direction();
                world.cop_sine(target, 3.0, [x * v[0], y * v[0]])
            }
            Effect::LooseMass => {
                let [x, y] = self.direction();
                world.loose_mass(target, v[0], [0.0; 3], [x, y, 0.0], 0.065)
            }
            Effect::BendingLink => {
                let [x, y] = self.direction();
                world.bending_link(target, [x, y, 0.0], 1.0 / v[0].abs())
            }
            // Against a joint so stiff that nothing but the cable bends it.
            Effect::Cable => {
                let stiff = world.joint_compliance(target, STIFF)?;
                stiff.cable(target, STIFF * v[0].abs(), self.begins)
            }
            Effect::GearError => world.gear_error(target, v[0], 6.0, self.direction()[0]),
            effect => world.named(effect.name(), self.place(), &self.in_files()),
        }
    }

    /// What it acts on, for the virtual robot.
    fn place(&self) -> Place<'_> {
        let target = self.target.as_str();
        match (self.effect, target) {
            (Effect::Units, _) => Place::Way("degrees"),
            (Effect::Payload | Effect::ExternalForce, link) => Place::Link(link),
            (effect, cell) if effect.needs_cells() => {
                Place::Cell(cell.trim_start_matches("fsr_").parse().unwrap_or(0))
            }
            (_, NOWHERE) => Place::Whole,
            (_, ALL) => Place::AllJoints,
            (_, joints) => match joints.split_once(',') {
                Some((one, other)) => Place::Joints(one, other),
                None => Place::Joint(joints),
            },
        }
    }

    /// Its values as model files have them.
    fn in_files(&self) -> Vec<f64> {
        let v = &self.values;
        let each = |of: fn(&f64) -> f64| v.iter().map(of).collect();
        match self.effect {
            Effect::SensorGain | Effect::CellGain | Effect::CellExponent | Effect::JointScale => {
                each(|less_one| 1.0 + less_one)
            }
            Effect::CellSaturation | Effect::JointCompliance => each(|inverse| 1.0 / inverse.abs()),
            Effect::Backlash => each(|width| width.abs()),
            Effect::Payload => {
                let [x, y, z] = point(v);
                vec![v[0], x, y, z]
            }
            _ => v.clone(),
        }
    }

    /// A direction that belongs to the seed.
    fn direction(&self) -> [f64; 2] {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let (sin, cos) = (std::f64::consts::TAU * random.random::<f64>()).sin_cos();
        [cos, sin]
    }

    /// Every link's mass by a factor, every CoM by a shift of some millimetres.
    fn spread_masses(&self, mut world: World) -> Result<World, Error> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut normal = || normal(&mut random);
        let spread = self.values[0];
        let links = world.robot().links().iter();
        let massive: Vec<(String, f64)> = links
            .filter(|link| link.mass_kg > 0.0)
            .map(|link| (link.name.clone(), link.com_m.coords.norm()))
            .collect();
        for (link, reach) in massive {
            let factor = (spread * normal()).exp();
            let shift = [(); 3].map(|()| spread * reach * normal());
            world = world.link_mass(&link, factor, shift)?;
        }
        Ok(world)
    }
}

/// The place of a mass from its first moment.
fn point(values: &[f64]) -> [f64; 3] {
    [1, 2, 3].map(|i| values[i] / values[0])
}

/// Bends a robot by everything that is hidden in it, in the contract's order
/// whatever the order given.
pub fn hide_all(world: World, hidden: &[Hidden]) -> Result<World, Error> {
    hidden
        .iter()
        .try_fold(world, |world, hidden| hidden.hide(world))
}
