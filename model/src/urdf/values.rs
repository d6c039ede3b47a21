//! Attributes read as names and numbers, with the complaint when they are not.

use std::fmt::Display;

use roxmltree::Node;

use super::limits;
use super::report::{Lines, Report, shown};
use super::source::{children, tag};
use crate::text::is_hidden;

/// The value of an attribute and the line it stands on.
pub(super) struct Text<'d> {
    pub(super) value: &'d str,
    pub(super) line: u32,
}

/// Reads one part of the tree.
pub(super) struct Reader<'a> {
    /// What was given, byte for byte as long as what was scanned.
    pub(super) text: &'a str,
    pub(super) lines: &'a Lines,
    pub(super) report: &'a mut Report,
    /// What messages are about: a link, a joint.
    pub(super) subject: String,
}

fn source<'a>(node: Node<'a, '_>) -> &'a str {
    &node.document().input_text()[node.range()]
}

impl Reader<'_> {
    pub(super) fn line(&self, node: Node<'_, '_>) -> u32 {
        self.lines.line(node.range().start)
    }

    /// The name of a tag as it is written, with its prefix.
    pub(super) fn tag(&self, node: Node<'_, '_>) -> &str {
        let name = node.range().start + 1;
        &self.text[name..name + tag(node).len()]
    }

    pub(super) fn complain(&mut self, line: u32, message: impl Display) {
        let message = format!("{}: {message}", self.subject);
        self.report.complain(line, message);
    }

    pub(super) fn note(&mut self, line: u32, message: impl Display) {
        let message = format!("{}: {message}", self.subject);
        self.report.note(line, message);
    }

    /// Nothing, with a complaint about it.
    pub(super) fn refuse<T>(&mut self, line: u32, message: impl Display) -> Option<T> {
        self.complain(line, message);
        None
    }

    /// The one child with this tag. A second one that says the same is noted,
    /// one that says something else is a contradiction.
    pub(super) fn only<'d, 'i>(&mut self, node: Node<'d, 'i>, name: &str) -> Option<Node<'d, 'i>> {
        let mut same = children(node, name);
        let first = same.next()?;
        if let Some(second) = same.next() {
            let (one, two) = (self.line(first), self.line(second));
            let repeats = first.first_element_child().is_none() && source(first) == source(second);
            if repeats {
                self.note(two, format!("a second <{name}>, the same as in line {one}"));
            } else {
                let first = format!("the first in line {one}");
                self.complain(two, format!("a second <{name}> ({first}); keep one"));
            }
        }
        Some(first)
    }

    pub(super) fn attribute<'d>(&self, node: Node<'d, '_>, name: &str) -> Option<Text<'d>> {
        node.attribute_node(name).map(|attribute| Text {
            value: attribute.value(),
            line: self.lines.line(attribute.range().start),
        })
    }

    /// An attribute that has to be there, or the complaint that it is not.
    pub(super) fn needed<'d>(
        &mut self,
        node: Node<'d, '_>,
        name: &str,
        missing: impl Display,
    ) -> Option<Text<'d>> {
        let found = self.attribute(node, name);
        found.or_else(|| self.refuse(self.line(node), missing))
    }

    /// Whether the text is still to be expanded; the report then says so.
    pub(super) fn unexpanded(&mut self, text: &Text, what: &str) -> bool {
        let holds = text.value.contains("${") || text.value.contains("$(");
        if holds {
            let what = format!("{}: {what} is {}", self.subject, shown(text.value));
            self.report.unexpanded(text.line, what);
        }
        holds
    }

    /// The name of a link or joint, which messages are about from here on; empty where it is
    /// complained about.
    pub(super) fn named(&mut self, node: Node<'_, '_>, kind: &str) -> String {
        self.subject = kind.to_string();
        let Some(text) = self.attribute(node, "name") else {
            let message = format!("a {kind} without a name; add <{kind} name=\"...\">");
            self.report.complain(self.line(node), message);
            return String::new();
        };
        self.subject = format!("{kind} {}", shown(text.value));
        self.name(&text, "name")
    }

    /// A name or a reference to one, empty where it is complained about. Any character will do
    /// but those that no message and no generated code could show ([`is_hidden`]).
    pub(super) fn name(&mut self, text: &Text, what: &str) -> String {
        let value = text.value;
        let hidden = value.chars().find(|c| is_hidden(*c));
        let fault = if value.trim().is_empty() {
            format!("{what} is empty; fill it in")
        } else if value.len() > limits::NAME_BYTES {
            let (name, most) = (shown(value), limits::NAME_BYTES);
            format!("{what} {name} is longer than {most} bytes; shorten it")
        } else if let Some(c) = hidden {
            let kind = match c.is_control() {
                true => "a control character",
                false => "a character that turns or breaks text",
            };
            format!("{what} {} holds {kind}; rename it", shown(value))
        } else {
            self.unexpanded(text, what);
            return value.to_owned();
        };
        self.complain(text.line, fault);
        String::new()
    }

    /// Exactly `N` finite numbers.
    pub(super) fn numbers<const N: usize>(&mut self, text: &Text, what: &str) -> Option<[f64; N]> {
        let values = self.extended_numbers(text, what)?;
        let Some(worst) = values.iter().find(|value| !value.is_finite()) else {
            return Some(values);
        };
        let message = format!("{what} is {worst}, not finite; give a plain number");
        self.refuse(text.line, message)
    }

    /// Exactly `N` numbers; infinities and NaN pass.
    pub(super) fn extended_numbers<const N: usize>(
        &mut self,
        text: &Text,
        what: &str,
    ) -> Option<[f64; N]> {
        if self.unexpanded(text, what) {
            return None;
        }
        let words = text.value.split_whitespace();
        let values: Result<Vec<f64>, &str> =
            words.map(|word| word.parse().map_err(|_| word)).collect();
        let values = match values {
            Ok(values) => values,
            Err(word) => {
                let (word, remedy) = (shown(word), remedy(text.value));
                return self.refuse(text.line, format!("{what}: {word} is not a number{remedy}"));
            }
        };
        values.try_into().ok().or_else(|| {
            let (found, count) = (shown(text.value), text.value.split_whitespace().count());
            self.refuse(
                text.line,
                format!("{what} {found} holds {count} numbers; give {N}"),
            )
        })
    }

    pub(super) fn number(&mut self, text: &Text, what: &str) -> Option<f64> {
        self.numbers::<1>(text, what).map(|[value]| value)
    }

    /// A number that is 0 where it is broken, with a note that ends in what that `means`.
    pub(super) fn or_zero(&mut self, text: &Text, what: &str, means: &str) -> f64 {
        if self.unexpanded(text, what) {
            return 0.0;
        }
        match text.value.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => {
                let found = shown(text.value);
                self.note(text.line, format!("{what} is {found}; {means}"));
                0.0
            }
        }
    }
}

fn remedy(text: &str) -> &'static str {
    let starts_as_number = text
        .trim_start()
        .trim_start_matches(['-', '+', '.'])
        .starts_with(|c: char| c.is_ascii_digit());
    if text.contains(',') {
        "; separate numbers by blanks, write decimals with a point"
    } else if starts_as_number {
        "; write plain digits without a unit (URDF counts in m, rad and kg)"
    } else {
        "; give a number"
    }
}
