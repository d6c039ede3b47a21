//! Lenient XML, strict values: the reading that knows no robot.

use std::collections::HashSet;

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{Error, Problem};

/// The children of that name in the parent's own namespace: `<xacro:joint>`
/// is no joint.
pub(crate) fn children<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    name: &str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| {
        child.is_element()
            && child.tag_name().name() == name
            && child.tag_name().namespace() == node.tag_name().namespace()
    })
}

pub(crate) fn child<'a, 'input: 'a>(
    node: Node<'a, 'input>,
    name: &str,
) -> Option<Node<'a, 'input>> {
    children(node, name).next()
}

pub(crate) fn missing(place: &str, what: &'static str) -> Error {
    Problem::Missing {
        place: place.to_owned(),
        what,
    }
    .into()
}

/// An attribute that is read; a macro expression in it is an error.
pub(crate) fn text_of<'a>(
    node: Node<'a, '_>,
    place: &str,
    name: &str,
) -> Result<Option<&'a str>, Error> {
    match node.attribute(name) {
        Some(text) if text.contains("${") => Err(Problem::Xacro {
            place: place.to_owned(),
            text: text.to_owned(),
        }
        .into()),
        text => Ok(text),
    }
}

/// `N` finite numbers in one attribute, if it is there.
pub(crate) fn numbers<const N: usize>(
    node: Node,
    place: &str,
    attribute: &'static str,
) -> Result<Option<[f64; N]>, Error> {
    read_numbers(node, place, attribute, f64::is_finite)
}

/// `N` numbers that may be infinite.
pub(crate) fn bounds<const N: usize>(
    node: Node,
    place: &str,
    attribute: &'static str,
) -> Result<Option<[f64; N]>, Error> {
    read_numbers(node, place, attribute, |number| !number.is_nan())
}

fn read_numbers<const N: usize>(
    node: Node,
    place: &str,
    attribute: &'static str,
    admits: fn(f64) -> bool,
) -> Result<Option<[f64; N]>, Error> {
    let Some(text) = text_of(node, place, attribute)? else {
        return Ok(None);
    };
    let parsed: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
    parsed
        .ok()
        .and_then(|values| <[f64; N]>::try_from(values).ok())
        .filter(|values| values.iter().copied().all(admits))
        .map(Some)
        .ok_or_else(|| {
            Problem::Number {
                place: place.to_owned(),
                attribute,
                text: text.to_owned(),
                expected: match N {
                    1 => "one number",
                    3 => "three numbers",
                    _ => "four numbers",
                },
            }
            .into()
        })
}

pub(crate) fn parse(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions {
        allow_dtd: true,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
}

/// Takes out comments, line ends kept: XML forbids dashes in them, files do not.
pub(crate) fn strip_comments(text: &str) -> String {
    let mut rest = text.trim_start_matches('\u{feff}').trim_start();
    let mut kept = String::with_capacity(rest.len());
    while let Some(start) = rest.find("<!--") {
        let Some(length) = rest[start + 4..].find("-->") else {
            break;
        };
        let end = start + 4 + length + 3;
        kept.push_str(&rest[..start]);
        kept.extend(rest[start..end].chars().filter(|&c| c == '\n'));
        rest = &rest[end..];
    }
    kept.push_str(rest);
    kept
}

/// Declares on the root element every prefix that the file uses undeclared,
/// as simulator blocks often do.
pub(crate) fn declare_prefixes(mut text: String) -> Result<String, Error> {
    let mut declared = HashSet::new();
    loop {
        let prefix = match parse(&text) {
            Ok(_) => return Ok(text),
            Err(roxmltree::Error::UnknownNamespace(prefix, at)) => {
                if !declared.insert(prefix.clone()) {
                    let twice = roxmltree::Error::UnknownNamespace(prefix, at);
                    return Err(Problem::Xml(twice).into());
                }
                prefix
            }
            Err(error) => return Err(Problem::Xml(error).into()),
        };
        let tag = text
            .match_indices('<')
            .map(|(at, _)| at + 1)
            .find(|&at| text[at..].starts_with(|c: char| c.is_alphabetic() || c == '_'))
            .expect("an XML document has a root element");
        let length = text[tag..]
            .find(|c: char| c.is_whitespace() || c == '>' || c == '/')
            .expect("a tag has an end");
        text.insert_str(
            tag + length,
            &format!(" xmlns:{prefix}=\"undeclared:{prefix}\""),
        );
    }
}
