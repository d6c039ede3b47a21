//! Eq. (3), link by link.
//!
//! ```text
//! [CoM]           [c_l]
//! [ 1 ] = Σ m_l T_l [ 1 ] / M        T_l = S⁻¹ P_l,  M = Σ m_l
//! ```
//!
//! `P_l` is the pose of link `l` in the frame of the URDF's root, found by
//! forward kinematics along the file's own parents and children; `S` is that
//! of the support link. The tree is never re-rooted: standing on another link
//! changes `S` and nothing else.
//!
//! A floating or planar joint has no entry in the posture. What lies beyond it
//! as seen from the support has no known place, so it must have no mass; it is
//! then left out. Poses across the joint use its origin, which cancels in
//! `S⁻¹ P_l` for every link on the support's side.

use nalgebra::{Point3, Vector3};

use crate::error::{Error, Problem};
use crate::joint::Pose;
use crate::robot::Robot;

/// A robot with one link held fixed: the yardstick.
///
/// Every position is in the frame of the support link, metres. A posture `q`
/// has one entry per [joint name](Reference::joint_names), rad or m; the
/// functions of a posture panic where its length differs.
#[derive(Debug, Clone)]
pub struct Reference {
    pub(crate) robot: Robot,
    pub(crate) support: usize,
    total_mass_kg: f64,
    /// For every link, the free joint between it and the support, if any.
    beyond: Vec<Option<usize>>,
}

impl Reference {
    /// Stands a robot on a link, or on the sole below one (`foot@40mm`).
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::MassBeyondFreeJoint` where mass has no
    /// known place; `ErrorKind::NoMass`.
    pub fn new(robot: &Robot, support: &str) -> Result<Self, Error> {
        let robot = robot.with_sole(support)?;
        let support_index = robot.link_index(support)?;
        let beyond = find_free_joints(&robot, support_index);
        for (link, joint) in robot.links().iter().zip(&beyond) {
            if let (Some(joint), true) = (*joint, link.mass_kg != 0.0) {
                let joint = &robot.joints()[joint];
                return Err(Problem::MassBeyondFreeJoint {
                    link: link.name.clone(),
                    joint: joint.name.clone(),
                    kind: joint.kind.as_str(),
                    support: support.to_owned(),
                }
                .into());
            }
        }
        let total_mass_kg: f64 = robot.links().iter().map(|link| link.mass_kg).sum();
        if total_mass_kg == 0.0 {
            return Err(Problem::NoMass.into());
        }
        Ok(Self {
            robot,
            support: support_index,
            total_mass_kg,
            beyond,
        })
    }

    /// The robot that stands here.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The name of the link that is held fixed.
    pub fn support(&self) -> &str {
        &self.robot.links()[self.support].name
    }

    /// The number of entries in a posture.
    pub fn dof(&self) -> usize {
        self.robot.movable_joints().len()
    }

    /// The joints behind the entries of a posture: every revolute, continuous
    /// or prismatic joint that mimics no other, in the order of the file. The
    /// same for every support.
    pub fn joint_names(&self) -> Vec<&str> {
        let joints = self.robot.movable_joints();
        joints.map(|joint| joint.name.as_str()).collect()
    }

    /// For every entry of a posture a range with some width, rad or m; see
    /// [`Joint::range`](crate::Joint::range).
    pub fn limits(&self) -> Vec<(f64, f64)> {
        self.robot
            .movable_joints()
            .map(|joint| joint.range())
            .collect()
    }

    /// The robot's mass `M`, kg.
    pub fn total_mass(&self) -> f64 {
        self.total_mass_kg
    }

    /// True where the link's place is known from the support, that is where no
    /// floating or planar joint lies between.
    pub fn is_placed(&self, link: usize) -> bool {
        self.beyond[link].is_none()
    }

    /// The centre of mass by Eq. (3), m.
    pub fn com(&self, q: &[f64]) -> Vector3<f64> {
        let poses = self.robot.poses_in_root(q);
        let mut moment = Vector3::zeros();
        for (link, pose) in self.robot.links().iter().zip(&poses) {
            moment += link.mass_kg * (pose * link.com_m).coords;
        }
        let in_root = Point3::from(moment / self.total_mass_kg);
        poses[self.support].inverse_transform_point(&in_root).coords
    }

    /// The transforms `T_l` of all links, in the order of the file. Links whose
    /// place [is not known](Reference::is_placed) are shown with their free
    /// joint at its origin.
    pub fn link_poses(&self, q: &[f64]) -> Vec<Pose> {
        let poses = self.robot.poses_in_root(q);
        let to_support = poses[self.support].inverse();
        poses.iter().map(|pose| to_support * pose).collect()
    }
}

/// For every link the first free joint met on the way to it from the support.
fn find_free_joints(robot: &Robot, support: usize) -> Vec<Option<usize>> {
    let mut neighbours = vec![Vec::new(); robot.links().len()];
    for (j, joint) in robot.joints().iter().enumerate() {
        neighbours[joint.parent].push((j, joint.child));
        neighbours[joint.child].push((j, joint.parent));
    }
    let mut beyond = vec![None; robot.links().len()];
    let mut open = vec![(support, support)];
    while let Some((link, from)) = open.pop() {
        for &(j, next) in &neighbours[link] {
            if next == from {
                continue;
            }
            let free = robot.joints()[j].kind.is_free().then_some(j);
            beyond[next] = beyond[link].or(free);
            open.push((next, link));
        }
    }
    beyond
}
