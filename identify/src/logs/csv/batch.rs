//! Rows of a CSV file that are cut into fields, and become numbers side by side.
//!
//! ```text
//! parser ─▶ rows of fields, a MiB of them ─▶ parts, on the processors that there are ─▶ Raw
//! ```
//!
//! To make numbers of digits takes longer than to find where fields end. Numbers and errors are
//! those of reading row by row: the first faulty row is the one that is told.

use csv::ByteRecord;

use crate::logs::columns::{Columns, POSE};
use crate::logs::names::short;
use crate::logs::source::{Interner, Raw};
use crate::threads::each_long;

/// Text and ends of fields after which a batch is full, bytes: it stays in the second cache.
const FULL: usize = 1 << 20;
/// Parts of a batch.
const PARTS: usize = 4;
/// With fewer numbers a thread takes longer to start than it helps.
const LEAST: usize = 16_384;

pub(super) const NO_TEXT: &str = "not text; is this a CSV file in UTF-8?";

/// Rows as fields.
#[derive(Default)]
pub(super) struct Batch {
    /// All fields, one behind the other.
    text: Vec<u8>,
    /// Where each field ends.
    ends: Vec<usize>,
    /// Line of each row.
    lines: Vec<u64>,
    /// Fields of a row.
    fields: usize,
}

/// What is wrong with a row, and its line.
pub(super) type Fault = (u64, String);

/// Rows that one thread makes numbers of, and the places of these.
struct Part<'a> {
    first: usize,
    numbers: &'a mut [f64],
    poses: &'a mut [i64],
    rows: usize,
}

impl Batch {
    /// Forget all rows, for rows of `fields`.
    pub fn clear(&mut self, fields: usize) {
        self.text.clear();
        self.ends.clear();
        self.lines.clear();
        self.fields = fields;
    }

    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    pub fn is_full(&self) -> bool {
        // Columns may be many, and all of their fields empty.
        self.text.len() + size_of_val(self.ends.as_slice()) >= FULL
    }

    /// Append a row, which stands at `line`.
    ///
    /// # Errors
    /// A row with another number of fields.
    pub fn push(&mut self, record: &ByteRecord, line: u64) -> Result<(), Fault> {
        let (fields, expected) = (record.len(), self.fields);
        if fields != expected {
            let message = format!(
                "{fields} fields where the header has {expected}; the row is ragged or cut off"
            );
            return Err((line, message));
        }
        let before = self.text.len();
        self.text.extend_from_slice(record.as_slice());
        let ends = (0..fields).map(|k| before + record.range(k).map_or(0, |own| own.end));
        self.ends.extend(ends);
        self.lines.push(line);
        Ok(())
    }

    /// Append the rows to `raw`.
    ///
    /// # Errors
    /// What is wrong with the first row that is not what the columns want.
    pub fn parse(
        &self,
        columns: &Columns,
        links: &mut Interner,
        raw: &mut Raw,
    ) -> Result<(), Fault> {
        let (rows, width) = (self.rows(), columns.numbers.len());
        let of_poses = usize::from(columns.pose.is_some());
        let (numbers, poses) = (raw.numbers.len(), raw.pose.len());
        raw.numbers.resize(numbers + rows * width, 0.0);
        raw.pose.resize(poses + rows * of_poses, 0);
        let (mut numbers, mut poses) = (&mut raw.numbers[numbers..], &mut raw.pose[poses..]);
        let size = match rows * width < LEAST {
            true => rows,
            false => rows.div_ceil(PARTS),
        };
        let mut parts = Vec::with_capacity(PARTS);
        for first in (0..rows).step_by(size.max(1)) {
            let rows = size.min(rows - first);
            let (own, others) = numbers.split_at_mut(rows * width);
            let (own_poses, other_poses) = poses.split_at_mut(rows * of_poses);
            (numbers, poses) = (others, other_poses);
            parts.push(Part {
                first,
                numbers: own,
                poses: own_poses,
                rows,
            });
        }
        let parsed = each_long(parts, |part| self.parse_part(columns, part));
        parsed.into_iter().collect::<Result<(), Fault>>()?;
        if let Some(k) = columns.support {
            let names = (0..rows).map(|row| str::from_utf8(self.field(row, k)).unwrap_or_default());
            raw.support.extend(names.map(|name| links.get(name.trim())));
        }
        raw.line.extend(&self.lines);
        Ok(())
    }

    fn parse_part(&self, columns: &Columns, part: Part) -> Result<(), Fault> {
        let width = columns.numbers.len();
        let Part {
            first,
            numbers,
            poses,
            rows,
        } = part;
        for k in 0..rows {
            let row = first + k;
            let poses = poses.get_mut(k);
            let parsed = self.parse_row(columns, row, poses, &mut numbers[k * width..][..width]);
            parsed.map_err(|message| (self.lines[row], message))?;
        }
        Ok(())
    }

    fn parse_row(
        &self,
        columns: &Columns,
        row: usize,
        pose: Option<&mut i64>,
        numbers: &mut [f64],
    ) -> Result<(), String> {
        // Checked at once, and cut between characters all the same: delimiters are ASCII.
        let (start, end) = (self.start(row, 0), self.start(row + 1, 0));
        let text = str::from_utf8(&self.text[start..end]).map_err(|_| NO_TEXT)?;
        let field = |k: usize| {
            let own = self.start(row, k) - start..self.start(row, k + 1) - start;
            text.get(own).unwrap_or_default()
        };
        if let (Some(k), Some(pose)) = (columns.pose, pose) {
            *pose = whole(field(k).trim())?;
        }
        let named = columns.numbers.iter().zip(&columns.names);
        for (place, (&k, name)) in numbers.iter_mut().zip(named) {
            *place = number(field(k), name)?;
        }
        Ok(())
    }

    fn field(&self, row: usize, k: usize) -> &[u8] {
        &self.text[self.start(row, k)..self.start(row, k + 1)]
    }

    /// Where field `k` of a row begins, and where the one before it ends.
    fn start(&self, row: usize, k: usize) -> usize {
        match row * self.fields + k {
            0 => 0,
            fields => self.ends[fields - 1],
        }
    }
}

fn whole(text: &str) -> Result<i64, String> {
    // Tables that once had gaps write whole numbers as 3.0.
    let digits = text
        .split_once('.')
        .filter(|(_, rest)| !rest.is_empty() && rest.bytes().all(|b| b == b'0'))
        .map_or(text, |(digits, _)| digits);
    digits
        .parse()
        .map_err(|_| format!("column `{POSE}`: `{}` is no whole number", short(text)))
}

fn number(text: &str, column: &str) -> Result<f64, String> {
    // Blanks around it are rare.
    if let Ok(number) = text.parse() {
        return Ok(number);
    }
    let text = text.trim();
    text.parse().map_err(|_| {
        let why = match text {
            "" => "the field is empty; remove the row or fill in the value".to_string(),
            _ if text.replace(',', ".").parse::<f64>().is_ok() => {
                format!("`{}` has a decimal comma; write a point", short(text))
            }
            _ => format!("`{}` is no number", short(text)),
        };
        format!("column `{column}`: {why}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_fields_fill_a_batch() {
        let empty = ByteRecord::from(vec![""; 20_000]);
        let mut batch = Batch::default();
        batch.clear(empty.len());
        while !batch.is_full() {
            assert!(batch.rows() < 10);
            batch.push(&empty, 2).unwrap();
        }
    }
}
