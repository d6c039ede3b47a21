//! Independent joints, and how each joint follows one: q_j = factor q_i + offset.

use std::collections::{HashMap, HashSet};

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
    /// The independent joints of the file in its order, those of a virtual base among them.
    pub fn dofs(&self) -> Vec<Dof> {
        coordinates(self, &HashSet::new()).0
    }

    /// Whether the robot has fewer joints on its feet than in the file.
    #[doc(hidden)]
    pub fn has_virtual_base(&self) -> bool {
        !virtual_base(self, None).is_empty()
    }

    /// The independent joints in the order of the file, without those of a virtual base: the same
    /// on every support that the base carries, of which one is meant where none is given.
    pub fn dofs_on(&self, support: Option<&str>) -> Vec<Dof> {
        coordinates(self, &virtual_base(self, support)).0
    }
}

/// The joints of a virtual base, by their index: those between the URDF's root and all that has
/// mass, and whatever else hangs there, where the robot stands on neither of them and none of the
/// robot's joints follows one of theirs. No robot has encoders there.
pub(super) fn virtual_base(robot: &Description, support: Option<&str>) -> HashSet<usize> {
    let index: HashMap<&str, usize> = robot.link_names().zip(0..).collect();
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    let mut carried = vec![false; robot.links.len()];
    for (k, joint) in robot.joints.iter().enumerate() {
        below[index[joint.parent.as_str()]].push(k);
        carried[index[joint.child.as_str()]] = true;
    }
    let Some(mut at) = carried.iter().position(|carried| !carried) else {
        return HashSet::new();
    };
    // Down from the root, as long as one joint alone carries what has mass.
    let (mut base, mut last, mut passed) = (Vec::new(), HashSet::new(), HashSet::new());
    let has_mass = has_mass_below(robot, &index, &below);
    while robot.links[at].inertial.mass_kg == 0.0 {
        passed.insert(robot.links[at].name.as_str());
        let (heavy, light): (Vec<usize>, Vec<usize>) = below[at]
            .iter()
            .partition(|&&k| has_mass[index[robot.joints[k].child.as_str()]]);
        let [one] = heavy[..] else { break };
        let mut stack = light;
        while let Some(k) = stack.pop() {
            let child = index[robot.joints[k].child.as_str()];
            passed.insert(robot.links[child].name.as_str());
            base.push(k);
            stack.extend(&below[child]);
        }
        base.push(one);
        if robot.joints[one].joint_type != JointType::Fixed {
            // What lies beyond a joint that moves is no part of the robot.
            last = base.iter().copied().collect();
            if support.is_some_and(|support| super::is_support(support, passed.iter().copied())) {
                return HashSet::new();
            }
        }
        at = index[robot.joints[one].child.as_str()];
    }
    let names: HashSet<&str> = last
        .iter()
        .map(|k| robot.joints[*k].name.as_str())
        .collect();
    let mut others = (0..robot.joints.len()).filter(|k| !last.contains(k));
    let follows = |k: usize| {
        robot.joints[k]
            .mimic
            .as_ref()
            .is_some_and(|m| names.contains(m.joint.as_str()))
    };
    match others.any(follows) {
        true => HashSet::new(),
        false => last,
    }
}

/// Whether a link or one that it carries has mass.
fn has_mass_below(
    robot: &Description,
    index: &HashMap<&str, usize>,
    below: &[Vec<usize>],
) -> Vec<bool> {
    let mut has: Vec<bool> = robot
        .links
        .iter()
        .map(|l| l.inertial.mass_kg > 0.0)
        .collect();
    // Children before their parents: an order from every root, reversed.
    let mut order = Vec::with_capacity(robot.links.len());
    let carried: HashSet<usize> = robot
        .joints
        .iter()
        .map(|j| index[j.child.as_str()])
        .collect();
    order.extend((0..robot.links.len()).filter(|k| !carried.contains(k)));
    let mut next = 0;
    while let Some(&link) = order.get(next) {
        order.extend(
            below[link]
                .iter()
                .map(|k| index[robot.joints[*k].child.as_str()]),
        );
        next += 1;
    }
    for &link in order.iter().rev() {
        has[link] |= below[link]
            .iter()
            .any(|k| has[index[robot.joints[*k].child.as_str()]]);
    }
    has
}

/// Independent joints, without those of a virtual base, and every joint's position in terms of them.
///
/// `None` for joints that do not move; a mimic of a fixed joint stands at its offset.
pub(super) fn coordinates(
    robot: &Description,
    base: &HashSet<usize>,
) -> (Vec<Dof>, Vec<Option<Coordinate>>) {
    let moves = |joint: &urdf::Joint| joint.joint_type.is_single();
    let mut dofs = Vec::new();
    let mut own: HashMap<&str, usize> = HashMap::new();
    for (k, joint) in robot.joints.iter().enumerate() {
        if moves(joint) && joint.mimic.is_none() && !base.contains(&k) {
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
