//! Imperfections that the library of effects does not know.
//!
//! ```text
//! hanging load     m at  T_l x + length ĝ                 a string has a vertical line of action
//! loose mass       m at  T_l (x + half tanh(d / 0.17) e)  d = e along gravity, the rod's slope
//! cable            τ_j = -k max(0, φ_j - taut)            pulls back once it is taut
//! bending link     a hinge without encoder in front of a joint, held by a spring
//! sine             y += amplitude sin(n q_j)              an error of the CoP, from nowhere
//! ```

use nalgebra::{Point3, Unit, Vector2, Vector3};

use crate::com::Reference;
use crate::error::Error;
use crate::joint::Pose;

use super::World;
use super::statics::{Cable, Yielding, above_zero, moved_links};

/// A slope of its rod that takes a loose mass three quarters of the way, rad.
const LOOSE: f64 = 0.17;

#[derive(Debug, Clone, Default)]
pub(super) struct Unmodelled {
    hanging: Vec<Hanging>,
    loose: Vec<Loose>,
    sines: Vec<Sine>,
}

#[derive(Debug, Clone)]
struct Hanging {
    link: usize,
    mass_kg: f64,
    at_m: Point3<f64>,
    string_m: f64,
}

#[derive(Debug, Clone)]
struct Loose {
    link: usize,
    mass_kg: f64,
    at_m: Point3<f64>,
    rod: Unit<Vector3<f64>>,
    half_m: f64,
}

#[derive(Debug, Clone)]
struct Sine {
    channel: usize,
    harmonic: f64,
    amplitude_m: Vector2<f64>,
}

/// A mass that is not fixed to the link that carries it.
pub(super) struct Carried {
    pub link: usize,
    pub at_m: Point3<f64>,
    pub mass_kg: f64,
}

impl Unmodelled {
    pub(super) fn carries_nothing(&self) -> bool {
        self.hanging.is_empty() && self.loose.is_empty()
    }

    /// The CoP's error when the encoders read `q`, m.
    pub(super) fn sine(&self, q: &[f64]) -> Vector2<f64> {
        let errors = self.sines.iter();
        errors
            .map(|sine| sine.amplitude_m * (sine.harmonic * q[sine.channel]).sin())
            .sum()
    }
}

impl World {
    /// A load (kg) hangs at `at_m` of a link's frame on a string of this
    /// length. The CoP cannot tell it from a payload at its hinge.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Value` unless its mass is above zero.
    pub fn hanging_load(
        mut self,
        link: &str,
        mass_kg: f64,
        at_m: [f64; 3],
        string_m: f64,
    ) -> Result<Self, Error> {
        self.unmodelled.hanging.push(Hanging {
            link: self.robot().link_index(link)?,
            mass_kg: above_zero("hanging mass", mass_kg)?,
            at_m: Point3::from(at_m),
            string_m,
        });
        Ok(self)
    }

    /// A mass (kg) slides on a rod of a link: `half_m` to both sides of `at_m`
    /// along `rod`, both in the link's frame. A slope of the rod takes it down;
    /// friction keeps it from the end until the rod is steep.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Value` unless its mass is above zero.
    pub fn loose_mass(
        mut self,
        link: &str,
        mass_kg: f64,
        at_m: [f64; 3],
        rod: [f64; 3],
        half_m: f64,
    ) -> Result<Self, Error> {
        let rod = Vector3::from(rod);
        self.unmodelled.loose.push(Loose {
            link: self.robot().link_index(link)?,
            mass_kg: above_zero("loose mass", mass_kg)?,
            at_m: Point3::from(at_m),
            rod: Unit::new_unchecked(rod / above_zero("length of the rod's axis", rod.norm())?),
            half_m,
        });
        Ok(self)
    }

    /// A cable across the joint is slack up to `taut` (rad or m) and pulls back
    /// beyond, N m/rad or N/m. The joint follows where it is
    /// [soft](World::joint_compliance) or [loose](World::backlash). It replaces
    /// an earlier one.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`; `ErrorKind::Value` unless it is above zero.
    pub fn cable(mut self, joint: &str, stiffness: f64, taut: f64) -> Result<Self, Error> {
        let j = self.encoder(joint)?;
        self.yielding[j].cable = Some(Cable {
            stiffness: above_zero("stiffness", stiffness)?,
            taut,
        });
        Ok(self)
    }

    /// The link that carries the joint bends where the joint sits on it, about
    /// `axis` of the joint's frame: N m/rad.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`; `ErrorKind::Value` unless the stiffness and the
    /// axis are above zero.
    pub fn bending_link(
        mut self,
        joint: &str,
        axis: [f64; 3],
        stiffness: f64,
    ) -> Result<Self, Error> {
        let compliance = 1.0 / above_zero("stiffness", stiffness)?;
        let axis = Vector3::from(axis);
        let axis = Unit::new_unchecked(axis / above_zero("length of the axis", axis.norm())?);
        let robot = self.robot().with_hinge(joint, axis)?;
        self.reference = Reference::new(&robot, self.reference.support())?;
        let support = robot.link_index(self.reference.support())?;
        self.moved = moved_links(&robot, support);
        self.yielding.push(Yielding {
            compliance,
            ..Yielding::default()
        });
        Ok(self)
    }

    /// The reading is wrong by `amplitude_m · sin(harmonic · q)` of one joint.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`.
    pub fn cop_sine(
        mut self,
        joint: &str,
        harmonic: f64,
        amplitude_m: [f64; 2],
    ) -> Result<Self, Error> {
        self.unmodelled.sines.push(Sine {
            channel: self.encoder(joint)?,
            harmonic,
            amplitude_m: Vector2::from(amplitude_m),
        });
        Ok(self)
    }

    /// The masses that are not fixed to their links, where they are now.
    pub(super) fn carried(&self, poses: &[Pose]) -> Vec<Carried> {
        let down = self.gravity.normalize();
        let hanging = self.unmodelled.hanging.iter().map(|load| Carried {
            link: load.link,
            at_m: poses[load.link] * load.at_m + down * load.string_m,
            mass_kg: load.mass_kg,
        });
        let loose = self.unmodelled.loose.iter().map(|load| {
            let pose = poses[load.link];
            let slope = (pose.rotation * load.rod.into_inner()).dot(&down);
            let slid = load.rod.into_inner() * (load.half_m * (slope / LOOSE).tanh());
            Carried {
                link: load.link,
                at_m: pose * (load.at_m + slid),
                mass_kg: load.mass_kg,
            }
        });
        hanging.chain(loose).collect()
    }
}
