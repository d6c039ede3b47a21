//! Links: mass and where it sits. Inertia is carried along, not needed.

use roxmltree::Node;

use super::draft::Version;
use super::limits;
use super::report::shown;
use super::rotation::rpy_of_quaternion;
use super::values::{At, Reader};

pub(super) struct Link {
    pub(super) line: u32,
    /// None after a complaint about it.
    pub(super) name: Option<String>,
    pub(super) inertial: Inertial,
}

pub(super) enum Inertial {
    Massless,
    Massive {
        origin: Origin,
        mass_kg: f64,
        /// ixx, ixy, ixz, iyy, iyz, izz
        inertia: [f64; 6],
    },
    /// Complained about.
    Faulty,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Origin {
    pub(super) xyz: [f64; 3],
    pub(super) rpy: [f64; 3],
}

pub(super) const INERTIA: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

pub(super) fn read_link(reader: &mut Reader<'_>, node: Node<'_, '_>, version: Version) -> Link {
    let line = reader.line(node);
    let (name, subject) = read_name(reader, node, "link");
    let mut link = Link {
        line,
        name,
        inertial: Inertial::Massless,
    };
    if let Some(inertial) = reader.only(node, "inertial", &subject) {
        link.inertial = read_inertial(reader, inertial, version, &subject);
    }
    link
}

/// The name of a link or joint, and how messages call it.
pub(super) fn read_name(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    kind: &str,
) -> (Option<String>, String) {
    let Some(text) = reader.attribute(node, "name") else {
        let line = reader.line(node);
        reader.complain(
            line,
            format!("a {kind} without a name; add <{kind} name=\"...\">"),
        );
        return (None, kind.to_owned());
    };
    let subject = format!("{kind} {}", shown(text.value));
    let name = reader.name(&text, &subject, "name");
    (name, subject)
}

fn read_inertial(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
    subject: &str,
) -> Inertial {
    let origin = read_origin(reader, node, version, subject, "inertial origin");
    let mass_kg = read_mass(reader, node, subject);
    let inertia = read_inertia(reader, node, subject);
    match mass_kg {
        Some(mass_kg) => Inertial::Massive {
            origin,
            mass_kg,
            inertia,
        },
        None => Inertial::Faulty,
    }
}

fn read_mass(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> Option<f64> {
    let Some(mass) = reader.only(node, "mass", subject) else {
        let line = reader.line(node);
        reader.complain(
            line,
            format!("{subject}: inertial without a mass; add <mass value=\"...\"/>, 0 for none"),
        );
        return None;
    };
    let Some(text) = reader.attribute(mass, "value") else {
        let line = reader.line(mass);
        reader.complain(
            line,
            format!("{subject}: mass without a value; write <mass value=\"...\"/> in kg"),
        );
        return None;
    };
    let mass_kg = reader.number(&text, subject, "mass")?;
    if mass_kg < 0.0 {
        reader.complain(
            text.line,
            format!("{subject}: mass is {mass_kg} kg; a mass is not negative"),
        );
        return None;
    }
    if mass_kg > limits::MASS_KG {
        reader.complain(
            text.line,
            format!("{subject}: mass is {mass_kg:e} kg; no robot is that heavy, give it in kg"),
        );
        return None;
    }
    Some(mass_kg)
}

/// Missing entries are zero; broken ones too, with a note, for nothing here
/// depends on them.
fn read_inertia(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> [f64; 6] {
    let Some(inertia) = reader.only(node, "inertia", subject) else {
        return [0.0; 6];
    };
    INERTIA.map(|entry| {
        let text = reader.attribute(inertia, entry);
        text.and_then(|text| unneeded_number(reader, &text, subject, &format!("inertia {entry}")))
            .unwrap_or(0.0)
    })
}

/// A number that only passes through.
pub(super) fn unneeded_number(
    reader: &mut Reader<'_>,
    text: &At<&str>,
    subject: &str,
    what: &str,
) -> Option<f64> {
    if reader.unexpanded(subject, what, text) {
        return None;
    }
    match text.value.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Some(value),
        _ => {
            let found = shown(text.value);
            reader.note(
                text.line,
                format!("{subject}: {what} is {found}; not needed, taken as 0"),
            );
            None
        }
    }
}

/// `<origin>` of a joint or an inertial; what is missing is zero.
pub(super) fn read_origin(
    reader: &mut Reader<'_>,
    parent: Node<'_, '_>,
    version: Version,
    subject: &str,
    what: &str,
) -> Origin {
    let Some(node) = reader.only(parent, "origin", subject) else {
        return Origin::default();
    };
    let mut origin = Origin::default();
    if let Some(text) = reader.attribute(node, "xyz") {
        let what = format!("{what} xyz");
        origin.xyz = reader.numbers(&text, subject, &what).unwrap_or_default();
        if let Some(far) = origin.xyz.iter().find(|v| v.abs() > limits::OFFSET_M) {
            reader.complain(
                text.line,
                format!("{subject}: {what} holds {far:e} m; no robot is that large, give it in m"),
            );
        }
    }
    let rpy = reader.attribute(node, "rpy");
    if let Some(text) = &rpy {
        let what = format!("{what} rpy");
        origin.rpy = reader.numbers(text, subject, &what).unwrap_or_default();
        if let Some(angle) = origin.rpy.iter().find(|v| v.abs() > limits::ANGLE_RAD) {
            reader.note(
                text.line,
                format!("{subject}: {what} holds {angle} rad; is it in degrees?"),
            );
        }
    }
    if let Some(text) = reader.attribute(node, "quat_xyzw") {
        let what = format!("{what} quat_xyzw");
        if version < Version::QUATERNIONS {
            reader.note(
                text.line,
                format!("{subject}: {what} is ignored before <robot version=\"1.1\">"),
            );
        } else if rpy.is_some() {
            reader.complain(
                text.line,
                format!("{subject}: {what} and rpy are both given; keep one"),
            );
        } else if let Some(quaternion) = reader.numbers(&text, subject, &what) {
            match rpy_of_quaternion(quaternion) {
                Some(rpy) => origin.rpy = rpy,
                None => reader.complain(
                    text.line,
                    format!("{subject}: {what} is zero; write 0 0 0 1 for no rotation"),
                ),
            }
        }
    }
    origin
}
