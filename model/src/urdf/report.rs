//! Complaints and notes, gathered while reading and handed out in line order.

use crate::text::is_hidden;
use std::fmt;

/// One fault of a description: where it is, what it is, what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Complaint {
    /// The file as the caller named it.
    pub file: String,
    /// Counted from 1; none when the fault is of the whole file.
    pub line: Option<u32>,
    /// What it is, and what to do.
    pub message: String,
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.file, self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

pub(super) fn one_per_line(complaints: &[Complaint]) -> String {
    let lines: Vec<String> = complaints.iter().map(Complaint::to_string).collect();
    lines.join("\n")
}

/// Finds the line of a byte.
pub(super) struct Lines {
    ends: Vec<usize>,
}

impl Lines {
    pub(super) fn of(text: &[u8]) -> Self {
        let ends = text
            .iter()
            .enumerate()
            .filter_map(|(at, &byte)| (byte == b'\n').then_some(at));
        Lines {
            ends: ends.collect(),
        }
    }

    pub(super) fn line(&self, offset: usize) -> u32 {
        self.ends.partition_point(|&end| end < offset) as u32 + 1
    }
}

/// A value that still holds a xacro expression.
struct Unexpanded {
    line: u32,
    what: String,
    count: usize,
}

pub(super) struct Report {
    file: String,
    complaints: Vec<Complaint>,
    notes: Vec<Complaint>,
    unexpanded: Option<Unexpanded>,
}

impl Report {
    pub(super) fn new(file: &str) -> Self {
        Report {
            file: file.to_owned(),
            complaints: Vec::new(),
            notes: Vec::new(),
            unexpanded: None,
        }
    }

    fn entry(&self, line: u32, message: String) -> Complaint {
        Complaint {
            file: self.file.clone(),
            line: Some(line),
            message,
        }
    }

    pub(super) fn complain(&mut self, line: u32, message: impl Into<String>) {
        self.complaints.push(self.entry(line, message.into()));
    }

    pub(super) fn note(&mut self, line: u32, message: impl Into<String>) {
        self.notes.push(self.entry(line, message.into()));
    }

    /// One cause, one complaint: however many values are unexpanded, the
    /// first is shown and the rest are counted.
    pub(super) fn unexpanded(&mut self, line: u32, what: String) {
        match &mut self.unexpanded {
            Some(first) => first.count += 1,
            None => {
                self.unexpanded = Some(Unexpanded {
                    line,
                    what,
                    count: 1,
                });
            }
        }
    }

    pub(super) fn is_unexpanded(&self) -> bool {
        self.unexpanded.is_some()
    }

    /// The notes, or every complaint.
    pub(super) fn finish(mut self) -> Result<Vec<String>, Vec<Complaint>> {
        if let Some(Unexpanded { line, what, count }) = self.unexpanded.take() {
            let others = match count {
                1 => String::new(),
                2 => " (1 more such value follows)".to_owned(),
                _ => format!(" ({} more such values follow)", count - 1),
            };
            self.complain(
                line,
                format!("{what}: the file is an unexpanded xacro{others}; {EXPAND}"),
            );
        }
        if !self.complaints.is_empty() {
            self.complaints.sort_by_key(|complaint| complaint.line);
            return Err(self.complaints);
        }
        self.notes.sort_by_key(|note| note.line);
        Ok(self.notes.iter().map(Complaint::to_string).collect())
    }
}

/// How to make a URDF of a xacro.
pub(super) const EXPAND: &str = "expand it first: `xacro robot.urdf.xacro > robot.urdf` \
     or `ros2 run xacro xacro robot.urdf.xacro -o robot.urdf`";

/// Text of the file, between backticks: short, on one line, printable.
pub(super) fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let mut out = String::from("`");
    for (count, c) in text.chars().enumerate() {
        if count == LONGEST {
            out.push('…');
            break;
        }
        if is_hidden(c) {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out.push('`');
    out
}

/// `a`, `b` and 3 more.
pub(super) fn listed<T>(items: &[T], show: impl Fn(&T) -> String) -> String {
    const MOST: usize = 8;
    let mut shown: Vec<String> = items.iter().take(MOST).map(show).collect();
    if items.len() > MOST {
        shown.push(format!("{} more", items.len() - MOST));
    }
    match shown.pop() {
        Some(last) if shown.is_empty() => last,
        Some(last) => format!("{} and {last}", shown.join(", ")),
        None => String::new(),
    }
}

/// `a` -> `b` -> `c`, shortened in the middle.
pub(super) fn chained(mut names: Vec<String>) -> String {
    const MOST: usize = 12;
    if names.len() > MOST {
        names.splice(MOST / 2..names.len() - MOST / 2, ["…".to_owned()]);
    }
    names.join(" -> ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_count_from_one() {
        let lines = Lines::of(b"ab\nc\n");
        let found: Vec<u32> = (0..6).map(|at| lines.line(at)).collect();
        assert_eq!(found, [1, 1, 1, 2, 2, 3]);
    }

    #[test]
    fn shown_text_stays_on_one_short_line() {
        assert_eq!(shown("a\nb"), "`a\\nb`");
        assert_eq!(shown(&"x".repeat(100)).chars().count(), 63);
    }

    #[test]
    fn lists_read_as_sentences() {
        let name = |item: &i32| item.to_string();
        assert_eq!(listed(&[1], name), "1");
        assert_eq!(listed(&[1, 2, 3], name), "1, 2 and 3");
        let many: Vec<i32> = (0..10).collect();
        assert_eq!(listed(&many, name), "0, 1, 2, 3, 4, 5, 6, 7 and 2 more");
    }
}
