//! The text that urdf-rs is given: what centre of mass and motion depend on, and nothing else.
//!
//! urdf-rs gives up on files that lack, misspell or repeat what neither depends on (an inertia, a
//! velocity limit, a shape), and on prefixes that nobody declared. Links and joints are therefore
//! written anew by [`TABLE`]. Two things urdf-rs would lose: it skips words of a vector that are no
//! numbers, so they are errors here, and it rounds a quaternion to a pitch of ±90° from 0.26°
//! away, so quaternions become angles here ([`angles`]).

use roxmltree::{Document, Node};

use crate::error::{Error, Problem};
use crate::quaternion::{angles, numbers, place};
use crate::xml::mend;

/// What an attribute holds, with the neutral value that stands for an absent one.
enum Holds {
    /// A name or a word.
    Text,
    /// So many finite numbers.
    Numbers(&'static str),
    /// The same, but the neutral value stands for an unreadable one, too: no CoM depends on it.
    /// An element that holds nothing else is put where it is absent.
    Free(&'static str),
}
use Holds::{Free, Numbers, Text};

/// Parent, element, attribute, and what it holds.
const TABLE: [(&str, &str, &str, Holds); 24] = [
    ("robot", "link", "name", Text),
    ("link", "inertial", "", Text),
    ("inertial", "origin", "xyz", Numbers("0 0 0")),
    ("inertial", "origin", "rpy", Free("0 0 0")),
    ("inertial", "mass", "value", Text),
    ("inertial", "inertia", "ixx", Free("0")),
    ("inertial", "inertia", "ixy", Free("0")),
    ("inertial", "inertia", "ixz", Free("0")),
    ("inertial", "inertia", "iyy", Free("0")),
    ("inertial", "inertia", "iyz", Free("0")),
    ("inertial", "inertia", "izz", Free("0")),
    ("robot", "joint", "name", Text),
    ("robot", "joint", "type", Text),
    ("joint", "origin", "xyz", Numbers("0 0 0")),
    ("joint", "origin", "rpy", Numbers("0 0 0")),
    ("joint", "parent", "link", Text),
    ("joint", "child", "link", Text),
    ("joint", "axis", "xyz", Numbers("1 0 0")),
    ("joint", "limit", "lower", Free("0")),
    ("joint", "limit", "upper", Free("0")),
    ("joint", "limit", "velocity", Free("0")),
    ("joint", "mimic", "joint", Text),
    ("joint", "mimic", "multiplier", Numbers("1")),
    ("joint", "mimic", "offset", Numbers("0")),
];

/// What urdf-rs reads of `text`, completed.
pub(crate) fn complete(text: &str) -> Result<String, Error> {
    let text = mend(text);
    let document = Document::parse(&text).map_err(Problem::Xml)?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let root = root.tag_name().name().to_owned();
        return Err(Problem::NotARobot { root }.into());
    }
    let mut out = String::from("<robot");
    put("name", root.attribute("name").unwrap_or_default(), &mut out);
    put_inside("robot", root, &mut out)?;
    Ok(out)
}

/// Put what the table reads of `node` behind its attributes, up to its end tag.
fn put_inside(name: &str, node: Node, out: &mut String) -> Result<(), Error> {
    out.push('>');
    let kind = node.attribute("type").unwrap_or_default().trim();
    let moves = matches!(kind, "revolute" | "continuous" | "prismatic");
    let of_motion = |element: &str| matches!(element, "axis" | "limit" | "mimic");
    let own = TABLE.iter().filter(|row| row.0 == name);
    let own: Vec<_> = own.filter(|row| moves || !of_motion(row.1)).collect();
    for rows in own.chunk_by(|a, b| a.1 == b.1) {
        let element = rows[0].1;
        let same = node.children().filter(|child| child.has_tag_name(element));
        let most = if name == "robot" { usize::MAX } else { 1 };
        let mut found: Vec<Option<Node>> = same.take(most).map(Some).collect();
        if found.is_empty() && rows.iter().all(|row| matches!(row.3, Free(_))) {
            found.push(None);
        }
        for child in found {
            out.extend(["<", element]);
            let turned = child.map_or(Ok(None), angles)?;
            for (.., attribute, holds) in rows {
                let given = child.and_then(|child| child.attribute(*attribute));
                let given = turned.as_deref().filter(|_| *attribute == "rpy").or(given);
                if let Some(value) = readable(node, attribute, holds, given)? {
                    put(attribute, value, out);
                }
            }
            match child {
                Some(child) => put_inside(element, child, out)?,
                None => out.push_str("/>"),
            }
        }
    }
    out.extend(["</", name, ">"]);
    Ok(())
}

/// The value of an attribute, or the neutral one.
fn readable<'a>(
    node: Node,
    attribute: &'static str,
    holds: &Holds,
    given: Option<&'a str>,
) -> Result<Option<&'a str>, Error> {
    let endless = matches!(attribute, "lower" | "upper");
    let is_like = |neutral: &str, text: &str| {
        let numbers = numbers(text);
        let admits = |x: &f64| x.is_finite() || (endless && !x.is_nan());
        numbers.len() == neutral.split(' ').count() && numbers.iter().all(admits)
    };
    match (holds, given) {
        (Text, Some(text)) if attribute == "type" => Ok(Some(text.trim())),
        (Text, text) => Ok(text),
        (Numbers(neutral) | Free(neutral), None) => Ok(Some(neutral)),
        (Numbers(neutral) | Free(neutral), Some(text)) if is_like(neutral, text) => Ok(Some(text)),
        (Free(neutral), Some(_)) => Ok(Some(neutral)),
        (Numbers(_), Some(text)) => {
            let (place, text) = (place(node), text.to_owned());
            Err(Problem::Number {
                place,
                attribute,
                text,
            }
            .into())
        }
    }
}

fn put(attribute: &str, value: &str, out: &mut String) {
    let value = value.replace('&', "&amp;").replace('<', "&lt;");
    out.extend([" ", attribute, "=\"", &value.replace('"', "&quot;"), "\""]);
}
