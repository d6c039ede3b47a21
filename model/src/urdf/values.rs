//! Attributes read as names and numbers, with the complaint when they are not.

use roxmltree::Node;

use super::limits;
use super::report::{Lines, Report, shown};
use crate::text::is_hidden;

/// A value and the line it stands on.
#[derive(Debug, Clone)]
pub(super) struct At<T> {
    pub(super) value: T,
    pub(super) line: u32,
}

/// Reads one part of the tree; `subject` is what messages are about.
pub(super) struct Reader<'a> {
    /// What was given, byte for byte as long as what was scanned.
    pub(super) text: &'a str,
    pub(super) lines: &'a Lines,
    pub(super) report: &'a mut Report,
}

fn source<'a>(node: Node<'a, '_>) -> &'a str {
    &node.document().input_text()[node.range()]
}

/// The name of a tag; a prefix is a part of it (`xacro_include`).
pub(super) fn tag<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

pub(super) fn holds_xacro(text: &str) -> bool {
    text.contains("${") || text.contains("$(")
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

    pub(super) fn complain(&mut self, line: u32, message: String) {
        self.report.complain(line, message);
    }

    pub(super) fn note(&mut self, line: u32, message: String) {
        self.report.note(line, message);
    }

    /// The one child with this tag. A second one that says the same is noted,
    /// one that says something else is a contradiction.
    pub(super) fn only<'d, 'i>(
        &mut self,
        node: Node<'d, 'i>,
        name: &str,
        subject: &str,
    ) -> Option<Node<'d, 'i>> {
        let mut same = node
            .children()
            .filter(|child| child.is_element() && tag(*child) == name);
        let first = same.next()?;
        if let Some(second) = same.next() {
            let (one, two) = (self.line(first), self.line(second));
            let repeats = first.first_element_child().is_none() && source(first) == source(second);
            if repeats {
                self.note(
                    two,
                    format!("{subject}: a second <{name}>, the same as in line {one}"),
                );
            } else {
                self.complain(
                    two,
                    format!("{subject}: a second <{name}> (the first in line {one}); keep one"),
                );
            }
        }
        Some(first)
    }

    pub(super) fn attribute<'d>(&self, node: Node<'d, '_>, name: &str) -> Option<At<&'d str>> {
        node.attribute_node(name).map(|attribute| At {
            value: attribute.value(),
            line: self.lines.line(attribute.range().start),
        })
    }

    /// Whether the text is still to be expanded; the report then says so.
    pub(super) fn unexpanded(&mut self, subject: &str, what: &str, text: &At<&str>) -> bool {
        let holds = holds_xacro(text.value);
        if holds {
            let what = format!("{subject}: {what} is {}", shown(text.value));
            self.report.unexpanded(text.line, what);
        }
        holds
    }

    /// The name of a link or joint, and how messages call it.
    pub(super) fn subject(&mut self, node: Node<'_, '_>, kind: &str) -> (Option<String>, String) {
        let Some(text) = self.attribute(node, "name") else {
            let line = self.line(node);
            self.complain(
                line,
                format!("a {kind} without a name; add <{kind} name=\"...\">"),
            );
            return (None, kind.to_owned());
        };
        let subject = format!("{kind} {}", shown(text.value));
        let name = self.name(&text, &subject, "name");
        (name, subject)
    }

    /// A name or a reference to one. Any character will do but those
    /// that no message and no generated code could show ([`is_hidden`]).
    pub(super) fn name(&mut self, text: &At<&str>, subject: &str, what: &str) -> Option<String> {
        let value = text.value;
        if value.trim().is_empty() {
            self.complain(text.line, format!("{subject}: {what} is empty; fill it in"));
            return None;
        }
        if value.len() > limits::NAME_BYTES {
            self.complain(
                text.line,
                format!(
                    "{subject}: {what} {} is longer than {} bytes; shorten it",
                    shown(value),
                    limits::NAME_BYTES
                ),
            );
            return None;
        }
        if let Some(c) = value.chars().find(|c| is_hidden(*c)) {
            let kind = match c.is_control() {
                true => "a control character",
                false => "a character that turns or breaks text",
            };
            self.complain(
                text.line,
                format!("{subject}: {what} {} holds {kind}; rename it", shown(value)),
            );
            return None;
        }
        self.unexpanded(subject, what, text);
        Some(value.to_owned())
    }

    /// Exactly `N` finite numbers.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        text: &At<&str>,
        subject: &str,
        what: &str,
    ) -> Option<[f64; N]> {
        let values = self.extended_numbers(text, subject, what)?;
        if let Some(worst) = values.iter().find(|value| !value.is_finite()) {
            self.complain(
                text.line,
                format!("{subject}: {what} is {worst}, not finite; give a plain number"),
            );
            return None;
        }
        Some(values)
    }

    /// Exactly `N` numbers; infinities and NaN pass.
    pub(super) fn extended_numbers<const N: usize>(
        &mut self,
        text: &At<&str>,
        subject: &str,
        what: &str,
    ) -> Option<[f64; N]> {
        if self.unexpanded(subject, what, text) {
            return None;
        }
        let mut values = [0.0; N];
        let mut count = 0;
        for word in text.value.split_whitespace() {
            let Ok(value) = word.parse() else {
                self.complain(
                    text.line,
                    format!(
                        "{subject}: {what}: {} is not a number{}",
                        shown(word),
                        remedy(text.value)
                    ),
                );
                return None;
            };
            if let Some(place) = values.get_mut(count) {
                *place = value;
            }
            count += 1;
        }
        if count != N {
            self.complain(
                text.line,
                format!(
                    "{subject}: {what} {} holds {count} numbers; give {N}",
                    shown(text.value)
                ),
            );
            return None;
        }
        Some(values)
    }

    pub(super) fn number(&mut self, text: &At<&str>, subject: &str, what: &str) -> Option<f64> {
        self.numbers::<1>(text, subject, what).map(|[value]| value)
    }

    /// A number that nothing here depends on: 0, with a note, where it is broken.
    pub(super) fn unneeded(&mut self, text: &At<&str>, subject: &str, what: &str) -> f64 {
        self.or_zero(text, subject, what, "not needed, taken as 0")
    }

    /// A number that is 0 where it is broken, with a note that ends in what that `means`.
    pub(super) fn or_zero(
        &mut self,
        text: &At<&str>,
        subject: &str,
        what: &str,
        means: &str,
    ) -> f64 {
        if self.unexpanded(subject, what, text) {
            return 0.0;
        }
        match text.value.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => value,
            _ => {
                let found = shown(text.value);
                self.note(text.line, format!("{subject}: {what} is {found}; {means}"));
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
