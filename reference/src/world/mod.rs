//! A virtual robot: the true one, which differs from its URDF.
//!
//! ```text
//! joints    φ = scale q + offset                  where the joints stand unloaded
//! statics   φ = φ + slack + τ(φ) / k              where their loads bend them to
//! masses    c = CoM(φ), payloads included         Eq. (3)
//! ground    p = c - g c_z / g_z                   c along gravity onto the plane z = 0
//! cells     p = Σ f_k p_k / Σ f_k                 from loads that each cell gets wrong
//! sensor    y = Rot(ψ) diag(gain) p + o + u d     what is written down
//! ```
//!
//! One room per stage, in this order; a robot has all its imperfections at
//! once. Everything is exact and nonlinear: the robot itself is bent, and
//! Eq. (3) does the rest. Readings are free of noise, which is the caller's to
//! add.

mod cells;
mod functions;
mod ground;
mod joints;
mod masses;
mod named;
mod sensor;
mod statics;
mod track;
mod unmodelled;

use nalgebra::{Vector2, Vector3};

use crate::com::Reference;
use crate::error::Error;
use crate::robot::Robot;

use cells::Cells;
use functions::Functions;
use ground::{Inertia, Pressure};
use joints::Encoder;
use sensor::Sensor;
use statics::{Pull, Yielding, moved_links};
use unmodelled::Unmodelled;

pub use named::Place;
pub use statics::GRAVITY;
pub use track::{Reading, Track};

/// A robot on its support link with imperfections that its URDF does not show.
///
/// ```
/// # use sesc_reference::{Robot, World};
/// # let robot = Robot::from_urdf(
/// #     r#"<robot name="r"><link name="foot"/>
/// #          <link name="leg"><inertial><origin xyz="0 0 0.3"/><mass value="1"/></inertial></link>
/// #          <joint name="ankle" type="continuous"><parent link="foot"/><child link="leg"/></joint>
/// #        </robot>"#,
/// # )?;
/// let world = World::new(&robot, "foot")?
///     .joint_offset("ankle", 0.02)?
///     .payload("leg", 0.1, [0.0, 0.0, 0.4])?
///     .sensor_offset([0.001, 0.0]);
/// let [x, y] = world.cop(&[0.1]);
/// # assert!((x - 0.001).abs() < 1e-15);
/// # assert!((y + (0.3 + 0.04) / 1.1 * 0.12_f64.sin()).abs() < 1e-15);
/// # Ok::<(), sesc_reference::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct World {
    reference: Reference,
    /// Which links every joint of the file moves, and in which sense.
    moved: Vec<(Vec<bool>, f64)>,
    nominal_kg: f64,
    /// One per entry of the posture.
    encoders: Vec<Encoder>,
    /// One per joint, those without an encoder at the end.
    yielding: Vec<Yielding>,
    pulls: Vec<Pull>,
    unmodelled: Unmodelled,
    functions: Functions,
    gravity: Vector3<f64>,
    cells: Cells,
    sensor: Sensor,
    delay_s: f64,
    unsettled: bool,
    /// Rounds in which joints yield, where it is not until they rest.
    rounds: Option<usize>,
}

impl World {
    /// The robot exactly as its URDF says, on level ground.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn new(robot: &Robot, support: &str) -> Result<Self, Error> {
        let reference = Reference::new(robot, support)?;
        let dof = reference.dof();
        let robot = reference.robot();
        Ok(Self {
            moved: moved_links(robot, robot.link_index(support)?),
            nominal_kg: reference.total_mass(),
            encoders: (0..dof).map(Encoder::true_of).collect(),
            yielding: vec![Yielding::default(); dof],
            pulls: Vec::new(),
            unmodelled: Unmodelled::default(),
            functions: Functions::default(),
            gravity: -Vector3::z(),
            cells: Cells::default(),
            sensor: Sensor::ideal(),
            delay_s: 0.0,
            unsettled: false,
            rounds: None,
            reference,
        })
    }

    /// The robot as it really is, payloads and hidden hinges included.
    pub fn robot(&self) -> &Robot {
        self.reference.robot()
    }

    /// The number of entries in a posture: joints with an encoder.
    pub fn dof(&self) -> usize {
        self.encoders.len()
    }

    /// Where the joints really are when the encoders read `q`; not a number
    /// where their springs are too soft to hold the robot.
    ///
    /// # Panics
    /// Where `q` has not one entry per movable joint.
    pub fn true_posture(&self, q: &[f64]) -> Vec<f64> {
        let mut joints = self.settle(q);
        joints.truncate(self.dof());
        joints
    }

    /// The same robot, whose joints yield in `rounds` steps `φ' = φ + C τ(φ')` from where
    /// their encoders have them, instead of until they rest: what a model of so many rounds
    /// computes. Dead bands want more.
    pub fn after_rounds(self, rounds: usize) -> World {
        World {
            rounds: Some(rounds),
            ..self
        }
    }

    /// What loads and cables do to the joints when the encoders read `q`: N m, or N for
    /// prismatic ones. Positive moments push joints up.
    ///
    /// # Panics
    /// As [`World::true_posture`].
    pub fn joint_moments(&self, q: &[f64]) -> Vec<f64> {
        let joints = self.settle(q);
        let loads = self.moments(&joints).into_iter().zip(&self.yielding);
        let moments = loads.zip(joints);
        moments
            .map(|((moment, yielding), joint)| moment + yielding.cable_moment(joint))
            .take(self.dof())
            .collect()
    }

    /// The true centre of mass when the encoders read `q`, in the support
    /// frame, m.
    ///
    /// # Panics
    /// As [`World::true_posture`].
    pub fn com(&self, q: &[f64]) -> Vector3<f64> {
        self.com_of(&self.settle(q)).0
    }

    /// What the sensor reads when the encoders read `q`, at rest and at the
    /// start of a log: CoP in the support frame, m, without noise.
    ///
    /// # Panics
    /// As [`World::true_posture`].
    pub fn cop(&self, q: &[f64]) -> [f64; 2] {
        let pressure = self.pressure(&self.settle(q), &Inertia::default());
        self.sense(q, &pressure, 0.0, Vector2::zeros()).cop
    }

    /// What is written down about a pressure; `jump` is this posture's own.
    fn sense(&self, q: &[f64], pressure: &Pressure, progress: f64, jump: Vector2<f64>) -> Reading {
        let after = |cop| {
            let reading = self.sensor.reading(cop, progress);
            reading + self.functions.added(reading) + self.unmodelled.sine(q) + jump
        };
        if self.cells.is_empty() {
            return Reading {
                cop: self.sensor.write(after(pressure.at_m)),
                cells_n: Vec::new(),
            };
        }
        let loads = self
            .cells
            .loads(pressure.at_m, pressure.total_n, self.nominal_weight());
        let cop = self.cells.cop_of(&loads);
        let reading = after(cop);
        Reading {
            // What changes the CoP behind the cells is as if they had felt it.
            cells_n: if reading == cop {
                loads
            } else {
                self.cells.true_loads(reading, loads.iter().sum())
            },
            cop: self.sensor.write(reading),
        }
    }
}
