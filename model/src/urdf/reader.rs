//! Numbers of links and joints as `urdf_rs` reads them.
//!
//! `urdf_rs` reads the text as it was given, but for what the scan masked. It
//! gives up on files that lack what no centre of mass depends on (a velocity
//! limit, an inertia, a shape it knows); those the draft reads alone. Of all
//! files the draft gives what `urdf_rs` has no sign for, or rounds:
//!
//! ```text
//! limits         none is ±inf, and so are limits the wrong way round
//! quaternions    urdf_rs rounds them near a pitch of ±90°
//! inertia        broken entries are zero
//! ```

use super::description::{Joint, JointType, Link, Origin};
use super::origin::Version;

/// Read `text` and take its numbers over into `links` and `joints`, where it gives
/// the same links and joints.
pub(super) fn read(text: &str, version: Version, links: &mut [Link], joints: &mut [Joint]) {
    if let Ok(robot) = urdf_rs::read_from_string(text)
        && is_same(&robot, links, joints)
    {
        adopt(&robot, links, joints, version >= Version::QUATERNIONS);
    }
}

/// Whether `robot` has these links and joints, in this order.
fn is_same(robot: &urdf_rs::Robot, links: &[Link], joints: &[Joint]) -> bool {
    let same = |own: &Joint, read: &urdf_rs::Joint| {
        own.name == read.name
            && own.parent == read.parent.link
            && own.child == read.child.link
            && Some(own.joint_type) == joint_type(&read.joint_type)
            && match (&own.mimic, &read.mimic) {
                (Some(own), Some(read)) => own.joint == read.joint,
                (own, _) => own.is_none(),
            }
    };
    (robot.links.iter().map(|link| &link.name)).eq(links.iter().map(|link| &link.name))
        && robot.joints.len() == joints.len()
        && joints
            .iter()
            .zip(&robot.joints)
            .all(|(own, read)| same(own, read))
}

fn joint_type(read: &urdf_rs::JointType) -> Option<JointType> {
    Some(match read {
        urdf_rs::JointType::Revolute => JointType::Revolute,
        urdf_rs::JointType::Continuous => JointType::Continuous,
        urdf_rs::JointType::Prismatic => JointType::Prismatic,
        urdf_rs::JointType::Fixed => JointType::Fixed,
        urdf_rs::JointType::Floating => JointType::Floating,
        urdf_rs::JointType::Planar => JointType::Planar,
        urdf_rs::JointType::Spherical => return None,
    })
}

fn adopt(robot: &urdf_rs::Robot, links: &mut [Link], joints: &mut [Joint], quaternions: bool) {
    let origin = |own: &mut Origin, read: &urdf_rs::Pose| {
        own.xyz = *read.xyz;
        if !quaternions {
            own.rpy = *read.rpy;
        }
    };
    for (own, read) in links.iter_mut().zip(&robot.links) {
        own.inertial.mass_kg = read.inertial.mass.value;
        origin(&mut own.inertial.origin, &read.inertial.origin);
    }
    for (own, read) in joints.iter_mut().zip(&robot.joints) {
        origin(&mut own.origin, &read.origin);
        if own.joint_type.has_axis() {
            own.axis = *read.axis.xyz;
        }
        if let (Some(own), Some(read)) = (&mut own.mimic, &read.mimic) {
            own.multiplier = read.multiplier.unwrap_or(1.0);
            own.offset = read.offset.unwrap_or(0.0);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::urdf::report::{Lines, Report};
    use crate::urdf::robot::robot;
    use crate::urdf::{draft, scan};

    /// Links and joints by the draft alone, and with the numbers of `urdf_rs`.
    pub(in crate::urdf) fn both(text: &str) -> [(Vec<Link>, Vec<Joint>); 2] {
        let scanned = scan::scan(text).unwrap();
        let document = roxmltree::Document::parse(&scanned).unwrap();
        let lines = Lines::of(scanned.as_bytes());
        let read = || draft::draft(text, &document, &lines, &mut Report::new("test.urdf"));
        [robot(read(), ""), robot(read(), &scanned)]
    }

    #[test]
    fn urdf_rs_reads_shipped_robots_and_agrees_with_the_draft() {
        let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots");
        for name in [
            "arm6",
            "op2",
            "plain_humanoid",
            "quadruped",
            "skew_humanoid",
            "two_link",
        ] {
            let path = format!("{robots}/{name}/{name}.urdf");
            let text = std::fs::read_to_string(&path).unwrap();
            let [draft, read] = both(&text);
            assert_eq!(draft, read, "{name}");
            let robot = urdf_rs::read_from_string(&scan::scan(&text).unwrap()).unwrap();
            assert!(is_same(&robot, &read.0, &read.1), "{name}");
        }
    }

    #[test]
    fn what_other_tools_put_beside_it_is_not_read() {
        let text = "<robot name='r' xmlns='u' xmlns:x='v' x:name='s'><x:link name='b'/>\
            <link name='a' xmlns=''><x:inertial/><inertial><x:origin xyz='1 1 1'/><mass value='2' x:value='3'/>\
            <inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link></robot>";
        let [draft, read] = both(text);
        assert_eq!(draft, read);
        assert_eq!(read.0.len(), 1);
        assert_eq!(read.0[0].inertial.mass_kg, 2.0);
        assert_eq!(read.0[0].inertial.origin, Origin::default());
    }

    #[test]
    fn files_that_urdf_rs_gives_up_on_are_read() {
        let text =
            "<robot name='r'><link name='a'><inertial><mass value='2'/></inertial></link></robot>";
        assert!(urdf_rs::read_from_string(text).is_err());
        assert_eq!(both(text)[1].0[0].inertial.mass_kg, 2.0);
    }
}
