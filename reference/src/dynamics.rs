//! Newton and Euler, link by link: what the ground feels of a robot that moves.
//!
//! ```text
//! F = Σ m_l a_l        H = Σ c_l × m_l a_l + I_l α_l + ω_l × I_l ω_l      over links l
//! L̇ = H − c × F                                                       about the CoM
//! p = c − (c_z F + L̇⊥)/(M g + F_z)          L̇⊥ = (L̇_y, −L̇_x)          on the plane z = 0
//! ```
//!
//! Velocities and accelerations are those of frames that move in the URDF's root, parents
//! before children; the support link moves among them, and what is seen from it follows from
//! the kinematics of relative motion:
//!
//! ```text
//! v' = v − v_s − ω_s × x        a' = a − a_s − α_s × x − ω_s × (ω_s × x) − 2 ω_s × v'
//! ω' = ω − ω_s                  α' = α − α_s − ω_s × ω'
//! ```

use nalgebra::{Vector2, Vector3};

use crate::com::Reference;
use crate::joint::{JointKind, Pose};
use crate::world::GRAVITY;

/// What moves as the joints of a posture do.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// The centre of mass, m.
    pub com: Vector3<f64>,
    /// Its acceleration, m/s².
    pub com_acceleration: Vector3<f64>,
    /// Rate of angular momentum about the CoM, N m.
    pub momentum_rate: Vector3<f64>,
}

/// How a link's frame moves: of its origin and its orientation.
#[derive(Clone, Copy)]
struct Moving {
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    angular_velocity: Vector3<f64>,
    change: Vector3<f64>,
}

impl Moving {
    const AT_REST: Moving = Moving {
        velocity: Vector3::new(0.0, 0.0, 0.0),
        acceleration: Vector3::new(0.0, 0.0, 0.0),
        angular_velocity: Vector3::new(0.0, 0.0, 0.0),
        change: Vector3::new(0.0, 0.0, 0.0),
    };

    /// The point that is `arm` from the origin, fixed to the frame.
    fn at(&self, arm: Vector3<f64>) -> Moving {
        let swept = self.angular_velocity.cross(&arm);
        Moving {
            velocity: self.velocity + swept,
            acceleration: self.acceleration
                + self.change.cross(&arm)
                + self.angular_velocity.cross(&swept),
            ..*self
        }
    }
}

impl Reference {
    /// The CoM and what moves it, in the support frame, as the joints at `q` move at
    /// `velocities` with `accelerations` (rad or m, per s and s²).
    ///
    /// # Panics
    /// Where an argument has not one entry per movable joint.
    pub fn motion(&self, q: &[f64], velocities: &[f64], accelerations: &[f64]) -> Motion {
        let poses = self.robot.poses_in_root(q);
        let moving = self.moving_in_root(&poses, velocities, accelerations);
        let (stand, ground) = (poses[self.support], moving[self.support]);
        let [mut moment, mut force, mut angular] = [Vector3::zeros(); 3];
        for (l, link) in self.robot.links().iter().enumerate() {
            if !self.is_placed(l) {
                continue;
            }
            let pose = &poses[l];
            let arm = pose.rotation * link.com_m.coords;
            let here = moving[l].at(arm);
            let x = pose.translation.vector + arm - stand.translation.vector;
            let below = ground.at(x);
            let velocity = here.velocity - below.velocity;
            let acceleration = here.acceleration
                - below.acceleration
                - 2.0 * ground.angular_velocity.cross(&velocity);
            let rate = here.angular_velocity - ground.angular_velocity;
            let change = here.change - ground.change - ground.angular_velocity.cross(&rate);
            let inertia = pose.rotation * link.inertia_kg_m2 * pose.rotation.matrix().transpose();
            moment += link.mass_kg * x;
            force += link.mass_kg * acceleration;
            angular += x.cross(&(link.mass_kg * acceleration))
                + inertia * change
                + rate.cross(&(inertia * rate));
        }
        let seen = |x: Vector3<f64>| stand.rotation.inverse() * x;
        let mass = self.total_mass();
        let com = moment / mass;
        Motion {
            com: seen(com),
            com_acceleration: seen(force / mass),
            momentum_rate: seen(angular - com.cross(&force)),
        }
    }

    /// The zero-moment point on the sole plane, m, with gravity along −z of the support frame.
    ///
    /// # Panics
    /// As [`Reference::motion`].
    pub fn zmp(&self, q: &[f64], velocities: &[f64], accelerations: &[f64]) -> Vector2<f64> {
        self.motion(q, velocities, accelerations)
            .zmp(self.total_mass())
    }

    fn moving_in_root(&self, poses: &[Pose], rates: &[f64], gains: &[f64]) -> Vec<Moving> {
        assert_eq!(rates.len(), self.dof(), "one velocity per movable joint");
        assert_eq!(
            gains.len(),
            self.dof(),
            "one acceleration per movable joint"
        );
        let mut moving = vec![Moving::AT_REST; poses.len()];
        for &j in self.robot.joints_from_root() {
            let joint = &self.robot.joints()[j];
            let coordinate = &self.robot.coordinates()[j];
            let of = |x: &[f64]| coordinate.dof.map_or(0.0, |dof| coordinate.factor * x[dof]);
            let (rate, gain) = (of(rates), of(gains));
            let (parent, child) = (&poses[joint.parent], &poses[joint.child]);
            let arm = child.translation.vector - parent.translation.vector;
            let axis = parent.rotation * (joint.origin.rotation * joint.axis.into_inner());
            let mut here = moving[joint.parent].at(arm);
            let carrier = here.angular_velocity;
            match joint.kind {
                JointKind::Revolute | JointKind::Continuous => {
                    here.angular_velocity += axis * rate;
                    here.change += axis * gain + carrier.cross(&(axis * rate));
                }
                JointKind::Prismatic => {
                    here.velocity += axis * rate;
                    here.acceleration += axis * gain + 2.0 * carrier.cross(&(axis * rate));
                }
                JointKind::Fixed | JointKind::Floating | JointKind::Planar => {}
            }
            moving[joint.child] = here;
        }
        moving
    }
}

impl Motion {
    /// The zero-moment point of a robot of this mass (kg) on the plane z = 0, m.
    pub fn zmp(&self, mass_kg: f64) -> Vector2<f64> {
        let Motion {
            com,
            com_acceleration,
            momentum_rate,
        } = self;
        let load_n = mass_kg * (GRAVITY + com_acceleration.z);
        let pushed = com_acceleration.xy() * (mass_kg * com.z);
        let turned = Vector2::new(momentum_rate.y, -momentum_rate.x);
        com.xy() - (pushed + turned) / load_n
    }
}
