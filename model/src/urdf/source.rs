//! The elements of a URDF where they stand in its text.
//!
//! What is read is the mended text ([`super::scan`]); it has as many bytes as what
//! was given, but for a byte order mark.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::description::Description;
use super::error::{Error, not_xml};
use super::{limits, scan};

/// A mended text, and where its places are in what was given.
pub(super) struct Source<'a> {
    /// The text as it was given, without a byte order mark.
    pub(super) text: &'a str,
    mended: String,
    /// Bytes of the mark.
    mark: usize,
    file: &'a str,
}

impl<'a> Source<'a> {
    /// Mend `text`, which may start with a byte order mark.
    pub(super) fn new(text: &'a str, file: &'a str) -> Result<Source<'a>, Error> {
        let plain = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mended =
            scan::scan(plain).map_err(|fault| fault.into_complaint(file, plain.as_bytes()))?;
        Ok(Source {
            text: plain,
            mended,
            mark: text.len() - plain.len(),
            file,
        })
    }

    pub(super) fn of(description: &'a Description) -> Result<Source<'a>, Error> {
        Source::new(&description.text, &description.file)
    }

    pub(super) fn document(&self) -> Result<Document<'_>, Error> {
        let options = roxmltree::ParsingOptions {
            nodes_limit: limits::XML_NODES,
            ..Default::default()
        };
        Document::parse_with_options(&self.mended, options)
            .map_err(|error| not_xml(self.file, &error))
    }

    /// A place of the mended text, in what was given.
    pub(super) fn original(&self, place: &Range<usize>) -> Range<usize> {
        place.start + self.mark..place.end + self.mark
    }
}

/// `<link>` elements of the robot, in document order.
pub(super) fn links<'d, 'i>(document: &'d Document<'i>) -> impl Iterator<Item = Node<'d, 'i>> {
    let root = document.root_element();
    children(root, "link")
}

/// The name of a tag; a prefix is a part of it (`xacro_include`).
pub(super) fn tag<'a>(node: Node<'a, '_>) -> &'a str {
    node.tag_name().name()
}

/// Child elements of this name.
pub(super) fn children<'d, 'i, 'n>(
    node: Node<'d, 'i>,
    name: &'n str,
) -> impl Iterator<Item = Node<'d, 'i>> + use<'d, 'i, 'n> {
    node.children()
        .filter(move |child| child.is_element() && tag(*child) == name)
}
