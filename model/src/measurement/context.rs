//! What a posture brings along, and where the measurement takes it from.

use crate::robot::Robot;

/// What a posture brings along beside its joint positions, in this order:
/// place in the log, tilt (2), rates, accelerations, sides of dead bands.
#[derive(Debug, Clone, Copy)]
pub struct Circumstances {
    dof: usize,
}

impl Circumstances {
    /// The layout for a robot.
    pub fn of(robot: &Robot) -> Circumstances {
        Circumstances { dof: robot.dof() }
    }

    /// Of a robot with `dof` independent joints.
    pub fn with_joints(dof: usize) -> Circumstances {
        Circumstances { dof }
    }

    /// Entries per posture.
    pub fn len(self) -> usize {
        3 + 3 * self.dof
    }

    /// Never: tilt is always there.
    pub fn is_empty(self) -> bool {
        false
    }

    /// Place in the log: 0 at its first posture, 1 at its last.
    pub fn place(self) -> usize {
        0
    }

    /// Gravity's direction: `-g_x / g_z` (axis 0), `-g_y / g_z` (axis 1).
    pub fn tilt(self, axis: usize) -> usize {
        1 + axis
    }

    /// Velocity of a joint, rad/s or m/s.
    pub fn rate(self, dof: usize) -> usize {
        3 + dof
    }

    /// Acceleration of a joint, rad/s² or m/s².
    pub fn acceleration(self, dof: usize) -> usize {
        3 + self.dof + dof
    }

    /// Which side of its dead band a joint rests on, −1 to 1.
    pub fn side(self, dof: usize) -> usize {
        3 + 2 * self.dof + dof
    }
}

/// Where the measurement gets what its posture alone does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A posture of a log: circumstances are inputs.
    Log,
    /// Any posture: level ground, standing still, sides by the gravity moments.
    Posture,
    /// Any posture, with gravity's direction from its circumstances.
    Tilted,
}
