//! The kinematic tree, re-rooted at the support link.
//!
//! Every joint becomes an [`Edge`] walked away from the support. A point x of
//! the far link is, in the near link,
//!
//! ```text
//! x_near = anchor + R Rot(axis, θ) (x_far − offset)        revolute
//! x_near = anchor + axis θ + R (x_far − offset)            prismatic
//! ```
//!
//! with θ = factor·q + offset. A joint between the URDF root and the support is
//! walked backwards: its origin moves to the far side and its angle changes sign.

mod dofs;
mod edge;
mod snaps;
mod sole;
mod supports;

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use crate::Error;
use crate::error::Problem;
use crate::snap::{self, Snapping};
use crate::text;
use crate::urdf::{self, Description, JointType};
use dofs::coordinates;
use edge::edge;
use snaps::snaps;

#[doc(hidden)]
pub use edge::{Coordinate, Edge, Motion};
#[doc(hidden)]
pub use snaps::snapped;
#[doc(hidden)]
pub use sole::{below, is_support, like_sole, sole_of, sole_parts};
#[doc(hidden)]
pub use supports::{feet, is_sole, on_many_feet, support_rank};

/// Velocities of joints that bounds of the ZMP hold for, rad/s and m/s.
#[doc(hidden)]
pub const MODERATE_SPEED: [f64; 2] = [1.0, 0.25];
/// Accelerations of joints that bounds of the ZMP hold for, rad/s² and m/s².
#[doc(hidden)]
pub const MODERATE_ACCELERATION: [f64; 2] = [10.0, 2.5];

/// A link: what it weighs and where.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Link {
    /// Its name in the URDF.
    pub name: String,
    /// kg
    pub mass: f64,
    /// Centre of mass in the link frame, m.
    pub(crate) com: Vector3<f64>,
    /// Inertia about the centre of mass in the axes of the link frame, kg m².
    pub(crate) inertia: Matrix3<f64>,
    /// No body of its mass and size has that inertia.
    pub(crate) inertia_is_refuted: bool,
}

impl Link {
    /// Centre of mass in the link frame, m.
    pub fn com(&self) -> [f64; 3] {
        self.com.into()
    }
}

/// An independent joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Dof {
    /// Its name.
    pub joint: String,
    /// Whether its position is in m.
    pub prismatic: bool,
    /// Whether it rotates without end or has no usable limits: its range is only
    /// what postures are drawn from.
    pub continuous: bool,
    /// rad or m
    pub lower: f64,
    /// rad or m
    pub upper: f64,
    /// Largest velocity that bounds hold for, rad/s or m/s: the URDF's, or what robots'
    /// joints stay below.
    pub speed: f64,
}

impl Dof {
    /// Lower and upper limit, rad or m; infinite where the joint has none.
    pub fn limits(&self) -> [f64; 2] {
        match self.continuous {
            true => [f64::NEG_INFINITY, f64::INFINITY],
            false => [self.lower, self.upper],
        }
    }
}

/// A right angle that was made exact.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Snap {
    /// Name of the joint.
    pub joint: String,
    /// Written against exact, rad.
    pub angle_error: f64,
    /// Largest CoM error, m.
    pub com_error: f64,
}

/// A robot standing on one link.
#[derive(Debug, Clone)]
pub struct Tree {
    /// Name of the robot.
    pub robot: String,
    /// [`Description::hash`]
    pub hash: String,
    /// [`Description::file`]
    pub file: String,
    /// In document order.
    #[doc(hidden)]
    pub links: Vec<Link>,
    /// Index of the support link.
    #[doc(hidden)]
    pub support: usize,
    /// The support is the sole of a link of the URDF, and none of its links.
    #[doc(hidden)]
    pub by_height: bool,
    /// In preorder; children in the document order of their joints.
    #[doc(hidden)]
    pub edges: Vec<Edge>,
    /// Independent joints in document order.
    pub dofs: Vec<Dof>,
    /// Total mass, kg.
    pub mass: f64,
    /// What snapping changed.
    pub snaps: Vec<Snap>,
    /// What was dropped, ignored or looks doubtful.
    pub notes: Vec<String>,
    /// Links that are feet by their names.
    #[doc(hidden)]
    pub feet: Vec<String>,
}

/// Whether so many joints move that finding what they determine would take too long.
fn check_size(robot: &Description) -> Result<(), Error> {
    let moving = || robot.joints.iter().filter(|j| j.joint_type.is_single());
    let tied = moving().any(|joint| joint.mimic.is_some());
    let most = match tied {
        true => urdf::limits::MOVING_WITH_MIMICS,
        false => urdf::limits::MOVING,
    };
    let (file, count) = (robot.file.clone(), moving().count());
    match count > most {
        true => Err(Problem::TooManyJoints {
            file,
            count,
            most,
            tied,
        }
        .into()),
        false => Ok(()),
    }
}

/// Re-root `description` at `support`, a link or the sole of one (`foot@40mm`: 40 mm below its
/// frame).
///
/// # Errors
/// When no link has that name, too many joints move, or mass hangs on a planar or floating
/// joint.
#[doc(hidden)]
pub fn reroot(description: &Description, support: &str, snapping: Snapping) -> Result<Tree, Error> {
    let standing = sole::standing(description, support)?;
    let robot = &*standing;
    let mut notes = description.notes.clone();
    let index: HashMap<&str, usize> = robot
        .links
        .iter()
        .enumerate()
        .map(|(i, link)| (link.name.as_str(), i))
        .collect();
    let support = index[support];
    check_size(robot)?;
    let of = |link: &urdf::Link| Link {
        name: link.name.clone(),
        mass: link.inertial.mass_kg,
        com: Vector3::from(link.inertial.origin.xyz),
        inertia: inertia(&link.inertial),
        inertia_is_refuted: false,
    };
    let mut links: Vec<Link> = robot.links.iter().map(of).collect();
    for (link, _) in description.refuted_inertias() {
        links[link].inertia_is_refuted = true;
    }

    let base = dofs::virtual_base(robot, Some(&robot.links[support].name));
    let (dofs, coordinates) = coordinates(robot, &base);
    if !base.is_empty() {
        notes.push(dropped(robot, &base));
    }
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (j, joint) in robot.joints.iter().enumerate() {
        neighbours[index[joint.parent.as_str()]].push(j);
        neighbours[index[joint.child.as_str()]].push(j);
    }

    // Depth first, on an explicit stack: chains may be thousands of links deep.
    let mut edges = Vec::new();
    let mut odd_rotations = Vec::new();
    let mut errors = Vec::new(); // rotation error of each edge, beside `edges`
    let mut seen = vec![false; links.len()];
    seen[support] = true;
    let mut stack: Vec<(usize, usize)> = neighbours[support]
        .iter()
        .rev()
        .map(|&j| (support, j))
        .collect();
    while let Some((near, j)) = stack.pop() {
        let joint = &robot.joints[j];
        let (parent, child) = (index[joint.parent.as_str()], index[joint.child.as_str()]);
        let reversed = near == child;
        let far = if reversed { parent } else { child };
        if seen[far] {
            continue;
        }
        if base.contains(&j) && joint.joint_type != JointType::Fixed {
            continue;
        }
        if matches!(joint.joint_type, JointType::Floating | JointType::Planar) {
            drop_beyond(robot, &links, &neighbours, &index, near, j, &mut notes)?;
            continue;
        }
        seen[far] = true;
        let (edge, error, odd) = edge(joint, near, far, reversed, coordinates[j], snapping);
        odd_rotations.extend(odd.map(|said| (far, said)));
        edges.push(edge);
        errors.push(error);
        stack.extend(
            neighbours[far]
                .iter()
                .rev()
                .filter(|&&k| k != j)
                .map(|&k| (far, k)),
        );
    }

    // Rotations of what has no mass enter no number.
    let mut carried: Vec<f64> = links.iter().map(|link| link.mass).collect();
    for edge in edges.iter().rev() {
        carried[edge.near] += carried[edge.far];
    }
    odd_rotations.retain(|(far, _)| carried[*far] > 0.0);
    notes.extend(odd_rotations.into_iter().map(|(_, said)| said));

    let mut tree = Tree {
        robot: description.name.clone(),
        hash: description.hash.clone(),
        file: description.file.clone(),
        mass: links
            .iter()
            .zip(&seen)
            .filter(|(_, seen)| **seen)
            .map(|(link, _)| link.mass)
            .sum(),
        by_height: links.len() > description.links.len(),
        links,
        support,
        edges,
        dofs,
        snaps: Vec::new(),
        notes,
        feet: supports::feet(description),
    };
    if tree.mass.is_nan() || tree.mass < urdf::limits::LEAST_KG {
        let file = tree.file.clone();
        return Err(Problem::NoMass { file }.into());
    }
    tree.snaps = snaps(&tree, &errors);
    // No advice along a z that is not up.
    let support = tree.links[tree.support].name.clone();
    let standing = sole::turned(description, &tree);
    tree.notes
        .extend(standing.or_else(|| below(description, &support)));
    Ok(tree)
}

/// What is said of the joints of a virtual base.
fn dropped(robot: &Description, base: &HashSet<usize>) -> String {
    let mut all: Vec<usize> = base.iter().copied().collect();
    all.sort_unstable();
    let joints = all.iter().map(|&k| &robot.joints[k]);
    let names: Vec<String> = joints
        .filter(|joint| joint.joint_type != JointType::Fixed)
        .map(|joint| format!("`{}`", joint.name))
        .collect();
    let (joint, them) = match names.len() {
        1 => ("joint", "it"),
        _ => ("joints", "them"),
    };
    let names = text::listed(names, 8);
    format!("{joint} {names} dropped: nothing beyond {them} has mass")
}

/// Inertia about the centre of mass in the axes of the link frame, kg m².
fn inertia(inertial: &urdf::Inertial) -> Matrix3<f64> {
    let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
    let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let turned = snap::rotation(inertial.origin.rpy, Snapping::Off).value;
    turned * own * turned.transpose()
}

/// A floating or planar joint may be cut when nothing beyond it weighs anything.
fn drop_beyond(
    robot: &Description,
    links: &[Link],
    neighbours: &[Vec<usize>],
    index: &HashMap<&str, usize>,
    near: usize,
    joint: usize,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    let other = |at: usize, j: usize| {
        let (parent, child) = (
            index[robot.joints[j].parent.as_str()],
            index[robot.joints[j].child.as_str()],
        );
        if at == parent { child } else { parent }
    };
    let name = &robot.joints[joint].name;
    let kind = robot.joints[joint].joint_type.name();
    let mut stack = vec![(other(near, joint), joint)];
    while let Some((link, from)) = stack.pop() {
        if links[link].mass > 0.0 {
            let beyond = Problem::MassBeyondFreeJoint {
                joint: name.clone(),
                kind,
                link: links[link].name.clone(),
            };
            return Err(beyond.into());
        }
        stack.extend(
            neighbours[link]
                .iter()
                .filter(|&&j| j != from)
                .map(|&j| (other(link, j), j)),
        );
    }
    notes.push(format!(
        "{kind} joint `{name}` dropped: nothing beyond it has mass"
    ));
    Ok(())
}

impl Dof {
    /// Largest velocity that the bound of the ZMP holds for, rad/s or m/s: where all joints
    /// move at once, the limits of servos would lift any robot off the ground.
    pub fn moderate_speed(&self) -> f64 {
        let [revolute, prismatic] = MODERATE_SPEED;
        self.speed
            .min(if self.prismatic { prismatic } else { revolute })
    }

    /// Largest acceleration that the bound of the ZMP holds for, rad/s² or m/s².
    pub fn moderate_acceleration(&self) -> f64 {
        let [revolute, prismatic] = MODERATE_ACCELERATION;
        if self.prismatic { prismatic } else { revolute }
    }
}

impl Tree {
    /// The CoM in the support frame where every joint is in the middle of its range, m.
    fn com_in_the_middle(&self) -> [f64; 3] {
        let none = (Matrix3::identity(), Vector3::zeros());
        let mut frames = vec![none; self.links.len()];
        let mut first = self.links[self.support].com * self.links[self.support].mass;
        let at = |by: &Coordinate| {
            let dof = &self.dofs[by.dof];
            by.factor * (0.5 * (dof.lower + dof.upper)) + by.offset
        };
        for edge in &self.edges {
            let (turned, origin) = frames[edge.near];
            let (own, moved) = match &edge.motion {
                Motion::Fixed => (Matrix3::identity(), Vector3::zeros()),
                Motion::Revolute { axis, by } => (snap::about(axis, at(by)), Vector3::zeros()),
                Motion::Prismatic { axis, by } => (Matrix3::identity(), axis * at(by)),
            };
            let place = origin + turned * (edge.anchor + moved);
            let turned = turned * edge.rotation * own;
            let frame = (turned, place - turned * edge.offset);
            let link = &self.links[edge.far];
            first += (frame.1 + turned * link.com) * link.mass;
            frames[edge.far] = frame;
        }
        (first / self.mass).into()
    }

    /// Largest |θ| of a coordinate over the limits of its joint, rad or m.
    pub(crate) fn stroke(&self, by: &Coordinate) -> f64 {
        let dof = &self.dofs[by.dof];
        let at = |q: f64| libm::fabs(by.factor * q + by.offset);
        at(dof.lower).max(at(dof.upper))
    }
}
