//! Reads a URDF's kinematics and masses by urdf-rs, which other Rust programs use.
//!
//! A file may lack what no centre of mass depends on, or hold it broken; [`crate::complete`] then
//! says what is neutral. Defaults: origin zero, axis `1 0 0`, multiplier 1, offset 0, limits 0, no
//! `<inertial>` means no mass.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use nalgebra::{Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};

use crate::complete::complete;
use crate::error::{Error, Problem};
use crate::joint::{Joint, JointKind, Link, Mimic, Pose};
use crate::robot::Robot;

impl Robot {
    /// Reads the text of a URDF.
    ///
    /// Only what centre of mass and motion depend on is read: link inertials and joints (type,
    /// parent, child, origin, axis, position limits, mimic). Everything else may be absent,
    /// unknown or broken.
    ///
    /// # Errors
    /// Text that is not XML, numbers that are not numbers, unknown joint
    /// types, links that form no tree, mimic joints without a master.
    pub fn from_urdf(text: &str) -> Result<Self, Error> {
        let read = urdf_rs::read_from_string(&complete(text)?).map_err(Problem::Urdf)?;
        let links: Vec<Link> = read.links.iter().map(link).collect::<Result<_, _>>()?;
        let mut index = HashMap::new();
        for (place, link) in links.iter().enumerate() {
            if index.insert(link.name.as_str(), place).is_some() {
                return Err(twice("link", &link.name));
            }
        }
        let mut names = HashSet::new();
        if let Some(second) = read.joints.iter().find(|joint| !names.insert(&joint.name)) {
            return Err(twice("joint", &second.name));
        }
        let joints = read.joints.iter().map(|read| joint(read, &index));
        let joints = joints.collect::<Result<_, _>>()?;
        Robot::new(read.name, links, joints)
    }

    /// Reads a URDF file; see [`Robot::from_urdf`].
    ///
    /// # Errors
    /// As [`Robot::from_urdf`], and `ErrorKind::File` where it cannot be read.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|source| Problem::File {
            path: path.to_owned(),
            source,
        })?;
        Self::from_urdf(&String::from_utf8_lossy(&bytes))
    }
}

fn twice(kind: &str, name: &str) -> Error {
    let place = format!("{kind} `{name}`");
    Problem::Duplicate { place }.into()
}

fn pose(read: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = *read.rpy;
    let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
    Pose::from_parts(Translation3::from(*read.xyz), rotation)
}

fn link(read: &urdf_rs::Link) -> Result<Link, Error> {
    let (name, mass_kg) = (read.name.clone(), read.inertial.mass.value);
    if !(0.0..f64::INFINITY).contains(&mass_kg) {
        return Err(Problem::Mass {
            link: name,
            mass_kg,
        }
        .into());
    }
    let origin = pose(&read.inertial.origin);
    let urdf_rs::Inertia {
        ixx,
        ixy,
        ixz,
        iyy,
        iyz,
        izz,
    } = read.inertial.inertia;
    let own = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    Ok(Link {
        name,
        mass_kg,
        // The centre of mass is where the inertial frame sits.
        com_m: Point3::from(origin.translation.vector),
        inertia_kg_m2: origin.rotation * own * origin.rotation.matrix().transpose(),
    })
}

fn joint(read: &urdf_rs::Joint, links: &HashMap<&str, usize>) -> Result<Joint, Error> {
    let name = || read.name.clone();
    let link = |link: &str| {
        links
            .get(link)
            .copied()
            .ok_or_else(|| Problem::UnknownLinkOfJoint {
                joint: name(),
                link: link.to_owned(),
            })
    };
    let kind = match read.joint_type {
        urdf_rs::JointType::Fixed => JointKind::Fixed,
        urdf_rs::JointType::Revolute => JointKind::Revolute,
        urdf_rs::JointType::Continuous => JointKind::Continuous,
        urdf_rs::JointType::Prismatic => JointKind::Prismatic,
        urdf_rs::JointType::Floating => JointKind::Floating,
        urdf_rs::JointType::Planar => JointKind::Planar,
        urdf_rs::JointType::Spherical => return Err(Problem::Spherical { joint: name() }.into()),
    };
    // The unit vector along the axis; none where its length is zero or overflows.
    let axis = Vector3::from(*read.axis.xyz);
    let length = axis.norm();
    if !(length > 0.0 && length.is_finite()) {
        return Err(Problem::ZeroAxis { joint: name() }.into());
    }
    Ok(Joint {
        name: name(),
        kind,
        parent: link(&read.parent.link)?,
        child: link(&read.child.link)?,
        origin: pose(&read.origin),
        axis: Unit::new_unchecked(axis / length),
        limits: (read.limit.lower, read.limit.upper),
        mimic: read.mimic.as_ref().map(|mimic| Mimic {
            master: mimic.joint.clone(),
            multiplier: mimic.multiplier.unwrap_or(1.0),
            offset: mimic.offset.unwrap_or(0.0),
        }),
    })
}
