//! One opening tag: its name, its attributes, its end.

use std::ops::Range;

use super::super::limits;
use super::super::text::{Fault, plain};
use super::Scanner;

impl Scanner<'_> {
    /// A tag that opens an element, with its attributes.
    pub(super) fn tag(&mut self, start: usize) -> Result<usize, Fault> {
        let bytes = self.text.as_bytes();
        let mut at = self.word(start + 1);
        let name = &self.text[start + 1..at];
        if name.is_empty() {
            return Err(Fault::new(
                start,
                "`<` without a tag name; write &lt; for a plain `<`",
            ));
        }
        if self.open.is_empty() && std::mem::replace(&mut self.has_root, true) {
            return Err(Fault::new(
                start,
                format!("<{}> is a second root element; keep one", plain(name)),
            ));
        }
        self.elements += 1;
        if self.elements > limits::ELEMENTS || self.open.len() >= limits::DEPTH {
            let bound = if self.elements > limits::ELEMENTS {
                format!("more than {} elements", limits::ELEMENTS)
            } else {
                format!("elements nested more than {} deep", limits::DEPTH)
            };
            return Err(Fault::new(start, format!("{bound}; this is no robot")));
        }
        self.mask(start + 1..at);
        let mut attributes = 0;
        loop {
            match bytes.get(at) {
                None => {
                    return Err(Fault::new(
                        start,
                        format!(
                            "the file ends inside the tag <{}>; is it truncated?",
                            plain(name)
                        ),
                    ));
                }
                Some(b'>') => {
                    self.open.push((name, start));
                    return Ok(at + 1);
                }
                Some(b'/') if bytes.get(at + 1) == Some(&b'>') => return Ok(at + 2),
                Some(b'<') => {
                    return Err(Fault::new(
                        start,
                        format!("the tag <{}> is never closed by `>`; add it", plain(name)),
                    ));
                }
                Some(quote @ (b'"' | b'\'')) => {
                    attributes += 1;
                    if attributes > limits::ATTRIBUTES {
                        return Err(Fault::new(
                            at,
                            format!(
                                "more than {} attributes in <{}>; this is no robot",
                                limits::ATTRIBUTES,
                                plain(name)
                            ),
                        ));
                    }
                    at = self.value_end(at, *quote)?;
                }
                Some(_) => {
                    let end = self.word(at);
                    self.mask(at..end);
                    // White space, `=` and a lone `/` are no words.
                    at = end.max(at + 1);
                }
            }
        }
    }

    /// Where the word that starts here ends.
    fn word(&self, from: usize) -> usize {
        let ends = |&byte: &u8| {
            byte.is_ascii_whitespace() || matches!(byte, b'/' | b'>' | b'<' | b'=' | b'"' | b'\'')
        };
        let rest = &self.text.as_bytes()[from..];
        from + rest.iter().position(ends).unwrap_or(rest.len())
    }

    fn value_end(&self, at: usize, quote: u8) -> Result<usize, Fault> {
        let rest = &self.text.as_bytes()[at + 1..];
        let end = rest.iter().position(|&byte| byte == quote || byte == b'<');
        match end {
            Some(end) if rest[end] == quote => Ok(at + end + 2),
            Some(_) => Err(Fault::new(
                at,
                "`<` inside the quotes that open here; close the quotes, or write &lt;",
            )),
            None => Err(Fault::new(
                at,
                "the quotes that open here never close; is the file truncated?",
            )),
        }
    }

    /// A name of a tag or an attribute: an underscore for what makes it one of a
    /// namespace.
    pub(super) fn mask(&mut self, place: Range<usize>) {
        let name = &self.text[place.clone()];
        if name == "xmlns" {
            self.masks.push(place.start);
        }
        let colons = name.match_indices(':');
        self.masks.extend(colons.map(|(at, _)| place.start + at));
    }
}
