//! The checked description as a minimal URDF, read by `urdf_rs`.
//!
//! Numbers are written so that they read back to the last bit.

use std::fmt::Write as _;

use super::draft::Draft;
use super::joint::{Joint, Kind};
use super::link::{INERTIA, Inertial, Link, Origin};

type Problem = Box<dyn std::error::Error + Send + Sync>;

pub(super) fn read(draft: &Draft) -> Result<urdf_rs::Robot, Problem> {
    let mut robot = urdf_rs::read_from_string(&text(draft))?;
    robot.version.clone_from(&draft.version);
    let same = robot.name == draft.name
        && names(robot.links.iter().map(|link| &link.name))
            .eq(draft.links.iter().map(|link| link.name.as_deref()))
        && names(robot.joints.iter().map(|joint| &joint.name))
            .eq(draft.joints.iter().map(|joint| joint.name.as_deref()));
    if !same {
        return Err("links or joints came back under other names".into());
    }
    Ok(robot)
}

fn names<'a>(names: impl Iterator<Item = &'a String>) -> impl Iterator<Item = Option<&'a str>> {
    names.map(|name| Some(name.as_str()))
}

/// Quaternions have become rpy and limits are spelled out, so the text needs
/// no version.
fn text(draft: &Draft) -> String {
    let mut out = format!("<robot name=\"{}\">\n", escaped(&draft.name));
    for link in &draft.links {
        write_link(&mut out, link);
    }
    for joint in &draft.joints {
        write_joint(&mut out, joint);
    }
    out.push_str("</robot>\n");
    out
}

// Writing into a string cannot fail, hence the ignored results below.

fn write_link(out: &mut String, link: &Link) {
    let name = escaped(link.name.as_deref().unwrap_or_default());
    let Inertial::Massive {
        origin,
        mass_kg,
        inertia,
    } = &link.inertial
    else {
        let _ = writeln!(out, "<link name=\"{name}\"/>");
        return;
    };
    let _ = write!(out, "<link name=\"{name}\"><inertial>");
    write_origin(out, origin);
    let _ = write!(out, "<mass value=\"{mass_kg:?}\"/><inertia");
    for (entry, value) in INERTIA.iter().zip(inertia) {
        let _ = write!(out, " {entry}=\"{value:?}\"");
    }
    out.push_str("/></inertial></link>\n");
}

fn write_joint(out: &mut String, joint: &Joint) {
    let end = |end: &Option<super::values::At<String>>| {
        escaped(end.as_ref().map_or("", |end| end.value.as_str()))
    };
    let kind = joint.kind.unwrap_or(Kind::Fixed);
    let _ = write!(
        out,
        "<joint name=\"{}\" type=\"{}\">",
        escaped(joint.name.as_deref().unwrap_or_default()),
        kind.name()
    );
    write_origin(out, &joint.origin);
    let _ = write!(
        out,
        "<parent link=\"{}\"/><child link=\"{}\"/>",
        end(&joint.parent),
        end(&joint.child)
    );
    if kind != Kind::Fixed {
        let [x, y, z] = joint.axis;
        let _ = write!(out, "<axis xyz=\"{x:?} {y:?} {z:?}\"/>");
        let limit = &joint.limit;
        let _ = write!(
            out,
            "<limit lower=\"{:?}\" upper=\"{:?}\" effort=\"{:?}\" velocity=\"{:?}\"/>",
            limit.lower, limit.upper, limit.effort, limit.velocity
        );
    }
    if let Some(mimic) = &joint.mimic {
        let _ = write!(
            out,
            "<mimic joint=\"{}\" multiplier=\"{:?}\" offset=\"{:?}\"/>",
            escaped(&mimic.joint.value),
            mimic.multiplier,
            mimic.offset
        );
    }
    out.push_str("</joint>\n");
}

fn write_origin(out: &mut String, origin: &Origin) {
    let ([x, y, z], [roll, pitch, yaw]) = (origin.xyz, origin.rpy);
    let _ = write!(
        out,
        "<origin xyz=\"{x:?} {y:?} {z:?}\" rpy=\"{roll:?} {pitch:?} {yaw:?}\"/>"
    );
}

pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            _ => out.push(c),
        }
    }
    out
}
