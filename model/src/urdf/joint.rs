//! Joints: type, place, axis, limits, mimic.

use roxmltree::Node;

use super::description::{Joint, JointType, Limit, Mimic, Origin};
use super::joint_limit::read_limit;
use super::limits;
use super::nearest::suggest;
use super::origin::{Version, read_origin};
use super::report::shown;
use super::values::{At, Reader};

pub(super) struct JointDraft {
    pub(super) line: u32,
    pub(super) name: Option<String>,
    pub(super) kind: Option<JointType>,
    pub(super) origin: Origin,
    pub(super) parent: Option<At<String>>,
    pub(super) child: Option<At<String>>,
    pub(super) axis: [f64; 3],
    pub(super) limit: Limit,
    pub(super) mimic: Option<MimicDraft>,
}

pub(super) struct MimicDraft {
    pub(super) joint: At<String>,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

// The checks found everything that is `None` in a draft and refused the file.
impl From<JointDraft> for Joint {
    fn from(draft: JointDraft) -> Joint {
        Joint {
            name: draft.name.unwrap_or_default(),
            joint_type: draft.kind.unwrap_or(JointType::Fixed),
            origin: draft.origin,
            parent: draft.parent.map_or_else(String::new, |end| end.value),
            child: draft.child.map_or_else(String::new, |end| end.value),
            axis: draft.axis,
            limit: draft.limit,
            mimic: draft.mimic.map(|mimic| Mimic {
                joint: mimic.joint.value,
                multiplier: mimic.multiplier,
                offset: mimic.offset,
            }),
        }
    }
}

pub(super) fn read_joint(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
) -> JointDraft {
    let line = reader.line(node);
    let (name, subject) = reader.subject(node, "joint");
    let kind = read_kind(reader, node, &subject);
    let mut joint = JointDraft {
        line,
        name,
        kind,
        origin: read_origin(reader, node, version, &subject, "origin"),
        parent: read_end(reader, node, &subject, "parent"),
        child: read_end(reader, node, &subject, "child"),
        axis: [1.0, 0.0, 0.0],
        limit: Limit::NONE,
        mimic: None,
    };
    if kind.is_some_and(JointType::has_axis) {
        joint.axis = read_axis(reader, node, &subject);
    }
    if let Some(kind) = kind {
        joint.limit = read_limit(reader, node, kind, &subject);
    }
    let mimic = reader.only(node, "mimic", &subject);
    match (mimic, kind) {
        (Some(mimic), Some(JointType::Fixed)) => {
            let line = reader.line(mimic);
            reader.note(
                line,
                format!("{subject}: a fixed joint does not move; its mimic is ignored"),
            );
        }
        (Some(mimic), Some(kind)) if !kind.is_single() => {
            let line = reader.line(mimic);
            reader.complain(
                line,
                format!(
                    "{subject}: a {} joint has several coordinates and cannot mimic; remove <mimic>",
                    kind.name()
                ),
            );
        }
        (Some(mimic), _) => joint.mimic = read_mimic(reader, mimic, &subject),
        (None, _) => {}
    }
    joint
}

fn read_kind(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> Option<JointType> {
    let Some(text) = reader.attribute(node, "type") else {
        let line = reader.line(node);
        reader.complain(
            line,
            format!("{subject}: no type; add type=\"revolute\", \"fixed\" or another"),
        );
        return None;
    };
    if reader.unexpanded(subject, "type", &text) {
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
    reader.complain(
        text.line,
        format!("{subject}: type {} is not supported{remedy}", shown(found)),
    );
    None
}

/// `<parent link>` or `<child link>`.
fn read_end(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    subject: &str,
    end: &str,
) -> Option<At<String>> {
    let found = reader.only(node, end, subject);
    let text = found.and_then(|found| reader.attribute(found, "link"));
    let Some(text) = text else {
        let line = reader.line(found.unwrap_or(node));
        reader.complain(
            line,
            format!("{subject}: no {end}; add <{end} link=\"...\"/>"),
        );
        return None;
    };
    let value = reader.name(&text, subject, end)?;
    Some(At {
        value,
        line: text.line,
    })
}

fn read_axis(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> [f64; 3] {
    let default = [1.0, 0.0, 0.0];
    let found = reader.only(node, "axis", subject);
    let Some(text) = found.and_then(|found| reader.attribute(found, "xyz")) else {
        return default;
    };
    let Some(axis) = reader.numbers::<3>(&text, subject, "axis xyz") else {
        return default;
    };
    let longest = axis.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    if longest < limits::AXIS {
        reader.complain(
            text.line,
            format!("{subject}: axis is zero; give <axis xyz> a direction"),
        );
    } else if longest > 1.0 / limits::AXIS {
        reader.complain(
            text.line,
            format!("{subject}: axis holds {longest:e}; give <axis xyz> a unit vector"),
        );
    }
    axis
}

fn read_mimic(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> Option<MimicDraft> {
    let multiplier = reader.attribute(node, "multiplier");
    let multiplier = multiplier.map(|text| reader.number(&text, subject, "mimic multiplier"));
    let offset = reader.attribute(node, "offset");
    let offset = offset.map(|text| reader.number(&text, subject, "mimic offset"));
    let Some(text) = reader.attribute(node, "joint") else {
        let line = reader.line(node);
        reader.complain(
            line,
            format!("{subject}: mimic of no joint; add <mimic joint=\"...\"/>"),
        );
        return None;
    };
    let value = reader.name(&text, subject, "mimic joint")?;
    Some(MimicDraft {
        joint: At {
            value,
            line: text.line,
        },
        multiplier: multiplier.flatten().unwrap_or(1.0),
        offset: offset.flatten().unwrap_or(0.0),
    })
}
