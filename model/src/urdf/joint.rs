//! Joints: type, place, axis, limits, mimic.

use roxmltree::Node;

use super::description::{Joint, JointType, Limit, Mimic};
use super::limits;
use super::nearest::suggest;
use super::origin::{Version, read_origin};
use super::report::shown;
use super::values::{Reader, Text};

/// A joint as it is found: without a name and ends, and fixed, after complaints about those.
pub(super) struct JointDraft {
    pub(super) found: Joint,
    pub(super) line: u32,
    /// Lines of its parent and its child.
    pub(super) ends: [u32; 2],
    /// The line of the joint that it mimics, its own where it mimics none.
    pub(super) mimics: u32,
}

const X_AXIS: [f64; 3] = [1.0, 0.0, 0.0];

pub(super) fn read_joint(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
) -> JointDraft {
    let line = reader.line(node);
    let name = reader.named(node, "joint");
    let kind = read_kind(reader, node);
    let origin = read_origin(reader, node, version, "origin");
    let [parent, child] = ["parent", "child"].map(|end| read_end(reader, node, end));
    let axis = match kind.is_some_and(JointType::has_axis) {
        true => read_axis(reader, node).unwrap_or(X_AXIS),
        false => X_AXIS,
    };
    let limit = kind.map_or(Limit::NONE, |kind| read_limit(reader, node, kind));
    let mimic = match (reader.only(node, "mimic"), kind) {
        (Some(mimic), Some(JointType::Fixed)) => {
            let line = reader.line(mimic);
            reader.note(line, "a fixed joint does not move; its mimic is ignored");
            None
        }
        (Some(mimic), Some(kind)) if !kind.is_single() => {
            let remedy = "has several coordinates and cannot mimic; remove <mimic>";
            reader.refuse(
                reader.line(mimic),
                format!("a {} joint {remedy}", kind.name()),
            )
        }
        (Some(mimic), _) => read_mimic(reader, mimic),
        (None, _) => None,
    };
    JointDraft {
        line,
        ends: [parent.1, child.1],
        mimics: mimic.as_ref().map_or(line, |(_, line)| *line),
        found: Joint {
            name,
            joint_type: kind.unwrap_or(JointType::Fixed),
            origin,
            parent: parent.0,
            child: child.0,
            axis,
            limit,
            mimic: mimic.map(|(mimic, _)| mimic),
        },
    }
}

fn read_kind(reader: &mut Reader<'_>, node: Node<'_, '_>) -> Option<JointType> {
    let missing = "no type; add type=\"revolute\", \"fixed\" or another";
    let text = reader.needed(node, "type", missing)?;
    if reader.unexpanded(&text, "type") {
        return None;
    }
    let found = text.value.trim();
    if let Some(kind) = JointType::ALL.into_iter().find(|kind| kind.name() == found) {
        return Some(kind);
    }
    let names = JointType::ALL.map(JointType::name);
    let remedy = match found {
        "spherical" | "ball" => {
            "; replace it by three revolute joints with massless links between them".to_owned()
        }
        _ => suggest(found, "", names.into_iter())
            .unwrap_or_else(|| format!("; URDF knows {}", names.join(", "))),
    };
    let message = format!("type {} is not supported{remedy}", shown(found));
    reader.refuse(text.line, message)
}

/// `<parent link>` or `<child link>`, and where.
fn read_end(reader: &mut Reader<'_>, node: Node<'_, '_>, end: &str) -> (String, u32) {
    let found = reader.only(node, end);
    let Some(text) = found.and_then(|found| reader.attribute(found, "link")) else {
        let line = reader.line(found.unwrap_or(node));
        reader.complain(line, format!("no {end}; add <{end} link=\"...\"/>"));
        return (String::new(), line);
    };
    (reader.name(&text, end), text.line)
}

fn read_axis(reader: &mut Reader<'_>, node: Node<'_, '_>) -> Option<[f64; 3]> {
    let found = reader.only(node, "axis")?;
    let text = reader.attribute(found, "xyz")?;
    let axis = reader.numbers::<3>(&text, "axis xyz")?;
    let longest = axis.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    if longest < limits::AXIS {
        reader.complain(text.line, "axis is zero; give <axis xyz> a direction");
    } else if longest > 1.0 / limits::AXIS {
        let message = format!("axis holds {longest:e}; give <axis xyz> a unit vector");
        reader.complain(text.line, message);
    }
    Some(axis)
}

/// What a joint mimics, and where.
fn read_mimic(reader: &mut Reader<'_>, node: Node<'_, '_>) -> Option<(Mimic, u32)> {
    let [multiplier, offset] = ["multiplier", "offset"].map(|name| {
        let text = reader.attribute(node, name)?;
        reader.number(&text, &format!("mimic {name}"))
    });
    let missing = "mimic of no joint; add <mimic joint=\"...\"/>";
    let text = reader.needed(node, "joint", missing)?;
    let mimic = Mimic {
        joint: reader.name(&text, "mimic joint"),
        multiplier: multiplier.unwrap_or(1.0),
        offset: offset.unwrap_or(0.0),
    };
    (!mimic.joint.is_empty()).then_some((mimic, text.line))
}

/// Position limits of a joint; effort and velocity only pass through.
fn read_limit(reader: &mut Reader<'_>, node: Node<'_, '_>, kind: JointType) -> Limit {
    let found = match kind {
        JointType::Fixed => None,
        _ => reader.only(node, "limit"),
    };
    let text = |reader: &Reader<'_>, name| found.and_then(|found| reader.attribute(found, name));
    let [effort, velocity] = ["effort", "velocity"].map(|name| {
        let means = "not needed, taken as 0";
        text(reader, name).map_or(0.0, |text| {
            reader.or_zero(&text, &format!("limit {name}"), means)
        })
    });
    let unlimited = Limit {
        effort,
        velocity,
        ..Limit::NONE
    };
    if !kind.has_limits() {
        return unlimited;
    }
    let given = ["lower", "upper"].map(|name| text(reader, name));
    let Some(line) = given.iter().flatten().map(|text| text.line).next() else {
        let line = reader.line(found.unwrap_or(node));
        reader.note(line, "no lower and upper limit; taken as unlimited");
        return unlimited;
    };
    let Some(lower) = read_bound(reader, given[0].as_ref(), "limit lower") else {
        return unlimited;
    };
    let Some(upper) = read_bound(reader, given[1].as_ref(), "limit upper") else {
        return unlimited;
    };
    if lower > upper || lower == f64::INFINITY || upper == f64::NEG_INFINITY {
        let missing = match &given {
            [None, _] => " (lower is missing, which counts as 0)",
            [_, None] => " (upper is missing, which counts as 0)",
            _ => "",
        };
        // Some simulators write "free" this way; nothing else depends on limits.
        let found = format!("limit lower {lower} is above upper {upper}{missing}");
        reader.note(line, format!("{found}; taken as unlimited"));
        return unlimited;
    }
    let finite = [lower, upper].map(f64::abs).into_iter();
    let largest = finite.filter(|v| v.is_finite()).fold(0.0, f64::max);
    if kind == JointType::Revolute && (limits::TURN_RAD..limits::UNLIMITED_RAD).contains(&largest) {
        reader.note(line, format!("limit {largest} rad; is it in degrees?"));
    }
    Limit {
        lower,
        upper,
        ..unlimited
    }
}

/// A missing bound counts as 0; an infinite one is none.
fn read_bound(reader: &mut Reader<'_>, text: Option<&Text>, what: &str) -> Option<f64> {
    let Some(text) = text else { return Some(0.0) };
    let [value] = reader.extended_numbers::<1>(text, what)?;
    if value.is_nan() {
        let message = format!("{what} is NaN, not finite; give a plain number");
        return reader.refuse(text.line, message);
    }
    Some(value)
}
