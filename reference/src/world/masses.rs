//! Masses that are not as the URDF has them.
//!
//! ```text
//! m' = m + Δm,  c' = (m c + Δm x) / m'      a payload at x; below zero it is missing
//! m' = factor m,  c' = c + shift            a link that was described wrongly
//! ```

use nalgebra::Vector3;

use crate::com::Reference;
use crate::error::Error;
use crate::robot::Robot;

use super::World;

impl World {
    /// A link carries a point mass (kg) that its URDF does not know, at `at_m`
    /// of the link's frame; a negative mass is missing from the link.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Payload` where nothing of the link
    /// remains; `ErrorKind::MassBeyondFreeJoint`.
    pub fn payload(self, link: &str, mass_kg: f64, at_m: [f64; 3]) -> Result<Self, Error> {
        let robot = self.robot().with_point_mass(link, mass_kg, at_m)?;
        self.made_of(robot)
    }

    /// A link has `factor` times its mass, and its centre of mass lies
    /// `shift_m` further, in the link's frame.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Value` unless the factor is above
    /// zero.
    pub fn link_mass(self, link: &str, factor: f64, shift_m: [f64; 3]) -> Result<Self, Error> {
        let factor = super::statics::above_zero("mass factor", factor)?;
        let at = self.robot().link_index(link)?;
        let described = &self.robot().links()[at];
        let (mass_kg, com_m) = (
            described.mass_kg * factor,
            described.com_m + Vector3::from(shift_m),
        );
        let robot = self.robot().with_mass(link, mass_kg, com_m)?;
        self.made_of(robot)
    }

    /// The same imperfections on a robot of the same tree.
    fn made_of(mut self, robot: Robot) -> Result<Self, Error> {
        self.reference = Reference::new(&robot, self.reference.support())?;
        Ok(self)
    }
}
