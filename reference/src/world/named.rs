//! Imperfections by the names that model files give them: the one table from a name to what
//! bends the robot.
//!
//! Values are those of model files, in the order of the parameters. Whoever has an effect of
//! another kind (a model, a study) brings name, place and values; nothing else is shared with
//! the code that is checked.

use crate::error::{Error, Problem};
use crate::joint::JointKind;

use super::World;

/// What an imperfection acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place<'a> {
    /// The whole robot, or its sensor.
    Whole,
    /// A joint.
    Joint(&'a str),
    /// Every revolute joint.
    AllJoints,
    /// Two joints.
    Joints(&'a str, &'a str),
    /// A link.
    Link(&'a str),
    /// A cell of the sole, counted from 1.
    Cell(usize),
    /// One of a few ways, by name.
    Way(&'a str),
}

impl World {
    /// The robot with the imperfection `name` at a place, as model files name both.
    ///
    /// ```
    /// # use sesc_reference::{Place, Robot, World};
    /// # let robot = Robot::from_urdf(
    /// #     r#"<robot name="r"><link name="foot"/>
    /// #          <link name="leg"><inertial><origin xyz="0 0 0.3"/><mass value="1"/></inertial></link>
    /// #          <joint name="ankle" type="continuous"><parent link="foot"/><child link="leg"/></joint>
    /// #        </robot>"#,
    /// # )?;
    /// let world = World::new(&robot, "foot")?;
    /// let named = world.clone().named("joint_offset", Place::Joint("ankle"), &[0.02])?;
    /// assert_eq!(named.cop(&[0.1]), world.joint_offset("ankle", 0.02)?.cop(&[0.1]));
    /// # Ok::<(), sesc_reference::Error>(())
    /// ```
    ///
    /// # Errors
    /// `ErrorKind::UnknownImperfection` where there is none of this name that acts on such a place
    /// with so many values; else as the method of the same name.
    pub fn named(self, name: &str, place: Place, values: &[f64]) -> Result<World, Error> {
        match (name, place, values) {
            ("joint_offset", Place::Joint(joint), &[offset]) => self.joint_offset(joint, offset),
            ("joint_scale", Place::Joint(joint), &[scale]) => self.joint_scale(joint, scale),
            ("joint_sign", Place::Joint(joint), []) => self.joint_sign(joint),
            ("joint_swap", Place::Joints(one, other), []) => self.joint_swap(one, other),
            ("joint_compliance", Place::Joint(joint), &[stiffness]) => {
                self.joint_compliance(joint, stiffness)
            }
            ("joint_compliance", Place::AllJoints, &[stiffness]) => {
                self.at_revolute(|world, joint| world.joint_compliance(joint, stiffness))
            }
            ("backlash", Place::Joint(joint), &[width]) => self.backlash(joint, width),
            ("backlash", Place::AllJoints, &[width]) => {
                self.at_revolute(|world, joint| world.backlash(joint, width))
            }
            ("payload", Place::Link(link), &[mass, x, y, z]) => self.payload(link, mass, [x, y, z]),
            ("external_force", Place::Link(link), &[x, y, z]) => {
                self.external_force(link, [x, y, z])
            }
            ("ground_slope", Place::Whole, &[x, y]) => self.ground_slope([x, y]),
            ("sensor_offset", Place::Whole, &[x, y]) => Ok(self.sensor_offset([x, y])),
            ("sensor_gain", Place::Whole, &[x, y]) => Ok(self.sensor_gain([x, y])),
            ("sensor_rotation", Place::Whole, &[yaw]) => Ok(self.sensor_rotation(yaw)),
            ("sensor_drift", Place::Whole, &[x, y]) => Ok(self.sensor_drift([x, y])),
            ("sensor_axes", Place::Way("swapped"), []) => Ok(self.sensor_axes(true, [1.0, 1.0])),
            ("sensor_axes", Place::Way("flip_x"), []) => Ok(self.sensor_axes(false, [-1.0, 1.0])),
            ("sensor_axes", Place::Way("flip_y"), []) => Ok(self.sensor_axes(false, [1.0, -1.0])),
            ("cell_gain", Place::Cell(cell), &[gain]) => self.cell_gain(cell, gain),
            ("cell_offset", Place::Cell(cell), &[newton]) => self.cell_offset(cell, newton),
            ("cell_exponent", Place::Cell(cell), &[power]) => self.cell_exponent(cell, power),
            ("cell_saturation", Place::Cell(cell), &[level]) => self.cell_saturation(cell, level),
            ("time_delay", Place::Whole, &[delay]) => Ok(self.time_delay(delay)),
            // Strokes stay in metres.
            ("units", Place::Way("degrees"), []) => {
                self.at_revolute(|world, joint| world.joint_scale(joint, 1_f64.to_radians()))
            }
            ("units", Place::Way("millimetres"), []) => Ok(self.sensor_unit(1000.0)),
            ("units", Place::Way("centimetres"), []) => Ok(self.sensor_unit(100.0)),
            ("units", Place::Way("inches"), []) => Ok(self.sensor_unit(1.0 / 0.0254)),
            ("units", Place::Way("kilograms_force"), []) => Ok(self.sensor_unit(9.80665)),
            ("units", Place::Way("pounds_force"), []) => Ok(self.sensor_unit(4.448_221_615_260_5)),
            _ => Err(Problem::UnknownImperfection {
                name: name.to_owned(),
            }
            .into()),
        }
    }

    /// The robot with `act` done to every revolute joint that has an encoder.
    fn at_revolute(
        self,
        act: impl Fn(World, &str) -> Result<World, Error>,
    ) -> Result<World, Error> {
        let encoded = self.robot().movable_joints().take(self.dof());
        let revolute = encoded.filter(|joint| joint.kind != JointKind::Prismatic);
        let names: Vec<String> = revolute.map(|joint| joint.name.clone()).collect();
        names
            .iter()
            .try_fold(self, |world, joint| act(world, joint))
    }
}
