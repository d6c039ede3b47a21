//! A virtual robot: the true one, which differs from its URDF.
//!
//! ```text
//! φ_j = scale_j q_j + offset_j              where the joints really are
//! c   = CoM(φ), payloads included           Eq. (3)
//! p   = c - g c_z / g_z                     c along gravity onto the plane z = 0
//! y   = Rot(ψ) p + o                        what the sensor reads
//! ```
//!
//! Everything is exact and nonlinear: the robot itself is bent, and Eq. (3)
//! does the rest. The robot stands still; readings are free of noise, which is
//! the caller's to add.

use nalgebra::{Rotation2, Vector2, Vector3};

use crate::com::Reference;
use crate::error::Error;
use crate::robot::Robot;

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
    joint_scale: Vec<f64>,
    joint_offset: Vec<f64>,
    gravity: Vector3<f64>,
    sensor_rotation: Rotation2<f64>,
    sensor_offset: Vector2<f64>,
}

impl World {
    /// The robot exactly as its URDF says, on level ground.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn new(robot: &Robot, support: &str) -> Result<Self, Error> {
        let reference = Reference::new(robot, support)?;
        let dof = reference.dof();
        Ok(Self {
            reference,
            joint_scale: vec![1.0; dof],
            joint_offset: vec![0.0; dof],
            gravity: -Vector3::z(),
            sensor_rotation: Rotation2::identity(),
            sensor_offset: Vector2::zeros(),
        })
    }

    /// The joint stands `offset` (rad or m) further than its encoder says.
    /// Joints that mimic it follow where it really is. Offsets add up.
    ///
    /// # Errors
    /// [`Error::UnknownJoint`].
    pub fn joint_offset(mut self, joint: &str, offset: f64) -> Result<Self, Error> {
        let j = self.robot().dof_index(joint)?;
        self.joint_offset[j] += offset;
        Ok(self)
    }

    /// The joint moves `factor` times as far as its encoder says (1: true),
    /// counted from its zero and before any offset. Factors multiply.
    ///
    /// # Errors
    /// [`Error::UnknownJoint`].
    pub fn joint_scale(mut self, joint: &str, factor: f64) -> Result<Self, Error> {
        let j = self.robot().dof_index(joint)?;
        self.joint_scale[j] *= factor;
        Ok(self)
    }

    /// A link carries a point mass (kg) that its URDF does not know, at `at_m`
    /// of the link's frame; a negative mass is missing from the link.
    ///
    /// # Errors
    /// [`Error::UnknownLink`]; [`Error::Payload`] where nothing of the link
    /// remains; [`Error::MassBeyondFreeJoint`].
    pub fn payload(mut self, link: &str, mass_kg: f64, at_m: [f64; 3]) -> Result<Self, Error> {
        let robot = self.robot().with_point_mass(link, mass_kg, at_m)?;
        self.reference = Reference::new(&robot, self.reference.support())?;
        Ok(self)
    }

    /// The sensor's zero lies elsewhere: `offset_m` is added to every reading,
    /// in the support frame. Offsets add up.
    pub fn sensor_offset(mut self, offset_m: [f64; 2]) -> Self {
        self.sensor_offset += Vector2::from(offset_m);
        self
    }

    /// Readings come out turned by `yaw` (rad) about the support's z axis,
    /// counter-clockwise seen from above, before any offset. Turns add up.
    pub fn sensor_rotation(mut self, yaw: f64) -> Self {
        self.sensor_rotation *= Rotation2::new(yaw);
        self
    }

    /// Gravity has this direction in the support frame (any length). It
    /// replaces an earlier gravity or slope.
    ///
    /// # Errors
    /// [`Error::Gravity`] where it does not point below the support plane.
    pub fn gravity(mut self, direction: [f64; 3]) -> Result<Self, Error> {
        let finite = direction.iter().all(|component| component.is_finite());
        if !finite || direction[2] >= 0.0 {
            return Err(Error::Gravity { direction });
        }
        self.gravity = Vector3::from(direction);
        Ok(self)
    }

    /// The ground, and the foot flat on it, falls off by `slope` (rise over
    /// run) along x and y of the support frame, so that a CoM at height `z`
    /// moves the CoP by `z · slope`: gravity along `(slope_x, slope_y, -1)`.
    ///
    /// # Errors
    /// [`Error::Gravity`] where a slope is not finite.
    pub fn ground_slope(self, [x, y]: [f64; 2]) -> Result<Self, Error> {
        self.gravity([x, y, -1.0])
    }

    /// The robot as it really is, payloads included.
    pub fn robot(&self) -> &Robot {
        self.reference.robot()
    }

    /// Where the joints really are when the encoders read `q`.
    ///
    /// # Panics
    /// Where `q` has not one entry per movable joint.
    pub fn true_posture(&self, q: &[f64]) -> Vec<f64> {
        assert_eq!(q.len(), self.reference.dof(), "one entry per movable joint");
        let joints = self.joint_scale.iter().zip(&self.joint_offset);
        q.iter()
            .zip(joints)
            .map(|(q, (scale, offset))| scale * q + offset)
            .collect()
    }

    /// The true centre of mass when the encoders read `q`, in the support
    /// frame, m.
    ///
    /// # Panics
    /// As [`World::true_posture`].
    pub fn com(&self, q: &[f64]) -> Vector3<f64> {
        self.reference.com(&self.true_posture(q))
    }

    /// What the sensor reads when the encoders read `q`: CoP in the support
    /// frame, m, without noise.
    ///
    /// # Panics
    /// As [`World::true_posture`].
    pub fn cop(&self, q: &[f64]) -> [f64; 2] {
        let com = self.com(q);
        let on_ground = com - self.gravity * (com.z / self.gravity.z);
        (self.sensor_rotation * on_ground.xy() + self.sensor_offset).into()
    }
}
