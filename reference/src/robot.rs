//! A robot as its URDF describes it: a tree of links, joined by joints.
//!
//! ```text
//! T_child = T_parent O_j X_j(q_j)
//! O_j     = Trans(xyz) Rot_z(yaw) Rot_y(pitch) Rot_x(roll)
//! q_j     = multiplier q_master + offset        where joint j mimics another
//! ```
//!
//! The axis of the motion `X_j` is a unit vector in the joint frame, the frame
//! after `O_j`. The numbers are those of the file, to the last bit; only axes
//! are brought to length one and quaternions to matrices.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use crate::error::{Error, Problem};
use crate::joint::{Joint, JointKind, Link, Pose};
use crate::tree::{Coordinate, join, resolve_mimics, sort_from_root};

/// A robot: one tree of links.
///
/// The *posture* `q` of a robot has one entry for every revolute, continuous
/// or prismatic joint that mimics no other, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    name: String,
    links: Vec<Link>,
    joints: Vec<Joint>,
    /// Joints, every parent link before its children.
    order: Vec<usize>,
    /// The joints that are entries of the posture.
    movable: Vec<usize>,
    coordinates: Vec<Coordinate>,
}

impl Robot {
    /// Puts links and joints together and checks that they are one tree. A
    /// mimic on a joint without a coordinate is dropped.
    ///
    /// # Errors
    /// `ErrorKind::NoLinks`, `ErrorKind::NotATree`, and the mimic errors.
    ///
    /// # Panics
    /// Where a joint's link index is out of range.
    pub fn new(name: String, links: Vec<Link>, mut joints: Vec<Joint>) -> Result<Self, Error> {
        for joint in &mut joints {
            if !joint.kind.has_coordinate() {
                joint.mimic = None;
            }
        }
        let order = sort_from_root(&links, &joints)?;
        let movable: Vec<usize> = (0..joints.len())
            .filter(|&j| joints[j].kind.has_coordinate() && joints[j].mimic.is_none())
            .collect();
        let coordinates = resolve_mimics(&joints, &movable)?;
        Ok(Self {
            name,
            links,
            joints,
            order,
            movable,
            coordinates,
        })
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The links, in the order of the file.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The joints, in the order of the file.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The joints that are entries of the posture, in its order.
    pub fn movable_joints(&self) -> impl ExactSizeIterator<Item = &Joint> {
        self.movable.iter().map(|&j| &self.joints[j])
    }

    /// For every joint (in the order of the file) how the posture moves it.
    pub fn coordinates(&self) -> &[Coordinate] {
        &self.coordinates
    }

    /// Indices of the joints, every parent link before its children.
    pub(crate) fn joints_from_root(&self) -> &[usize] {
        &self.order
    }

    /// Index of a link.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`.
    pub fn link_index(&self, name: &str) -> Result<usize, Error> {
        let found = self.links.iter().position(|link| link.name == name);
        found.ok_or_else(|| {
            Problem::UnknownLink {
                name: name.to_owned(),
                links: join(self.links.iter().map(|link| link.name.as_str())),
            }
            .into()
        })
    }

    /// The robot with the frame that `support` names where that is none of its links:
    /// `foot@40mm` is 40 mm below the frame of `foot`, along its −z.
    pub(crate) fn with_sole(&self, support: &str) -> Result<Robot, Error> {
        let sole = support
            .strip_suffix("mm")
            .and_then(|name| name.rsplit_once('@'));
        let sole = sole.and_then(|(link, mm)| Some((link, mm.parse::<f64>().ok()?)));
        let Some((link, mm)) = sole.filter(|_| self.link_index(support).is_err()) else {
            return Ok(self.clone());
        };
        let (mut links, mut joints) = (self.links.clone(), self.joints.clone());
        joints.push(Joint {
            name: support.to_owned(),
            kind: JointKind::Fixed,
            parent: self.link_index(link)?,
            child: links.len(),
            origin: Pose::translation(0.0, 0.0, -mm / 1000.0),
            axis: Vector3::x_axis(),
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            mimic: None,
        });
        links.push(Link {
            name: support.to_owned(),
            mass_kg: 0.0,
            com_m: Point3::origin(),
            inertia_kg_m2: Matrix3::zeros(),
        });
        Robot::new(self.name.clone(), links, joints)
    }

    /// Index of a joint in the posture.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`, also for joints without an entry of their own.
    pub fn dof_index(&self, name: &str) -> Result<usize, Error> {
        let found = self.movable_joints().position(|joint| joint.name == name);
        found.ok_or_else(|| {
            Problem::UnknownJoint {
                name: name.to_owned(),
                joints: join(self.movable_joints().map(|joint| joint.name.as_str())),
            }
            .into()
        })
    }

    /// The poses of all links in the frame of the URDF's root link, by forward
    /// kinematics from the root outwards. Free joints stand at their origin.
    ///
    /// # Panics
    /// Where `q` has not one entry per movable joint.
    pub fn poses_in_root(&self, q: &[f64]) -> Vec<Pose> {
        assert_eq!(
            q.len(),
            self.movable.len(),
            "a posture of `{}` has one entry per movable joint",
            self.name
        );
        let mut poses = vec![Pose::identity(); self.links.len()];
        for &j in &self.order {
            let joint = &self.joints[j];
            poses[joint.child] = poses[joint.parent] * self.local(j, q);
        }
        poses
    }

    /// The pose of the link beyond joint `j` in the frame of the one before it.
    pub(crate) fn local(&self, j: usize, q: &[f64]) -> Pose {
        let joint = &self.joints[j];
        let Coordinate {
            dof,
            factor,
            offset,
        } = self.coordinates[j];
        let position = dof.map_or(offset, |dof| factor * q[dof] + offset);
        joint.origin * joint.motion(position)
    }

    /// The same robot with a point mass fixed to a link at `at_m` of its
    /// frame; a negative mass takes away.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Payload` where nothing remains.
    pub fn with_point_mass(&self, link: &str, mass_kg: f64, at_m: [f64; 3]) -> Result<Self, Error> {
        let mut robot = self.clone();
        let link = &mut robot.links[self.link_index(link)?];
        let left_kg = link.mass_kg + mass_kg;
        if mass_kg == 0.0 && left_kg == 0.0 {
            return Ok(robot);
        }
        if !(left_kg > 0.0 && left_kg.is_finite()) {
            return Err(Problem::Payload {
                link: link.name.clone(),
                payload_kg: mass_kg,
                left_kg,
            }
            .into());
        }
        *link = link.with_point(mass_kg, Vector3::from(at_m));
        Ok(robot)
    }

    /// The same robot with another mass and centre of mass of a link, whose inertia about
    /// it grows as the mass does.
    ///
    /// # Errors
    /// `ErrorKind::UnknownLink`; `ErrorKind::Mass`.
    pub fn with_mass(&self, link: &str, mass_kg: f64, com_m: Point3<f64>) -> Result<Self, Error> {
        let mut robot = self.clone();
        let link = &mut robot.links[self.link_index(link)?];
        if mass_kg < 0.0 {
            return Err(Problem::Mass {
                link: link.name.clone(),
                mass_kg,
            }
            .into());
        }
        if link.mass_kg > 0.0 {
            link.inertia_kg_m2 *= mass_kg / link.mass_kg;
        }
        (link.mass_kg, link.com_m) = (mass_kg, com_m);
        Ok(robot)
    }

    /// The same robot whose posture has the joints of these names alone, in the order of the file;
    /// the others that move by themselves are held at zero.
    ///
    /// # Errors
    /// As [`new`](Self::new), where a joint follows one that is held.
    pub fn moved_by(&self, names: &[&str]) -> Result<Self, Error> {
        let mut joints = self.joints.clone();
        for &at in &self.movable {
            if !names.contains(&joints[at].name.as_str()) {
                joints[at].kind = JointKind::Fixed;
            }
        }
        Self::new(self.name.clone(), self.links.clone(), joints)
    }

    /// The same robot with a hinge between a joint and the link it sits on,
    /// about `axis` of the joint's frame: the last entry of the posture.
    ///
    /// # Errors
    /// `ErrorKind::UnknownJoint`; `ErrorKind::Duplicate` where the joint has one.
    pub fn with_hinge(&self, joint: &str, axis: Unit<Vector3<f64>>) -> Result<Self, Error> {
        let at = self.movable[self.dof_index(joint)?];
        let (mut links, mut joints) = (self.links.clone(), self.joints.clone());
        let name = format!("{joint} hinge");
        if joints.iter().any(|joint| joint.name == name) {
            return Err(Problem::Duplicate {
                place: format!("joint `{name}`"),
            }
            .into());
        }
        let seat = links.len();
        links.push(Link {
            name: format!("{joint} seat"),
            mass_kg: 0.0,
            com_m: Point3::origin(),
            inertia_kg_m2: Matrix3::zeros(),
        });
        let (parent, origin) = (joints[at].parent, joints[at].origin);
        (joints[at].parent, joints[at].origin) = (seat, Pose::identity());
        joints.push(Joint {
            name,
            kind: JointKind::Continuous,
            parent,
            child: seat,
            origin,
            axis,
            limits: (f64::NEG_INFINITY, f64::INFINITY),
            mimic: None,
        });
        Self::new(self.name.clone(), links, joints)
    }
}
