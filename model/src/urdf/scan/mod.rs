//! A first pass over the text, before any XML reader sees it.
//!
//! It bounds nesting and sizes, so that a reader may recurse, and finds broken
//! nesting, where it can say more than a reader (both lines of a mismatch, the
//! element in which a truncated file ends). It also mends what robot tools
//! accept and strict XML does not: comments that hold `--`, an XML declaration
//! after a blank line, prefixes that nobody declared. A prefix becomes a part of
//! the name (`xacro_property`), so that no reader takes another tool's element
//! for the robot's. Every byte of the mended text stands where it stood.

mod tag;

use std::ops::Range;

use super::report::{Lines, shown};
use super::text::{Fault, plain};

/// The text without comments, declarations, instructions and namespaces.
pub(super) fn scan(text: &str) -> Result<String, Fault> {
    let mut scanner = Scanner {
        text,
        open: Vec::new(),
        has_root: false,
        blanks: Vec::new(),
        masks: Vec::new(),
        elements: 0,
    };
    scanner.run()?;
    Ok(scanner.mended())
}

struct Scanner<'a> {
    text: &'a str,
    /// Name and position of the elements around the current place.
    open: Vec<(&'a str, usize)>,
    has_root: bool,
    /// What becomes blanks.
    blanks: Vec<Range<usize>>,
    /// Bytes that become underscores.
    masks: Vec<usize>,
    elements: usize,
}

impl<'a> Scanner<'a> {
    fn run(&mut self) -> Result<(), Fault> {
        let mut at = 0;
        while let Some(start) = self.find(at, "<") {
            self.outside(at, start)?;
            let rest = &self.text[start..];
            at = if rest.starts_with("<!--") {
                self.blank(start, 4, "-->", "this comment")?
            } else if rest.starts_with("<?") {
                self.blank(start, 2, "?>", "this instruction")?
            } else if rest.starts_with("<![CDATA[") {
                self.blank(start, 9, "]]>", "this CDATA section")?
            } else if rest.starts_with("<!") {
                self.doctype(start)?
            } else if rest.starts_with("</") {
                self.close(start)?
            } else {
                self.tag(start)?
            };
        }
        self.outside(at, self.text.len())?;
        if let Some(&(name, start)) = self.open.last() {
            return Err(Fault::new(
                start,
                format!(
                    "<{}> is opened here, but the file ends before </{}>; is it truncated?",
                    plain(name),
                    plain(name)
                ),
            ));
        }
        if !self.has_root {
            return Err(Fault::of_file(if self.text.trim().is_empty() {
                "the file is empty; a URDF holds <robot name=\"...\">"
            } else {
                "no XML element; a URDF holds <robot name=\"...\">"
            }));
        }
        Ok(())
    }

    fn find(&self, from: usize, what: &str) -> Option<usize> {
        self.text[from..].find(what).map(|found| from + found)
    }

    /// Text outside of every element must be blank.
    fn outside(&self, from: usize, to: usize) -> Result<(), Fault> {
        let text = &self.text[from..to];
        let stray = text.trim_start();
        if !self.open.is_empty() || stray.is_empty() {
            return Ok(());
        }
        let at = from + (text.len() - stray.len());
        let stray = stray.lines().next().unwrap_or_default().trim_end();
        Err(Fault::new(
            at,
            if self.has_root {
                format!(
                    "{} after the end of the root element; remove it",
                    shown(stray)
                )
            } else if stray.starts_with("version https://git-lfs") {
                "a Git LFS pointer instead of the file; run `git lfs pull`".to_owned()
            } else {
                format!(
                    "not XML: it starts with {}; a URDF holds <robot name=\"...\">",
                    shown(stray)
                )
            },
        ))
    }

    fn end_of(&self, start: usize, opening: usize, end: &str, what: &str) -> Result<usize, Fault> {
        self.find(start + opening, end)
            .map(|found| found + end.len())
            .ok_or_else(|| {
                Fault::new(
                    start,
                    format!("{what} never ends with `{end}`; is the file truncated?"),
                )
            })
    }

    fn blank(
        &mut self,
        start: usize,
        opening: usize,
        end: &str,
        what: &str,
    ) -> Result<usize, Fault> {
        let end = self.end_of(start, opening, end, what)?;
        self.blanks.push(start..end);
        Ok(end)
    }

    fn doctype(&mut self, start: usize) -> Result<usize, Fault> {
        let end = self.end_of(start, 2, ">", "this declaration")?;
        if !self.text[start..].starts_with("<!DOCTYPE") {
            let found = shown(&self.text[start..end]);
            return Err(Fault::new(
                start,
                format!("{found} is neither a comment nor a DOCTYPE; remove it"),
            ));
        }
        if self.text[start..end].contains('[') {
            return Err(Fault::new(
                start,
                "a DOCTYPE with definitions is not supported; remove it",
            ));
        }
        self.blanks.push(start..end);
        Ok(end)
    }

    fn close(&mut self, start: usize) -> Result<usize, Fault> {
        let end = self.end_of(start, 2, ">", "this closing tag")?;
        self.mask(start + 2..end - 1);
        let name = self.text[start + 2..end - 1].trim_end();
        match self.open.pop() {
            Some((open, _)) if open == name => Ok(end),
            Some((open, opened)) => Err(Fault::new(
                start,
                format!(
                    "</{}> where <{}> of line {} is still open; write </{}> before it",
                    plain(name),
                    plain(open),
                    Lines::of(self.text.as_bytes()).line(opened),
                    plain(open)
                ),
            )),
            None => Err(Fault::new(
                start,
                format!("</{}> closes nothing; remove it", plain(name)),
            )),
        }
    }

    /// The mended text, of as many bytes and with the same lines as before.
    fn mended(self) -> String {
        let mut out = self.text.as_bytes().to_vec();
        for blank in self.blanks {
            for byte in out[blank].iter_mut().filter(|byte| **byte != b'\n') {
                *byte = b' ';
            }
        }
        for at in self.masks {
            out[at] = b'_';
        }
        String::from_utf8_lossy(&out).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::super::limits;
    use super::*;

    fn fault(text: &str) -> String {
        let fault = scan(text).expect_err("must be refused");
        let line = fault.line(text.as_bytes()).unwrap_or(0);
        format!("{line}: {}", fault.message())
    }

    #[test]
    fn mended_text_keeps_its_lines() {
        let text = "\n<?xml version='1.0'?>\n<!DOCTYPE robot>\n<!-- a -- b\nü -->\n<robot x:a='1'>\n<y:z/></robot>";
        let mended = scan(text).unwrap();
        assert_eq!(mended.lines().count(), text.lines().count());
        assert_eq!(mended.len(), text.len());
        let document = roxmltree::Document::parse(&mended).unwrap();
        assert!(document.root_element().has_tag_name("robot"));
    }

    #[test]
    fn prefixes_become_parts_of_names() {
        let text = "<robot xmlns='t' xmlns:a='u'><a:b c:d='e:f'>g:h</a:b ></robot>";
        let mended = "<robot _mlns='t' xmlns_a='u'><a_b c_d='e:f'>g:h</a_b ></robot>";
        assert_eq!(scan(text).unwrap(), mended);
    }

    #[test]
    fn bounds_hold() {
        let deep = "<a>".repeat(100_000);
        assert!(fault(&deep).contains("nested more than 64 deep"));
        let wide = format!("<a {}/>", "b='' ".repeat(1000));
        assert!(fault(&wide).contains("more than 256 attributes"));
        let many = format!("<a>{}</a>", "<b/>".repeat(limits::ELEMENTS));
        assert!(fault(&many).contains("more than 1000000 elements"));
    }

    #[test]
    fn broken_nesting_names_both_ends() {
        assert!(fault("<a>\n<b>\n</a>").starts_with("3: </a> where <b> of line 2"));
        assert!(fault("<a>\n<b>").starts_with("2: <b> is opened here"));
        assert!(fault("<a/>\n</b>").starts_with("2: </b> closes nothing"));
        assert!(fault("<a/>\n<b/>").starts_with("2: <b> is a second root"));
    }
}
