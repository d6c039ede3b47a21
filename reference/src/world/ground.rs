//! From the loads on the robot to the pressure under its sole.
//!
//! ```text
//! p   = c - g c_z / g_z                    c along gravity onto the plane z = 0
//! R   = M g + Σ F,  m = c × M g + Σ x × F  with pulls and inertia: all loads together
//! p   = (-m_y, m_x) / R_z                  where the ground's answer has no moment along x, y
//! ```
//!
//! The second is the first where nothing but gravity acts. A link whose centre of mass is
//! accelerated by `a` pulls at the robot with `-m a`, and turns it with `-(I α + ω × I ω)`;
//! what a link carries loosely counts as a point. `ω` and `α` come from its orientations at
//! three moments.

use nalgebra::{Matrix3, Point3, Vector2, Vector3};

use crate::error::{Error, Problem};
use crate::joint::Pose;

use super::World;
use super::statics::{GRAVITY, Load};

/// What the ground feels.
pub(super) struct Pressure {
    /// The centre of pressure, m, in the support frame.
    pub at_m: Vector2<f64>,
    /// How hard the sole presses, N.
    pub total_n: f64,
}

/// What inertia does to a robot that moves.
#[derive(Default)]
pub(super) struct Inertia {
    forces: Vec<Load>,
    /// N m
    moment: Vector3<f64>,
}

impl World {
    /// Gravity has this direction in the support frame (any length). It
    /// replaces an earlier gravity or slope.
    ///
    /// # Errors
    /// `ErrorKind::Gravity` where it does not point below the support plane.
    pub fn gravity(mut self, direction: [f64; 3]) -> Result<Self, Error> {
        let finite = direction.iter().all(|component| component.is_finite());
        if !finite || direction[2] >= 0.0 {
            return Err(Problem::Gravity { direction }.into());
        }
        self.gravity = Vector3::from(direction);
        Ok(self)
    }

    /// The ground, and the foot flat on it, falls off by `slope` (rise over
    /// run) along x and y of the support frame, so that a CoM at height `z`
    /// moves the CoP by `z · slope`: gravity along `(slope_x, slope_y, -1)`.
    ///
    /// # Errors
    /// `ErrorKind::Gravity` where a slope is not finite.
    pub fn ground_slope(self, [x, y]: [f64; 2]) -> Result<Self, Error> {
        self.gravity([x, y, -1.0])
    }

    /// The ground falls off by so much more (rise over run) along an axis (0 x, 1 y) of the
    /// support frame, beside what an earlier gravity or slope says.
    pub fn ground_error(mut self, axis: usize, slope: f64) -> Self {
        self.gravity /= -self.gravity.z;
        self.gravity[axis] += slope;
        self
    }

    /// Gravity's pull on a kilogram, N.
    pub(super) fn pull_of_gravity(&self) -> Vector3<f64> {
        self.gravity * (GRAVITY / self.gravity.norm())
    }

    /// Every force on the robot: weights of links and of what they carry
    /// loosely, and pulls.
    pub(super) fn loads(&self, poses: &[Pose]) -> Vec<Load> {
        let gravity = self.pull_of_gravity();
        let links = self.robot().links().iter().zip(poses).enumerate();
        let weights = links.map(|(link, (inertia, pose))| Load {
            link,
            at_m: pose * inertia.com_m,
            force_n: gravity * inertia.mass_kg,
        });
        let carried = self.carried(poses).into_iter().map(|carried| Load {
            link: carried.link,
            at_m: carried.at_m,
            force_n: gravity * carried.mass_kg,
        });
        weights
            .chain(carried)
            .chain(self.pull_loads(poses))
            .collect()
    }

    fn pull_loads(&self, poses: &[Pose]) -> impl Iterator<Item = Load> {
        self.pulls.iter().map(|pull| Load {
            link: pull.link,
            at_m: poses[pull.link] * pull.at_m,
            force_n: pull.force_n,
        })
    }

    /// The centre of mass of all that hangs together, and its mass, kg.
    pub(super) fn com_of(&self, joints: &[f64]) -> (Vector3<f64>, f64) {
        let (com, mass_kg) = (self.reference.com(joints), self.reference.total_mass());
        if self.unmodelled.carries_nothing() {
            return (com, mass_kg);
        }
        let carried = self.carried(&self.reference.link_poses(joints));
        let (mut moment, mut total_kg) = (com * mass_kg, mass_kg);
        for load in carried {
            moment += load.at_m.coords * load.mass_kg;
            total_kg += load.mass_kg;
        }
        (moment / total_kg, total_kg)
    }

    /// The pressure under the sole when the joints stand at `joints` and this
    /// inertia acts.
    pub(super) fn pressure(&self, joints: &[f64], inertia: &Inertia) -> Pressure {
        let (com, mass_kg) = self.com_of(joints);
        let weight = self.pull_of_gravity() * mass_kg;
        if self.pulls.is_empty() && inertia.forces.is_empty() {
            let firm = (com - self.gravity * (com.z / self.gravity.z)).xy();
            return Pressure {
                at_m: firm + self.functions.slope(firm) * com.z,
                total_n: -weight.z,
            };
        }
        let (mut force, mut moment) = (weight, com.cross(&weight) + inertia.moment);
        let poses = self.reference.link_poses(joints);
        for load in self
            .pull_loads(&poses)
            .chain(inertia.forces.iter().copied())
        {
            force += load.force_n;
            moment += load.at_m.coords.cross(&load.force_n);
        }
        let firm = Vector2::new(-moment.y, moment.x) / force.z;
        Pressure {
            at_m: firm + self.functions.slope(firm) * com.z,
            total_n: -force.z,
        }
    }

    /// The inertia at the middle one of three moments that are `step_s` apart.
    pub(super) fn inertia(&self, joints: [&[f64]; 3], step_s: f64) -> Inertia {
        Inertia {
            forces: self.forces_of_inertia(joints, step_s),
            moment: self.moment_of_inertia(joints, step_s),
        }
    }

    /// -Σ I α + ω × I ω over the links.
    fn moment_of_inertia(&self, joints: [&[f64]; 3], step_s: f64) -> Vector3<f64> {
        let [before, now, after] = joints.map(|joints| self.reference.link_poses(joints));
        let links = self.robot().links().iter().enumerate();
        let moments = links.map(|(l, link)| {
            let turned = |from: &Pose, to: &Pose| -> Vector3<f64> {
                small_turn(&(to.rotation.matrix() * from.rotation.matrix().transpose())) / step_s
            };
            let (first, second) = (turned(&before[l], &now[l]), turned(&now[l], &after[l]));
            let (rate, gain) = ((first + second) / 2.0, (second - first) / step_s);
            let at = now[l].rotation.matrix();
            let inertia: Matrix3<f64> = at * link.inertia_kg_m2 * at.transpose();
            inertia * gain + rate.cross(&(inertia * rate))
        });
        -moments.sum::<Vector3<f64>>()
    }

    fn forces_of_inertia(&self, joints: [&[f64]; 3], step_s: f64) -> Vec<Load> {
        let places = joints.map(|joints| self.mass_points(joints));
        let [before, now, after] = &places;
        let moments = before.iter().zip(now).zip(after);
        moments
            .map(|((before, now), after)| {
                let turn = (after.1 - now.1) - (now.1 - before.1);
                Load {
                    link: now.0,
                    at_m: now.1,
                    force_n: turn * (-now.2 / (step_s * step_s)),
                }
            })
            .collect()
    }

    /// Link, place and mass of every point mass.
    fn mass_points(&self, joints: &[f64]) -> Vec<(usize, Point3<f64>, f64)> {
        let poses = self.reference.link_poses(joints);
        let links = self.robot().links().iter().zip(&poses).enumerate();
        let links = links.map(|(l, (link, pose))| (l, pose * link.com_m, link.mass_kg));
        let carried = self.carried(&poses).into_iter();
        links
            .chain(carried.map(|load| (load.link, load.at_m, load.mass_kg)))
            .collect()
    }
}

/// Axis times angle (rad) of a rotation by less than a right angle: `R − Rᵀ = 2 sin θ â`.
fn small_turn(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let twice = rotation - rotation.transpose();
    let sine = Vector3::new(twice.m32, twice.m13, twice.m21) / 2.0;
    match sine.norm() {
        0.0 => sine,
        norm => sine * (norm.min(1.0).asin() / norm),
    }
}
