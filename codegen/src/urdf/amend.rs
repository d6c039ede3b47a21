//! Masses and centres of mass written into the text of a URDF, and nothing else
//! touched: comments, blanks, leftovers of xacro survive byte for byte.
//!
//! ```text
//! m → m'        c → c'        I → I m'/m
//! ```
//!
//! Inertia about the CoM is scaled with the mass: data of a robot at rest say
//! nothing of it, and a link whose density is off keeps its radii of gyration.
//! Numbers are the shortest that read back to the last bit; one that does not
//! change stays as it was written.

use std::ops::Range;

use roxmltree::Node;

use super::Error;
use super::link::INERTIA;
use super::source::{Source, children, links};

/// What a link weighs and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    pub mass_kg: f64,
    /// Centre of mass in the link frame, m.
    pub com_m: [f64; 3],
}

/// A change of a mass below this, relative, is rounding.
const SAME_MASS: f64 = 1e-15;
/// A change of a coordinate below this is rounding, m.
const SAME_M: f64 = 1e-16;
/// Radius of gyration given to a link that had no inertia, m.
const GYRATION_M: f64 = 0.02;

/// The text with the weights of its links replaced, in document order of the links;
/// `None` leaves a link alone.
///
/// # Errors
/// When the text is no URDF.
pub fn amend(text: &str, file: &str, weights: &[Option<Weight>]) -> Result<String, Error> {
    let source = Source::of(text, file)?;
    let document = source.document(file)?;
    let mut edits = Edits {
        source: &source,
        text,
        edits: Vec::new(),
    };
    for (link, weight) in links(&document).zip(weights) {
        let Some(weight) = weight else { continue };
        match children(link, "inertial").next() {
            Some(inertial) => edits.replace(inertial, weight),
            None => edits.insert(link, weight),
        }
    }
    Ok(edits.applied())
}

/// Pieces of text and what takes their place.
struct Edits<'a> {
    source: &'a Source,
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
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
            Some(origin) => self.move_to(origin, weight.com_m),
            None if weight.com_m.iter().any(|x| x.abs() > SAME_M) => {
                let at = self.source.original(&mass.range()).start;
                let element = format!("<origin xyz=\"{}\"/>", three(weight.com_m));
                self.edits.push((at..at, element + self.blank_before(at)));
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
        let place = self.source.original(&link.range());
        let written = &self.text[place.clone()];
        if let Some(open) = written.strip_suffix("/>") {
            let name = open[1..]
                .split(|c: char| c.is_whitespace() || c == '/')
                .next()
                .unwrap_or("link");
            let close = place.end - 2;
            self.edits
                .push((close..place.end, format!(">{inertial}</{name}>")));
            return;
        }
        let first = link.first_child().map(|child| child.range());
        let at = match first {
            Some(child) => self.source.original(&child).start,
            None => place.start + written.rfind("</").unwrap_or(written.len()),
        };
        let blank: String = self.text[at..]
            .chars()
            .take_while(|c| c.is_whitespace())
            .collect();
        self.edits.push((at..at, blank + &inertial));
    }

    /// Coordinates of an origin; those that stay, stay as they are written.
    fn move_to(&mut self, origin: Node<'_, '_>, com: [f64; 3]) {
        let Some(xyz) = origin.attribute_node("xyz") else {
            if com.iter().any(|x| x.abs() > SAME_M) {
                let place = self.source.original(&origin.range());
                let written = &self.text[place.clone()];
                let name = written
                    .find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'))
                    .unwrap_or(written.len());
                let at = place.start + name;
                self.edits
                    .push((at..at, format!(" xyz=\"{}\"", three(com))));
            }
            return;
        };
        let place = self.source.original(&xyz.range_value());
        let written = &self.text[place.clone()];
        let words: Vec<&str> = written.split_whitespace().collect();
        let old: Option<Vec<f64>> = words.iter().map(|word| number(word)).collect();
        let Some(old) = old.filter(|old| old.len() == 3) else {
            self.edits.push((place, three(com)));
            return;
        };
        for axis in 0..3 {
            if (com[axis] - old[axis]).abs() > SAME_M {
                let at = place.start + (words[axis].as_ptr() as usize - written.as_ptr() as usize);
                self.edits
                    .push((at..at + words[axis].len(), format!("{:?}", com[axis])));
            }
        }
    }

    fn set(&mut self, node: Node<'_, '_>, name: &str, value: f64) {
        match node.attribute_node(name) {
            Some(attribute) => {
                let place = self.source.original(&attribute.range_value());
                self.edits.push((place, format!("{value:?}")));
            }
            None => {
                let place = self.source.original(&node.range());
                let end = self.text[place.clone()].find(['/', '>']).unwrap_or(0);
                let at = place.start + end;
                self.edits.push((at..at, format!(" {name}=\"{value:?}\"")));
            }
        }
    }

    /// Blanks before a place, from the end of what stands there.
    fn blank_before(&self, at: usize) -> &str {
        let before = &self.text[..at];
        &before[before.trim_end().len()..]
    }

    fn applied(mut self) -> String {
        self.edits
            .sort_by_key(|(place, _)| (place.start, place.end));
        let mut out = String::with_capacity(self.text.len() + 64 * self.edits.len());
        let mut at = 0;
        for (place, new) in &self.edits {
            out.push_str(&self.text[at..place.start]);
            out.push_str(new);
            at = place.end;
        }
        out.push_str(&self.text[at..]);
        out
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

fn three([x, y, z]: [f64; 3]) -> String {
    format!("{x:?} {y:?} {z:?}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::urdf::parse;

    const TEXT: &str = "\u{feff}<?xml version='1.0'?>\r\n<!-- a -- b -->\n<robot name='r' x:y='1'>\n\
        <link name='a'>\n  <inertial>\n    <mass value=' 2.0 '/> <!-- weighed -->\n\
        \x20   <origin rpy='0 0 0.5'\txyz='0.10  -.2 3e-1'/>\n    <inertia ixx='1' ixy='0' ixz='0' iyy='2.' iyz='0' izz='4'/>\n\
        \x20 </inertial></link>\n<link name='b'/><xacro:foo bar='${x}'/>\n\
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
    fn only_what_changes_changes() {
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
        assert_eq!(amend(TEXT, "r.urdf", &weights).unwrap(), expected);
        assert_eq!(amend(TEXT, "r.urdf", &[None; 5]).unwrap(), TEXT);
    }

    #[test]
    fn what_is_missing_is_added_and_reads_back() {
        let third = 1.0 / 3.0;
        let wanted = weight(third, [third, -1e-9, 0.1 + 0.7]);
        let text = amend(TEXT, "r.urdf", &[wanted; 5]).unwrap();
        let read = parse(&text, "r.urdf").unwrap();
        for link in &read.robot.links {
            assert_eq!(link.inertial.mass.value, third, "{}", link.name);
            assert_eq!(*link.inertial.origin.xyz, [third, -1e-9, 0.1 + 0.7]);
        }
        assert_eq!(read.robot.links[0].inertial.origin.rpy[2], 0.5);
        for kept in [
            "<!-- weighed -->",
            "<xacro:foo bar='${x}'/>",
            "<visual/>",
            "\r\n",
        ] {
            assert!(text.contains(kept), "{kept}");
        }
    }
}
