//! Links: mass and where it sits, and the inertia that motion feels.

use roxmltree::Node;

use super::description::{INERTIA, Inertial, Link};
use super::limits;
use super::origin::{Version, read_origin};
use super::values::Reader;

/// A link as it is found, and where: without a name after a complaint about that.
pub(super) struct LinkDraft {
    pub(super) found: Link,
    pub(super) line: u32,
}

pub(super) fn read_link(
    reader: &mut Reader<'_>,
    node: Node<'_, '_>,
    version: Version,
) -> LinkDraft {
    let name = reader.named(node, "link");
    let inertial = match reader.only(node, "inertial") {
        Some(inertial) => read_inertial(reader, inertial, version),
        None => Inertial::default(),
    };
    LinkDraft {
        found: Link { name, inertial },
        line: reader.line(node),
    }
}

fn read_inertial(reader: &mut Reader<'_>, node: Node<'_, '_>, version: Version) -> Inertial {
    Inertial {
        origin: read_origin(reader, node, version, "inertial origin"),
        // Complained about: the robot is not also said to have no mass.
        mass_kg: read_mass(reader, node).unwrap_or(f64::NAN),
        inertia: read_inertia(reader, node),
    }
}

fn read_mass(reader: &mut Reader<'_>, node: Node<'_, '_>) -> Option<f64> {
    let Some(mass) = reader.only(node, "mass") else {
        let message = "inertial without a mass; add <mass value=\"...\"/>, 0 for none";
        return reader.refuse(reader.line(node), message);
    };
    let missing = "mass without a value; write <mass value=\"...\"/> in kg";
    let text = reader.needed(mass, "value", missing)?;
    let mass_kg = reader.number(&text, "mass")?;
    if mass_kg < 0.0 {
        let message = format!("mass is {mass_kg} kg; a mass is not negative");
        return reader.refuse(text.line, message);
    }
    if mass_kg > limits::MASS_KG {
        let message = format!("mass is {mass_kg:e} kg; no robot is that heavy, give it in kg");
        return reader.refuse(text.line, message);
    }
    Some(mass_kg)
}

/// Missing entries are zero; broken ones too, with a note, for nothing at rest
/// depends on them.
fn read_inertia(reader: &mut Reader<'_>, node: Node<'_, '_>) -> [f64; 6] {
    let Some(inertia) = reader.only(node, "inertia") else {
        return [0.0; 6];
    };
    INERTIA.map(|entry| {
        let text = reader.attribute(inertia, entry);
        text.map_or(0.0, |text| {
            let what = format!("inertia {entry}");
            let value = reader.or_zero(&text, &what, "taken as 0, which the ZMP alone feels");
            if value.abs() > limits::INERTIA_KGM2 {
                let remedy = "no robot has as much, give it in kg m²";
                reader.complain(text.line, format!("{what} is {value:e} kg m²; {remedy}"));
            }
            value
        })
    })
}
