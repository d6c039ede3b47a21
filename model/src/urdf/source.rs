//! The elements of a URDF where they stand in its text.
//!
//! What is read is the mended text ([`super::scan`]); it has as many bytes as the
//! original but for declarations put into the tag of the root, so that a place
//! inside the root is the same place of the original, shifted.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::values::tag;
use super::{Error, limits, not_xml, scan};

/// A mended text, and how far its places are from those of the original.
pub(super) struct Source {
    mended: String,
    shift: usize,
}

impl Source {
    /// Mend `text`, which may start with a byte order mark.
    pub(super) fn of(text: &str, file: &str) -> Result<Source, Error> {
        let plain = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mended = scan::scan(plain).map_err(|fault| fault.into_error(file, plain.as_bytes()))?;
        // A mark moves places one way, declarations the other: unsigned sums wrap back.
        let mark = text.len() - plain.len();
        let shift = plain.len().wrapping_sub(mended.len()).wrapping_add(mark);
        Ok(Source { mended, shift })
    }

    pub(super) fn document(&self, file: &str) -> Result<Document<'_>, Error> {
        let options = roxmltree::ParsingOptions {
            nodes_limit: limits::XML_NODES,
            ..Default::default()
        };
        Document::parse_with_options(&self.mended, options).map_err(|error| not_xml(file, &error))
    }

    /// A place inside the root, in the original text.
    pub(super) fn original(&self, place: &Range<usize>) -> Range<usize> {
        place.start.wrapping_add(self.shift)..place.end.wrapping_add(self.shift)
    }
}

/// `<link>` elements of the robot, in document order.
pub(super) fn links<'d, 'i>(document: &'d Document<'i>) -> impl Iterator<Item = Node<'d, 'i>> {
    let root = document.root_element();
    children(root, "link")
}

/// Child elements of this name.
pub(super) fn children<'d, 'i, 'n>(
    node: Node<'d, 'i>,
    name: &'n str,
) -> impl Iterator<Item = Node<'d, 'i>> + use<'d, 'i, 'n> {
    node.children()
        .filter(move |child| child.is_element() && tag(*child) == name)
}
