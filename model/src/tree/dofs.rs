//! Independent joints, and how each joint follows one: q_j = factor q_i + offset.

use std::collections::HashMap;

use super::{Coordinate, Dof};
use crate::urdf::{self, Description, JointType};

/// Range assumed for a revolute joint without usable limits, rad.
const FREE_REVOLUTE_RAD: f64 = std::f64::consts::PI;
/// Range assumed for a prismatic joint without usable limits, m.
const FREE_PRISMATIC_M: f64 = 1.0;
/// Velocity of a revolute joint whose URDF states none: about two turns a second.
const FREE_SPEED_RAD_PER_S: f64 = 12.0;
/// Velocity of such a prismatic joint.
const FREE_SPEED_M_PER_S: f64 = 2.0;

/// Limits this far out mean none, rad or m.
const ENDLESS: f64 = 1e3;

impl Description {
    /// The independent joints in document order: the same on every support.
    pub fn dofs(&self) -> Vec<Dof> {
        coordinates(self).0
    }
}

/// Independent joints, and every joint's position in terms of them.
///
/// `None` for joints that do not move; a mimic of a fixed joint stands at its offset.
pub(super) fn coordinates(robot: &Description) -> (Vec<Dof>, Vec<Option<Coordinate>>) {
    let moves = |joint: &urdf::Joint| joint.joint_type.is_single();
    let mut dofs = Vec::new();
    let mut own: HashMap<&str, usize> = HashMap::new();
    for joint in &robot.joints {
        if moves(joint) && joint.mimic.is_none() {
            own.insert(&joint.name, dofs.len());
            dofs.push(dof(joint));
        }
    }
    let by_name: HashMap<&str, &urdf::Joint> =
        robot.joints.iter().map(|j| (j.name.as_str(), j)).collect();
    let coordinates = robot
        .joints
        .iter()
        .map(|joint| {
            if !moves(joint) {
                return None;
            }
            let (mut factor, mut offset, mut at) = (1.0, 0.0, joint);
            // The reader refuses cycles, so this ends.
            while let Some(mimic) = at.mimic.as_ref().filter(|_| moves(at)) {
                offset += factor * mimic.offset;
                factor *= mimic.multiplier;
                at = by_name[mimic.joint.as_str()];
            }
            let still = Coordinate {
                dof: 0,
                factor: 0.0,
                offset,
            };
            Some(own.get(at.name.as_str()).map_or(still, |&dof| Coordinate {
                dof,
                factor,
                offset,
            }))
        })
        .collect();
    (dofs, coordinates)
}

fn dof(joint: &urdf::Joint) -> Dof {
    let prismatic = joint.joint_type == JointType::Prismatic;
    let free = if prismatic {
        FREE_PRISMATIC_M
    } else {
        FREE_REVOLUTE_RAD
    };
    let limit = &joint.limit;
    // Files write "free" as infinities, as 1e16, or by swapping the ends.
    let usable = limit.lower < limit.upper && -limit.lower < ENDLESS && limit.upper < ENDLESS;
    let (lower, upper) = if usable && joint.joint_type != JointType::Continuous {
        (limit.lower, limit.upper)
    } else {
        (-free, free)
    };
    Dof {
        joint: joint.name.clone(),
        prismatic,
        continuous: !prismatic && (joint.joint_type == JointType::Continuous || !usable),
        lower,
        upper,
        speed: match limit.velocity {
            speed if speed > 0.0 && speed < ENDLESS => speed,
            _ if prismatic => FREE_SPEED_M_PER_S,
            _ => FREE_SPEED_RAD_PER_S,
        },
    }
}
