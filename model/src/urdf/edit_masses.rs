//! Masses and centres of mass written into the text of a URDF. Everything else
//! stays byte for byte: comments, blanks, leftovers of xacro.
//!
//! ```text
//! m → m'        c → c'        I → I m'/m
//! ```
//!
//! Inertia about the CoM is scaled with the mass: data of a robot at rest say
//! nothing of it, and a link whose density is off keeps its radii of gyration.

use roxmltree::Node;

use super::description::{Description, INERTIA};
use super::edits::{Edits, SAME, number, three};
use super::error::Error;
use super::source::{Source, children, links};

/// What a link weighs and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// kg
    pub mass_kg: f64,
    /// Centre of mass in the link frame, m.
    pub com_m: [f64; 3],
}

/// A change of a mass below this, relative, is rounding.
const SAME_MASS: f64 = 1e-15;
/// Radius of gyration given to a link that had no inertia, m.
const GYRATION_M: f64 = 0.02;

/// The text of a URDF with other weights, one for each link in document order;
/// `None` leaves a link alone.
///
/// # Errors
/// When the text of the description was changed and is no URDF any more.
pub fn edit_masses(description: &Description, weights: &[Option<Weight>]) -> Result<String, Error> {
    let source = Source::of(description)?;
    let document = source.document()?;
    let mut edits = Edits::new(&source, &description.text);
    for (link, weight) in links(&document).zip(weights) {
        let Some(weight) = weight else { continue };
        match children(link, "inertial").next() {
            Some(inertial) => edits.replace(inertial, weight),
            None => edits.insert(link, weight),
        }
    }
    Ok(edits.applied())
}

impl Edits<'_> {
    /// Another weight for an `<inertial>`.
    fn replace(&mut self, inertial: Node<'_, '_>, weight: &Weight) {
        let Some(mass) = children(inertial, "mass").next() else {
            return;
        };
        let old = mass.attribute("value").and_then(number).unwrap_or(0.0);
        let mass_changes = (weight.mass_kg - old).abs() > SAME_MASS * old.abs();
        if mass_changes {
            self.set(mass, "value", weight.mass_kg);
        }
        match children(inertial, "origin").next() {
            Some(origin) => self.set_three(origin, "xyz", weight.com_m),
            None if weight.com_m.iter().any(|x| x.abs() > SAME) => {
                let at = self.place(&mass.range()).start;
                let element = format!("<origin xyz=\"{}\"/>", three(weight.com_m));
                let blank = self.blank_before(at);
                self.put(at..at, element + blank);
            }
            None => {}
        }
        if let Some(inertia) = children(inertial, "inertia")
            .next()
            .filter(|_| mass_changes)
        {
            for entry in INERTIA {
                let value = inertia.attribute(entry).and_then(number);
                if let Some(value) = value.filter(|value| *value != 0.0 && old > 0.0) {
                    self.set(inertia, entry, value * (weight.mass_kg / old));
                }
            }
        }
    }

    /// An `<inertial>` for a link that has none.
    fn insert(&mut self, link: Node<'_, '_>, weight: &Weight) {
        let moment = weight.mass_kg * GYRATION_M * GYRATION_M;
        let inertial = format!(
            "<inertial><origin xyz=\"{}\"/><mass value=\"{:?}\"/>\
             <inertia ixx=\"{moment:?}\" ixy=\"0\" ixz=\"0\" iyy=\"{moment:?}\" iyz=\"0\" izz=\"{moment:?}\"/>\
             </inertial>",
            three(weight.com_m),
            weight.mass_kg
        );
        let place = self.place(&link.range());
        if let Some(open) = self.written(&place).strip_suffix("/>") {
            let name = open[1..]
                .split(|c: char| c.is_whitespace() || c == '/')
                .next()
                .unwrap_or("link");
            let close = place.end - 2;
            self.put(close..place.end, format!(">{inertial}</{name}>"));
            return;
        }
        self.put_first(link, &inertial);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf::parse;

    const TEXT: &str = "\u{feff}<?xml version='1.0'?>\r\n<!-- a -- b -->\n<robot name='r' x:y='1'>\n\
        <link name='a'>\n  <inertial>\n    <mass value=' 2.0 '/> <!-- weighed -->\n\
        \x20   <origin rpy='0 0 0.5'\txyz='0.10  -.2 3e-1'/>\n    <inertia ixx='1' ixy='0' ixz='0' iyy='2.' iyz='0' izz='4'/>\n\
        \x20 </inertial></link>\n<link name='b'/><xacro:property bar='${x}'/>\n\
        <link name=\"c\">\n  <visual/>\n</link><link name='d'><inertial>\n\t<mass value='1'/></inertial></link>\n\
        <link name='e'><inertial><origin/><mass value='1'/></inertial></link>\n\
        <joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>\n\
        <joint name='k' type='fixed'><parent link='a'/><child link='c'/></joint>\n\
        <joint name='l' type='fixed'><parent link='a'/><child link='d'/></joint>\n\
        <joint name='m' type='fixed'><parent link='a'/><child link='e'/></joint>\n</robot>\n";

    fn weight(mass_kg: f64, com_m: [f64; 3]) -> Option<Weight> {
        Some(Weight { mass_kg, com_m })
    }

    #[test]
    fn other_bytes_stay() {
        let weights = [
            weight(3.0, [0.1, -0.2, 0.25]),
            None,
            None,
            weight(1.0, [0.0; 3]),
            None,
        ];
        let expected = TEXT
            .replace("' 2.0 '", "'3.0'")
            .replace("3e-1", "0.25")
            .replace("ixx='1'", "ixx='1.5'")
            .replace("iyy='2.'", "iyy='3.0'")
            .replace("izz='4'", "izz='6.0'");
        let read = parse(TEXT, "r.urdf").unwrap();
        assert_eq!(edit_masses(&read, &weights).unwrap(), expected);
        assert_eq!(edit_masses(&read, &[None; 5]).unwrap(), TEXT);
    }

    #[test]
    fn what_is_missing_is_added_and_reads_back() {
        let third = 1.0 / 3.0;
        let wanted = weight(third, [third, -1e-9, 0.1 + 0.7]);
        let text = edit_masses(&parse(TEXT, "r.urdf").unwrap(), &[wanted; 5]).unwrap();
        let read = parse(&text, "r.urdf").unwrap();
        for link in &read.links {
            assert_eq!(link.inertial.mass_kg, third, "{}", link.name);
            assert_eq!(link.inertial.origin.xyz, [third, -1e-9, 0.1 + 0.7]);
        }
        assert_eq!(read.links[0].inertial.origin.rpy[2], 0.5);
        for kept in [
            "<!-- weighed -->",
            "<xacro:property bar='${x}'/>",
            "<visual/>",
            "\r\n",
        ] {
            assert!(text.contains(kept), "{kept}");
        }
    }
}
