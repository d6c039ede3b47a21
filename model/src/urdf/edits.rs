//! Edits of a URDF's text: numbers in their places, attributes and elements put in,
//! everything else byte for byte as it was.
//!
//! Numbers are the shortest that read back to the last bit; one that does not
//! change stays as it was written.

use std::ops::Range;

use roxmltree::Node;

use super::source::Source;

/// A change of a coordinate or an angle below this is rounding, m or rad.
pub(super) const SAME: f64 = 1e-16;

/// Pieces of text and what takes their place.
pub(super) struct Edits<'a> {
    source: &'a Source<'a>,
    text: &'a str,
    edits: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    pub(super) fn new(source: &'a Source<'a>, text: &'a str) -> Edits<'a> {
        Edits {
            source,
            text,
            edits: Vec::new(),
        }
    }

    /// Where an element or attribute stands in the text.
    pub(super) fn place(&self, range: &Range<usize>) -> Range<usize> {
        self.source.original(range)
    }

    /// The text at a place.
    pub(super) fn written(&self, place: &Range<usize>) -> &'a str {
        &self.text[place.clone()]
    }

    /// `new` in the place of what stands there.
    pub(super) fn put(&mut self, place: Range<usize>, new: String) {
        self.edits.push((place, new));
    }

    /// An element put in as the first child of one that has children.
    pub(super) fn put_first(&mut self, parent: Node<'_, '_>, element: &str) {
        let place = self.place(&parent.range());
        let at = match parent.first_child() {
            Some(child) => self.place(&child.range()).start,
            None => place.start + self.written(&place).rfind("</").unwrap_or(place.len()),
        };
        let blank: String = self.text[at..]
            .chars()
            .take_while(|c| c.is_whitespace())
            .collect();
        self.put(at..at, blank + element);
    }

    /// Three numbers of an attribute; those that stay, stay as they are written.
    /// An attribute that is missing is zero.
    pub(super) fn set_three(&mut self, node: Node<'_, '_>, name: &str, values: [f64; 3]) {
        let Some(attribute) = node.attribute_node(name) else {
            if values.iter().any(|x| x.abs() > SAME) {
                self.add(node, name, &three(values));
            }
            return;
        };
        let place = self.place(&attribute.range_value());
        let written = self.written(&place);
        let words: Vec<&str> = written.split_whitespace().collect();
        let old: Option<Vec<f64>> = words.iter().map(|word| number(word)).collect();
        let Some(old) = old.filter(|old| old.len() == 3) else {
            self.put(place, three(values));
            return;
        };
        for axis in 0..3 {
            if (values[axis] - old[axis]).abs() > SAME {
                let at = place.start + (words[axis].as_ptr() as usize - written.as_ptr() as usize);
                self.put(at..at + words[axis].len(), format!("{:?}", values[axis]));
            }
        }
    }

    /// One number of an attribute.
    pub(super) fn set(&mut self, node: Node<'_, '_>, name: &str, value: f64) {
        match node.attribute_node(name) {
            Some(attribute) => {
                let place = self.place(&attribute.range_value());
                self.put(place, format!("{value:?}"));
            }
            None => self.add(node, name, &format!("{value:?}")),
        }
    }

    /// An attribute that is not there yet, right after the name of the tag: values of
    /// others may hold any character.
    fn add(&mut self, node: Node<'_, '_>, name: &str, value: &str) {
        let place = self.place(&node.range());
        let written = self.written(&place);
        let tag = written.find(|c: char| c.is_whitespace() || matches!(c, '/' | '>'));
        let at = place.start + tag.unwrap_or(written.len());
        self.put(at..at, format!(" {name}=\"{value}\""));
    }

    /// Blanks before a place, from the end of what stands there.
    pub(super) fn blank_before(&self, at: usize) -> &'a str {
        let before = &self.text[..at];
        &before[before.trim_end().len()..]
    }

    pub(super) fn applied(mut self) -> String {
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

pub(super) fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

pub(super) fn three([x, y, z]: [f64; 3]) -> String {
    format!("{x:?} {y:?} {z:?}")
}
