//! The context of a posture, and where the measurement takes it from.

use crate::robot::Robot;

/// Layout of what a posture has beside its joint positions, in this order:
/// place in the log, tilt (2), what motion adds (2), its first and second derivative in time (2
/// each), lift, time, velocities, accelerations, sides of dead bands, slopes of what motion adds (2
/// per joint), sides of approach.
#[derive(Debug, Clone, Copy)]
pub struct PostureContext {
    dof: usize,
}

impl PostureContext {
    /// The layout for a robot.
    pub fn of(robot: &Robot) -> PostureContext {
        PostureContext { dof: robot.dof() }
    }

    /// The context of a robot with `dof` independent joints.
    pub fn with_joints(dof: usize) -> PostureContext {
        PostureContext { dof }
    }

    /// Entries per posture.
    pub fn len(self) -> usize {
        11 + 6 * self.dof
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

    /// What motion adds to the CoP on an axis, m: the ZMP less what a standing robot shows.
    pub fn shift(self, axis: usize) -> usize {
        3 + axis
    }

    /// How fast what motion adds changes on an axis, m/s (`order` 1), and how fast that does,
    /// m/s² (2), beside what [`PostureContext::shift_slope`] makes of velocities and
    /// accelerations.
    pub fn shift_in_time(self, order: usize, axis: usize) -> usize {
        3 + 2 * order + axis
    }

    /// How the CoM is accelerated upwards, over gravity.
    pub fn lift(self) -> usize {
        9
    }

    /// Time since the first posture of the log, s.
    pub fn time(self) -> usize {
        10
    }

    /// Velocity of a joint, rad/s or m/s.
    pub fn rate(self, dof: usize) -> usize {
        11 + dof
    }

    /// Acceleration of a joint, rad/s² or m/s².
    pub fn acceleration(self, dof: usize) -> usize {
        11 + self.dof + dof
    }

    /// Which side of its dead band a joint rests on, −1 to 1.
    pub fn side(self, dof: usize) -> usize {
        11 + 2 * self.dof + dof
    }

    /// How what motion adds to the CoP on an axis changes with the position of a joint, m/rad
    /// or 1.
    pub fn shift_slope(self, dof: usize, axis: usize) -> usize {
        11 + 3 * self.dof + 2 * dof + axis
    }

    /// Side from which a joint came to where it stands, −1 to 1.
    pub fn approach(self, dof: usize) -> usize {
        11 + 5 * self.dof + dof
    }
}

/// Where the measurement gets what does not follow from joint positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ContextSource {
    /// A posture of a log, whose context is an input.
    Log,
    /// The same with sides by the gravity moments, as a posture alone has them.
    Resting,
    /// Any posture: level ground, standing still, sides by the gravity moments.
    Posture,
    /// Any posture, with the direction of gravity and what motion adds from its context.
    Tilted,
}
