//! Reads a URDF's kinematics and masses, and nothing else.
//!
//! Real files carry more than the format defines and less than it demands:
//! comments with dashes, undeclared prefixes, simulator blocks, joints without
//! effort, shapes nobody knows. None of that touches a centre of mass, so none
//! of it is looked at. What is looked at is read strictly: a number that is
//! not a number is an error, never a zero.
//!
//! Defaults: origin zero, axis `1 0 0`, multiplier 1, offset 0, no `<inertial>`
//! means no mass. Limits are zero where absent, and infinite from URDF 1.2 on;
//! `quat_xyzw` counts from URDF 1.1 on. A missing or odd version means 1.0.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use nalgebra::{
    Matrix3, Point3, Quaternion, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};
use roxmltree::Node;

use crate::error::{Error, Problem};
use crate::joint::{Joint, JointKind, Link, Mimic, Pose};
use crate::robot::Robot;
use crate::xml::{
    bounds, child, children, declare_prefixes, missing, numbers, parse, strip_comments, text_of,
};

impl Robot {
    /// Reads the text of a URDF.
    ///
    /// Only what centre of mass and motion depend on is read: link inertials and joints (type, parent, child, origin, axis, position
    /// limits, mimic). Everything else may be absent, unknown or broken.
    ///
    /// # Errors
    /// Text that is not XML, numbers that are not numbers, unknown joint
    /// types, links that form no tree, mimic joints without a master.
    pub fn from_urdf(text: &str) -> Result<Self, Error> {
        read(text)
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

/// Reads the text of a URDF.
fn read(text: &str) -> Result<Robot, Error> {
    let text = declare_prefixes(strip_comments(text))?;
    let document = parse(&text).map_err(Problem::Xml)?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(Problem::NotARobot {
            root: root.tag_name().name().to_owned(),
        }
        .into());
    }

    let version = version(root);
    let mut links = Vec::new();
    let mut link_index = HashMap::new();
    for node in children(root, "link") {
        let link = read_link(node, version)?;
        if link_index.insert(link.name.clone(), links.len()).is_some() {
            return Err(Problem::Duplicate {
                place: format!("link `{}`", link.name),
            }
            .into());
        }
        links.push(link);
    }

    let mut joints = Vec::new();
    let mut joint_names = HashSet::new();
    for node in children(root, "joint") {
        let joint = read_joint(node, version, &link_index)?;
        if !joint_names.insert(joint.name.clone()) {
            return Err(Problem::Duplicate {
                place: format!("joint `{}`", joint.name),
            }
            .into());
        }
        joints.push(joint);
    }
    let name = root.attribute("name").unwrap_or_default();
    Robot::new(name.to_owned(), links, joints)
}

fn read_link(node: Node, version: (u32, u32)) -> Result<Link, Error> {
    let name = text_of(node, "a link", "name")?.ok_or_else(|| missing("a link", "its name"))?;
    let place = format!("link `{name}`");
    let mut link = Link {
        name: name.to_owned(),
        mass_kg: 0.0,
        com_m: Point3::origin(),
        inertia_kg_m2: Matrix3::zeros(),
    };
    let Some(inertial) = child(node, "inertial") else {
        return Ok(link);
    };
    // The centre of mass is where the inertial frame sits.
    if let Some(origin) = child(inertial, "origin") {
        let xyz = numbers(origin, &place, "xyz")?.unwrap_or_default();
        link.com_m = Point3::from(xyz);
    }
    let mass = child(inertial, "mass").ok_or_else(|| missing(&place, "<mass> of <inertial>"))?;
    let [mass_kg] =
        numbers(mass, &place, "value")?.ok_or_else(|| missing(&place, "the value of <mass>"))?;
    if mass_kg < 0.0 {
        return Err(Problem::NegativeMass {
            link: link.name,
            mass_kg,
        }
        .into());
    }
    link.mass_kg = mass_kg;
    link.inertia_kg_m2 = read_inertia(inertial, &place, version);
    Ok(link)
}

/// Inertia in the axes of the link. Nothing at rest depends on it, so what is broken is zero.
fn read_inertia(inertial: Node, place: &str, version: (u32, u32)) -> Matrix3<f64> {
    let Some(inertia) = child(inertial, "inertia") else {
        return Matrix3::zeros();
    };
    let entry = |name| match numbers(inertia, place, name) {
        Ok(Some([value])) => value,
        _ => 0.0,
    };
    let [xx, xy, xz, yy, yz, zz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(entry);
    let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let origin = child(inertial, "origin").map(|origin| read_origin(origin, place, version));
    match origin {
        Some(Ok(pose)) => pose.rotation * own * pose.rotation.matrix().transpose(),
        _ => own,
    }
}

fn read_joint(
    node: Node,
    version: (u32, u32),
    link_index: &HashMap<String, usize>,
) -> Result<Joint, Error> {
    let name = text_of(node, "a joint", "name")?.ok_or_else(|| missing("a joint", "its name"))?;
    let place = format!("joint `{name}`");
    let kind = text_of(node, &place, "type")?.ok_or_else(|| missing(&place, "its type"))?;
    let kind = match kind.trim() {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "floating" => JointKind::Floating,
        "planar" => JointKind::Planar,
        _ => {
            return Err(Problem::UnknownJointKind {
                joint: name.to_owned(),
                kind: kind.to_owned(),
            }
            .into());
        }
    };
    let link = |tag: &str, what| -> Result<usize, Error> {
        let node = child(node, tag).ok_or_else(|| missing(&place, what))?;
        let link = text_of(node, &place, "link")?.ok_or_else(|| missing(&place, what))?;
        let found = link_index.get(link).copied();
        Ok(found.ok_or_else(|| Problem::UnknownLinkOfJoint {
            joint: name.to_owned(),
            link: link.to_owned(),
        })?)
    };
    let parent = link("parent", "<parent link>")?;
    let child_link = link("child", "<child link>")?;
    let origin = match child(node, "origin") {
        Some(origin) => read_origin(origin, &place, version)?,
        None => Pose::identity(),
    };
    let mut joint = Joint {
        name: name.to_owned(),
        kind,
        parent,
        child: child_link,
        origin,
        axis: Vector3::x_axis(),
        limits: (f64::NEG_INFINITY, f64::INFINITY),
        mimic: None,
    };
    if kind.has_coordinate() {
        read_motion(node, &place, version, &mut joint)?;
    }
    Ok(joint)
}

/// Axis, limits and mimic: what only a joint with a coordinate has.
fn read_motion(
    node: Node,
    place: &str,
    version: (u32, u32),
    joint: &mut Joint,
) -> Result<(), Error> {
    if let Some(axis) = child(node, "axis") {
        let xyz = numbers(axis, place, "xyz")?.unwrap_or([1.0, 0.0, 0.0]);
        joint.axis = direction(Vector3::from(xyz)).ok_or_else(|| Problem::ZeroAxis {
            joint: joint.name.clone(),
        })?;
    }
    if let Some(limit) = child(node, "limit") {
        let absent = if version >= (1, 2) {
            f64::INFINITY
        } else {
            0.0
        };
        let [lower] = bounds(limit, place, "lower")?.unwrap_or([-absent]);
        let [upper] = bounds(limit, place, "upper")?.unwrap_or([absent]);
        joint.limits = (lower, upper);
    }
    if let Some(mimic) = child(node, "mimic") {
        let master = text_of(mimic, place, "joint")?;
        let [multiplier] = numbers(mimic, place, "multiplier")?.unwrap_or([1.0]);
        let [offset] = numbers(mimic, place, "offset")?.unwrap_or([0.0]);
        joint.mimic = Some(Mimic {
            master: master
                .ok_or_else(|| missing(place, "the joint of <mimic>"))?
                .to_owned(),
            multiplier,
            offset,
        });
    }
    Ok(())
}

fn read_origin(node: Node, place: &str, version: (u32, u32)) -> Result<Pose, Error> {
    let xyz: [f64; 3] = numbers(node, place, "xyz")?.unwrap_or_default();
    let rpy = numbers(node, place, "rpy")?;
    let quaternion = if version >= (1, 1) {
        numbers(node, place, "quat_xyzw")?
    } else {
        None
    };
    let rotation = match (rpy, quaternion) {
        (Some(_), Some(_)) => {
            return Err(Problem::TwoOrientations {
                place: place.to_owned(),
            }
            .into());
        }
        (Some([roll, pitch, yaw]), None) => Rotation3::from_euler_angles(roll, pitch, yaw),
        (None, Some([x, y, z, w])) => UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0)
            .filter(|unit| unit.norm() > 0.5) // zero where the length overflows
            .ok_or_else(|| Problem::ZeroQuaternion {
                place: place.to_owned(),
            })?
            .to_rotation_matrix(),
        (None, None) => Rotation3::identity(),
    };
    Ok(Pose::from_parts(Translation3::from(xyz), rotation))
}

/// The URDF version, major and minor.
fn version(root: Node) -> (u32, u32) {
    let text = root.attribute("version").unwrap_or_default();
    text.trim()
        .split_once('.')
        .and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)))
        .unwrap_or((1, 0))
}

/// The unit vector along `xyz`; none where its length is zero or overflows.
fn direction(xyz: Vector3<f64>) -> Option<Unit<Vector3<f64>>> {
    let length = xyz.norm();
    (length > 0.0 && length.is_finite()).then(|| Unit::new_unchecked(xyz / length))
}
