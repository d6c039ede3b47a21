//! `<origin>` of a joint or of an inertial, and the version that says what it may hold.

use roxmltree::Node;

use super::description::Origin;
use super::limits;
use super::rotation::rpy_of_quaternion;
use super::values::Reader;

/// Version of the URDF format; what an attribute means depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Version(u32, u32);

impl Version {
    pub(super) const OLDEST: Version = Version(1, 0);
    /// Knows `quat_xyzw`.
    pub(super) const QUATERNIONS: Version = Version(1, 1);

    pub(super) fn parse(text: &str) -> Option<Version> {
        let (major, minor) = text.trim().split_once('.')?;
        Some(Version(major.parse().ok()?, minor.parse().ok()?))
    }
}

/// `<origin>` of a joint or an inertial; what is missing is zero.
pub(super) fn read_origin(
    reader: &mut Reader<'_>,
    parent: Node<'_, '_>,
    version: Version,
    what: &str,
) -> Origin {
    let mut origin = Origin::default();
    let Some(node) = reader.only(parent, "origin") else {
        return origin;
    };
    if let Some(text) = reader.attribute(node, "xyz") {
        let what = format!("{what} xyz");
        origin.xyz = reader.numbers(&text, &what).unwrap_or_default();
        if let Some(far) = origin.xyz.iter().find(|v| v.abs() > limits::OFFSET_M) {
            let message = format!("{what} holds {far:e} m; no robot is that large, give it in m");
            reader.complain(text.line, message);
        }
    }
    let rpy = reader.attribute(node, "rpy");
    if let Some(text) = &rpy {
        let what = format!("{what} rpy");
        origin.rpy = reader.numbers(text, &what).unwrap_or_default();
        if let Some(angle) = origin.rpy.iter().find(|v| v.abs() > limits::TURNS_RAD) {
            let message = format!(
                "{what} holds {angle:e} rad; an angle beyond 2^20 rad means nothing, reduce it by \
                 whole turns"
            );
            reader.complain(text.line, message);
        } else if let Some(angle) = origin.rpy.iter().find(|v| v.abs() > limits::ANGLE_RAD) {
            let message = format!("{what} holds {angle} rad; is it in degrees?");
            reader.note(text.line, message);
        }
    }
    if let Some(text) = reader.attribute(node, "quat_xyzw") {
        let what = format!("{what} quat_xyzw");
        if version < Version::QUATERNIONS {
            let message = format!("{what} is ignored before <robot version=\"1.1\">");
            reader.note(text.line, message);
        } else if rpy.is_some() {
            let message = format!("{what} and rpy are both given; keep one");
            reader.complain(text.line, message);
        } else if let Some(quaternion) = reader.numbers(&text, &what) {
            let message = format!("{what} is zero; write 0 0 0 1 for no rotation");
            let rpy = rpy_of_quaternion(quaternion);
            let rpy = rpy.or_else(|| reader.refuse(text.line, message));
            origin.rpy = rpy.unwrap_or(origin.rpy);
        }
    }
    origin
}
