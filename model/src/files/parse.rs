//! TOML that others wrote: bounded before it is parsed, of a known format, and with messages
//! that stay short whatever stands in the file.

use std::fmt;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

use crate::text::{shortened, visible_lines};

/// Commas, points, equals signs, brackets and lines in one file, at most: what is parsed takes
/// up to 250 bytes for each. The largest file that is written, the model file of a robot of 600
/// joints with the sums of its fit, has 1.5 million.
pub const MARKS: usize = 2_000_000;

/// A line that a message shows whole, characters.
const LINE: usize = 160;
/// What a message says of a fault, characters.
const FAULT: usize = 400;

/// What is wrong with a TOML text.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct TomlFault {
    /// The line with the fault, from 1; none where it is about the whole text.
    pub line: Option<u64>,
    /// The fault in a sentence, which names the line, too.
    pub reason: String,
}

impl From<String> for TomlFault {
    fn from(reason: String) -> TomlFault {
        TomlFault { line: None, reason }
    }
}

impl fmt::Display for TomlFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl std::error::Error for TomlFault {}

/// What a TOML text says. Its key `format` is a whole number, 1 where it is missing; of a file
/// with a format above `newest` nothing else is read.
///
/// # Errors
/// Where the text is no TOML or does not fit `T`, with line and column; where its format is
/// newer than `newest`, or it has more than [`MARKS`].
///
/// ```
/// use std::collections::BTreeMap;
/// use sesc_model::files::parse_toml;
///
/// let zeros: BTreeMap<String, i32> = parse_toml("format = 1\nknee = 2048", 1)?;
/// assert_eq!(zeros["knee"], 2048);
/// let newer = parse_toml::<BTreeMap<String, i32>>("format = 2\nknee = [0, 1]", 1);
/// assert!(newer.unwrap_err().reason.contains("reads formats up to 1"));
/// # Ok::<(), sesc_model::files::TomlFault>(())
/// ```
pub fn parse_toml<T: DeserializeOwned>(text: &str, newest: u32) -> Result<T, TomlFault> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let marks = text.bytes().filter(|byte| b",.=[{\n".contains(byte));
    if marks.count() > MARKS {
        let reason = format!(
            "it has more than {MARKS} values, keys and lines, more than such a file can need"
        );
        return Err(reason.into());
    }
    let mut root = DeTable::parse(text).map_err(|error| sentence(text, error))?;
    if let Some(format) = root.get_mut().remove("format") {
        check_format(format.get_ref(), newest)?;
    }
    T::deserialize(Deserializer::from(root)).map_err(|error| sentence(text, error))
}

fn check_format(format: &DeValue, newest: u32) -> Result<(), String> {
    let number = format.as_integer();
    let number = number.and_then(|n| i64::from_str_radix(n.as_str(), n.radix()).ok());
    match number {
        Some(format) if format > i64::from(newest) => Err(format!(
            "it has format {format}, and this version of sesc reads formats up to {newest}; take \
             the version that wrote it"
        )),
        Some(1..) => Ok(()),
        _ => Err(format!(
            "`format` is no whole number from 1 to {newest}; leave it out, or take a version of \
             sesc that reads the file"
        )),
    }
}

/// What the library says, with the line where that is short enough to be read.
fn sentence(text: &str, mut error: Error) -> TomlFault {
    let fault = shortened(&visible_lines(error.message()), FAULT);
    let Some(span) = error.span() else {
        return fault.into();
    };
    let before = text.get(..span.start).unwrap_or(text);
    let start = before.rfind('\n').map_or(0, |k| k + 1);
    let line = text[start..].lines().next().unwrap_or("");
    let number = before.matches('\n').count() + 1;
    let reason = if line.len() <= LINE && error.message().len() <= FAULT {
        error.set_input(Some(text));
        error.to_string().trim_end().to_string()
    } else {
        let column = before[start..].chars().count() + 1;
        format!("TOML parse error at line {number}, column {column}: {fault}")
    };
    TomlFault {
        line: Some(number as u64),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    type Numbers = BTreeMap<String, Vec<f64>>;

    fn refusal(text: &str) -> String {
        parse_toml::<Numbers>(text, 1).unwrap_err().reason
    }

    #[test]
    fn formats_that_are_newer_or_none_are_refused_whatever_else_is_in_the_file() {
        for (text, word) in [
            ("format = 2\nx = 'of another kind'", "format 2"),
            ("format = 0x10", "format 16"),
            ("format = 0", "no whole number"),
            ("format = -1", "no whole number"),
            ("format = 99999999999999999999", "no whole number"),
            ("format = 'new'", "no whole number"),
            ("format.major = 2", "no whole number"),
        ] {
            assert!(refusal(text).contains(word), "{text}: {}", refusal(text));
        }
        let same = parse_toml::<Numbers>("\u{feff}format = 1\nx = [1.0]", 1);
        assert_eq!(same, parse_toml("x = [1.0]", 1));
    }

    #[test]
    fn a_short_line_is_shown_and_a_long_one_is_counted_in() {
        assert!(refusal("\nx = true").contains("2 | x = true"));
        let line = |text: &str| parse_toml::<Numbers>(text, 1).unwrap_err().line;
        assert_eq!(line("\nx = true"), Some(2));
        assert_eq!(line("y = [1.0]\n\n= 1"), Some(3));
        assert_eq!(line("format = 9"), None);
        let long = refusal(&format!("y = [1.0]\nx = [{}true]", "1.0, ".repeat(100_000)));
        assert!(long.contains("line 2, column 500006"), "{long}");
        assert!(long.len() < 600, "{}", long.len());
        for text in [
            format!("x = [{}", "1,".repeat(100_000)),
            format!("x = '{}'", "é".repeat(100_000)),
            format!("x = 0{}", "\u{1b}".repeat(1000)),
            format!("{} = 1", "k".repeat(100_000)),
        ] {
            let said = refusal(&text);
            assert!(said.len() < 1000, "{}", said.len());
            assert!(!said.contains('\u{1b}'));
        }
    }

    #[test]
    fn more_values_than_any_file_needs_are_not_parsed() {
        for piece in ["1,", "x = 1\n", "[[a]]\n", "a.b.c.d.e.f.g.h = 1\n", "{},"] {
            let text = format!("x = [{}", piece.repeat(MARKS + 1));
            assert!(refusal(&text).contains("more than 2000000 values"));
        }
    }
}
