//! The context of a posture, and where the measurement takes it from.

use crate::robot::Robot;

/// Layout of what a posture has beside its joint positions, in this order:
/// place in the log, tilt (2), rates, accelerations, sides of dead bands.
#[derive(Debug, Clone, Copy)]
pub struct PostureContext {
    dof: usize,
}

impl PostureContext {
    /// The layout for a robot.
    pub fn of(robot: &Robot) -> PostureContext {
        PostureContext { dof: robot.dof() }
    }

    /// Of a robot with `dof` independent joints.
    pub fn with_joints(dof: usize) -> PostureContext {
        PostureContext { dof }
    }

    /// Entries per posture.
    pub fn len(self) -> usize {
        3 + 3 * self.dof
    }

    /// Always false, since a posture always has a tilt.
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

/// Where the measurement gets what does not follow from joint positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Source {
    /// A posture of a log, whose context is an input.
    Log,
    /// The same with sides by the gravity moments, as a posture alone has them.
    Resting,
    /// Any posture: level ground, standing still, sides by the gravity moments.
    Posture,
    /// Any posture, with the direction of gravity taken from its context.
    Tilted,
}
