//! Links: mass and where it sits, and the inertia that motion feels.

use roxmltree::Node;

use super::description::{INERTIA, Inertial, Link};
use super::limits;
use super::origin::{Version, read_origin};
use super::values::Reader;

pub(super) struct LinkDraft {
    pub(super) line: u32,
    /// None after a complaint about it.
    pub(super) name: Option<String>,
    /// None after a complaint about it; zero where the link has none.
    pub(super) inertial: Option<Inertial>,
}

// The checks found everything that is `None` in a draft and refused the file.
impl From<LinkDraft> for Link {
    fn from(draft: LinkDraft) -> Link {
        Link {
            name: draft.name.unwrap_or_default(),
            inertial: draft.inertial.unwrap_or_default(),
        }
    }
}

pub(super) fn read_link(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
) -> LinkDraft {
    let line = reader.line(node);
    let (name, subject) = reader.subject(node, "link");
    let inertial = match reader.only(node, "inertial", &subject) {
        Some(inertial) => read_inertial(reader, inertial, version, &subject),
        None => Some(Inertial::default()),
    };
    LinkDraft {
        line,
        name,
        inertial,
    }
}

fn read_inertial(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
    subject: &str,
) -> Option<Inertial> {
    let origin = read_origin(reader, node, version, subject, "inertial origin");
    let mass_kg = read_mass(reader, node, subject);
    let inertia = read_inertia(reader, node, subject);
    Some(Inertial {
        mass_kg: mass_kg?,
        origin,
        inertia,
    })
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

/// Missing entries are zero; broken ones too, with a note, for nothing at rest
/// depends on them.
fn read_inertia(reader: &mut Reader<'_>, node: Node<'_, '_>, subject: &str) -> [f64; 6] {
    let Some(inertia) = reader.only(node, "inertia", subject) else {
        return [0.0; 6];
    };
    INERTIA.map(|entry| {
        let text = reader.attribute(inertia, entry);
        text.map_or(0.0, |text| {
            let what = format!("inertia {entry}");
            let means = "taken as 0, which the ZMP alone feels";
            let value = reader.or_zero(&text, subject, &what, means);
            if value.abs() > limits::INERTIA_KGM2 {
                reader.complain(
                    text.line,
                    format!(
                        "{subject}: {what} is {value:e} kg m²; no robot has as much, give it in \
                         kg m²"
                    ),
                );
            }
            value
        })
    })
}
