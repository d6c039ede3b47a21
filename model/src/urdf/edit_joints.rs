//! Joint offsets and payloads written into the text of a URDF; everything else
//! stays byte for byte.
//!
//! ```text
//! T → T Rot(axis, δ)          a revolute joint stands δ further
//! T → T Trans(axis δ)         a prismatic joint
//! q_f = k q + o  →  k q + (o + k δ)
//! ```
//!
//! A simulator moves a mimic joint by the encoder of its master; the robot moves it by
//! where the master really is, so the offset of the mimic takes up the rest. Followers
//! of followers then come right by themselves. Limits stay: they are the encoder's.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use roxmltree::Node;

use super::description::{Description, Joint, JointType};
use super::edits::{Edits, SAME, three};
use super::error::Error;
use super::rotation::rpy_of_quaternion;
use super::source::{Source, children};

/// A joint that stands further than its encoder says.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// Its name.
    pub joint: String,
    /// rad; m for a prismatic joint
    pub by: f64,
}

/// A mass on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// Name of the link.
    pub link: String,
    /// kg
    pub mass_kg: f64,
    /// In the frame of the link, m.
    pub at_m: [f64; 3],
}

/// Radius of gyration of a load, m: as good as a point, yet no simulator divides by zero.
const GYRATION_M: f64 = 1e-3;

/// The text of a URDF with the origins of joints, and of what follows them, moved
/// by `shifts`.
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn edit_joints(description: &Description, shifts: &[Shift]) -> Result<String, Error> {
    let source = Source::of(description)?;
    let document = source.document()?;
    let mut edits = Edits::new(&source, &description.text);
    let shift_of = |name: &str| -> f64 {
        let own = shifts.iter().filter(|shift| shift.joint == name);
        own.map(|shift| shift.by).sum()
    };
    let root = document.root_element();
    for (node, joint) in children(root, "joint").zip(&description.joints) {
        let by = shift_of(&joint.name);
        if by.abs() > SAME {
            shift_origin(&mut edits, node, joint, by);
        }
        let Some(mimic) = &joint.mimic else { continue };
        let follows = mimic.multiplier * shift_of(&mimic.joint);
        if let Some(element) = children(node, "mimic")
            .next()
            .filter(|_| follows.abs() > SAME)
        {
            edits.set(element, "offset", mimic.offset + follows);
        }
    }
    Ok(edits.applied())
}

/// The origin of a joint where it stands `by` further.
fn shift_origin(edits: &mut Edits<'_>, node: Node<'_, '_>, joint: &Joint, by: f64) {
    let (xyz, rpy) = (Vector3::from(joint.origin.xyz), joint.origin.rpy);
    let axis = Vector3::from(joint.axis).normalize();
    let rotation = quaternion_of_rpy(rpy);
    let (xyz, rpy) = match joint.joint_type {
        JointType::Prismatic => {
            let rotation = UnitQuaternion::new_normalize(rotation);
            (xyz + rotation * (axis * by), rpy)
        }
        _ => {
            let (sin, cos) = libm::sincos(by / 2.0);
            let [x, y, z] = (axis * sin).into();
            let turned = rotation * Quaternion::new(cos, x, y, z);
            let [x, y, z, w] = turned.coords.into();
            // Zero only where nothing rotates.
            (xyz, rpy_of_quaternion([x, y, z, w]).unwrap_or(rpy))
        }
    };
    // A sum with zero has no sign where it is zero.
    let (xyz, rpy) = ([0, 1, 2].map(|k| xyz[k] + 0.0), rpy.map(|x| x + 0.0));
    let Some(origin) = children(node, "origin").next() else {
        let element = format!("<origin xyz=\"{}\" rpy=\"{}\"/>", three(xyz), three(rpy));
        edits.put_first(node, &element);
        return;
    };
    edits.set_three(origin, "xyz", xyz);
    match (
        origin.attribute_node("quat_xyzw"),
        origin.attribute_node("rpy"),
    ) {
        // Roll, pitch and yaw in its place: every reader knows them, and both at once
        // contradict each other.
        (Some(quaternion), None) if joint.joint_type != JointType::Prismatic => {
            let place = edits.place(&quaternion.range());
            edits.put(place, format!("rpy=\"{}\"", three(rpy)));
        }
        (Some(_), None) => {}
        _ => edits.set_three(origin, "rpy", rpy),
    }
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`
fn quaternion_of_rpy([roll, pitch, yaw]: [f64; 3]) -> Quaternion<f64> {
    let half = |angle: f64, axis: usize| {
        let (sin, cos) = libm::sincos(angle / 2.0);
        let mut vector = Vector3::zeros();
        vector[axis] = sin;
        Quaternion::from_parts(cos, vector)
    };
    half(yaw, 2) * half(pitch, 1) * half(roll, 0)
}

/// The text of a URDF with a link `payload_<link>` for each load, fixed where the
/// load sits.
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn add_loads(description: &Description, loads: &[Load]) -> Result<String, Error> {
    let text = description.text.as_str();
    let source = Source::of(description)?;
    let document = source.document()?;
    let mut edits = Edits::new(&source, text);
    let joints = description.joints.iter().map(|joint| joint.name.as_str());
    let taken = description.link_names().chain(joints);
    let mut taken: Vec<String> = taken.map(str::to_owned).collect();

    let root = document.root_element();
    let end = edits.place(&root.range()).end;
    let inside = &text[..text[..end].rfind("</").unwrap_or(end)];
    let at = inside.trim_end().len();
    let blank = root.last_element_child().map_or("", |last| {
        let blank = edits.blank_before(edits.place(&last.range()).start);
        // One end of line, however it is written, and the indent.
        blank.rfind('\n').map_or("", |line| {
            let crlf = blank[..line].ends_with('\r');
            &blank[line - usize::from(crlf)..]
        })
    });
    let deeper = |levels: usize| match blank.is_empty() {
        true => String::new(),
        false => blank.to_string() + &"  ".repeat(levels),
    };
    let [out, one, two] = [0, 1, 2].map(deeper);
    for load in loads {
        let name = unused(&format!("payload_{}", load.link), &mut taken);
        let joint = unused(&format!("{name}_joint"), &mut taken);
        let (name, joint) = (escaped(&name), escaped(&joint));
        let moment = load.mass_kg * GYRATION_M * GYRATION_M;
        let element = format!(
            "{out}<link name=\"{name}\">\
             {one}<inertial>\
             {two}<mass value=\"{:?}\"/>\
             {two}<inertia ixx=\"{moment:?}\" ixy=\"0\" ixz=\"0\" iyy=\"{moment:?}\" iyz=\"0\" izz=\"{moment:?}\"/>\
             {one}</inertial>\
             {out}</link>\
             {out}<joint name=\"{joint}\" type=\"fixed\">\
             {one}<origin xyz=\"{}\" rpy=\"0 0 0\"/>\
             {one}<parent link=\"{}\"/>\
             {one}<child link=\"{name}\"/>\
             {out}</joint>",
            load.mass_kg,
            three(load.at_m),
            escaped(&load.link),
        );
        edits.put(at..at, element);
    }
    Ok(edits.applied())
}

/// `name`, or the first of `name_2`, `name_3`, … that nothing is called yet.
fn unused(name: &str, taken: &mut Vec<String>) -> String {
    let free = |candidate: &String| !taken.contains(candidate);
    let others = (2..).map(|k| format!("{name}_{k}"));
    let found = std::iter::once(name.to_string()).chain(others).find(free);
    let found = found.unwrap_or_default();
    taken.push(found.clone());
    found
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf::parse;

    const TEXT: &str = "\u{feff}<?xml version='1.0'?>\r\n<robot name='r' version='1.1'>\r\n  <link name='a&amp;b'/>\r\n\
        \x20 <link name='c/d'/><link name='e'><inertial><mass value='1'/></inertial></link><link name='payload_e'/><link name='f'/>\r\n\
        \x20 <!-- bent --><xacro:property bar='${x}'/>\r\n\
        \x20 <joint name='j/1' type='revolute'>\r\n    <parent link='a&amp;b'/><child link='c/d'/> <axis xyz='0 -2 0'/>\
        <limit lower='-1' upper='1'/></joint>\r\n\
        \x20 <joint name='k' type='continuous'><origin  xyz='0.10 0 0'/><mimic multiplier='-2' joint='j/1'/>\
        <parent link='a&amp;b'/><child link='e'/></joint>\r\n\
        \x20 <joint name='l' type='prismatic'><origin quat_xyzw='0 0 1 1' xyz='1 0 0'/><parent link='e'/>\
        <child link='f'/><axis xyz='1 0 0'/></joint>\r\n\
        \x20 <joint name='m' type='revolute'><origin quat_xyzw='0 0 1 1'/><parent link='e'/>\
        <child link='payload_e'/><axis xyz='0 0 1'/><limit lower='-1' upper='1'/></joint>\r\n  <!-- end -->\r\n</robot>\r\n";

    fn original() -> Description {
        parse(TEXT, "r.urdf").unwrap()
    }

    fn shift(joint: &str, by: f64) -> Shift {
        Shift {
            joint: joint.to_string(),
            by,
        }
    }

    #[test]
    fn origins_move_and_mimics_follow() {
        let shifts = [shift("j/1", 0.03), shift("l", 0.25)];
        let expected = TEXT
            .replace(
                "'revolute'>\r\n    <parent",
                "'revolute'>\r\n    <origin xyz=\"0.0 0.0 0.0\" rpy=\"0.0 -0.03 0.0\"/>\r\n    <parent",
            )
            .replace("<mimic m", "<mimic offset=\"-0.06\" m");
        let text = edit_joints(&original(), &shifts).unwrap();
        let read = parse(&text, "r.urdf").unwrap();
        let rpy = read.joints[0].origin.rpy;
        assert!((rpy[1] + 0.03).abs() < 1e-15 && rpy[0] == 0.0 && rpy[2] == 0.0);
        let moved = read.joints[2].origin.xyz;
        assert!((moved[0] - 1.0).abs() < 1e-15 && (moved[1] - 0.25).abs() < 1e-15);
        // All of it but where last digits are the machine's business.
        let line = |text: &str, k: usize| text.lines().nth(k).unwrap().to_string();
        assert_eq!(text.lines().count(), expected.lines().count());
        for k in [0, 1, 2, 3, 4, 5, 7, 8, 10, 11, 12] {
            assert_eq!(line(&text, k), line(&expected, k));
        }
        assert_eq!(edit_joints(&original(), &[]).unwrap(), TEXT);
        // A quaternion becomes roll, pitch and yaw.
        let text = edit_joints(&original(), &[shift("m", 0.1)]).unwrap();
        let yaw = parse(&text, "r.urdf").unwrap().joints[3].origin.rpy[2];
        assert!((yaw - 0.1 - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(text.matches("quat_xyzw").count(), 1);
    }

    #[test]
    fn loads_are_links_of_their_own() {
        let on = |link: &str, mass_kg| Load {
            link: link.to_string(),
            mass_kg,
            at_m: [0.1, -1e-9, 1.0 / 3.0],
        };
        let loads = [on("e", 0.3), on("a&b", 0.1), on("e", 0.2)];
        let text = add_loads(&original(), &loads).unwrap();
        let read = parse(&text, "r.urdf").unwrap();
        let names = [5, 6, 7].map(|k: usize| read.links[k].name.as_str());
        assert_eq!(names, ["payload_e_2", "payload_a&b", "payload_e_3"]);
        assert_eq!(read.links.len(), 8);
        assert_eq!(read.joints[4].origin.xyz, loads[0].at_m);
        assert_eq!(read.joints[5].parent, "a&b");
        assert_eq!(read.links[7].inertial.mass_kg, 0.2);
        // What was there stands around it as it did.
        let (before, after) = TEXT.split_at(TEXT.rfind("\r\n</robot>").unwrap());
        assert!(text.starts_with(before) && text.ends_with(after));
        let first = "\r\n  <link name=\"payload_e_2\">\r\n    <inertial>\r\n      <mass";
        assert!(text.contains(first));
        assert_eq!(add_loads(&original(), &[]).unwrap(), TEXT);
    }
}
