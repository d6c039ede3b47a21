//! CSV logs, plain or packed with gzip.
//!
//! The line with the names of columns tells the delimiter (`,`, `;` or a
//! tab); what other programs write above and below it is known to [`header`](super::header). A
//! byte order mark, Windows line ends, blanks around fields and quoted names are all fine. Memory: a MiB of rows and one row more, which must not be endless, see
//! [`RowInput`].
//!
//! ```text
//! RowInput ─▶ parser ─▶ rows of fields, a MiB of them ─▶ parts, on the processors ─▶ Raw
//! ```
//!
//! To make numbers of digits takes longer than to find where fields end. Numbers and errors are
//! those of reading row by row: the first faulty row is the one that is told.

use std::io::{self, Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csv::ByteRecord;
use memchr::{memchr, memchr_iter};

use super::columns::{Columns, POSE};
use super::header::{preamble, units, with_unit};
use super::input::{Meter, Metered};
use super::names::short;
use super::source::{Interner, MISSING, Raw, RowSource};
use crate::Error;
use crate::threads::each_long;

/// What is looked at to tell the kind of a file, bytes.
const HEAD: u64 = 64 << 10;

/// A CSV file being read.
pub(super) struct CsvSource {
    file: String,
    reader: csv::Reader<Box<dyn Read + Send>>,
    record: ByteRecord,
    batch: Batch,
    header: Vec<String>,
    /// The line of the header.
    names_line: u64,
    /// The first row, which was looked at for units.
    first: Option<Result<bool, Error>>,
    meter: Arc<Meter>,
    passing: Arc<Passing>,
    links: Interner,
    /// Line of the last row.
    line: u64,
    /// Line below it.
    below: u64,
}

impl CsvSource {
    /// Start reading; `file` names it in messages, `head` are the bytes that
    /// were taken from `input` already.
    pub fn open(file: &str, head: Vec<u8>, input: Metered) -> Result<CsvSource, Error> {
        let meter = input.meter();
        let packed = head.starts_with(&[0x1f, 0x8b]);
        let mut input: Box<dyn Read + Send> = Box::new(Cursor::new(head).chain(input));
        if packed {
            input = Box::new(flate2::read::MultiGzDecoder::new(input));
        }
        let bad = |line, message| Error::log(file.to_string(), line, message);
        let mut head = Vec::new();
        (&mut input)
            .take(HEAD)
            .read_to_end(&mut head)
            .map_err(|error| bad(None, unreadable(&error)))?;
        let above = preamble(&head);
        let told = delimiter(&head, above.start).map_err(|message| bad(None, message))?;
        let head = head.split_off(above.start);
        let passing = Arc::new(Passing::default());
        passing.lines.store(above.line - 1, Ordering::Relaxed);
        let input = RowInput {
            input: Cursor::new(head).chain(input),
            passing: passing.clone(),
            rest: Cursor::default(),
            held: false,
            last: 0,
            ended: false,
        };
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(above.delimiter.unwrap_or(told))
            .flexible(true)
            .from_reader(Box::new(input) as Box<dyn Read + Send>);
        let header: Vec<String> = match reader.headers() {
            Ok(header) => header.iter().map(name).collect(),
            Err(error) => return Err(bad(Some(above.line), fault(&error))),
        };
        if header.iter().all(String::is_empty) {
            return Err(bad(
                Some(above.line),
                "no header row; a log starts with the names of its columns".into(),
            ));
        }
        passing.since_row.store(0, Ordering::Relaxed);
        let mut source = CsvSource {
            file: file.to_string(),
            reader,
            record: ByteRecord::new(),
            batch: Batch::default(),
            header,
            names_line: above.line,
            first: None,
            meter,
            passing,
            links: Interner::default(),
            line: above.line,
            below: 0,
        };
        source.take_units();
        Ok(source)
    }

    /// A row of units below the names becomes a part of these.
    fn take_units(&mut self) {
        let first = self.next();
        let fields = self.record.iter().map(|f| str::from_utf8(f).unwrap_or("?"));
        match units(fields)
            .filter(|own| matches!(first, Ok(true)) && own.len() == self.header.len())
        {
            Some(units) => {
                let names = self.header.iter().zip(&units);
                self.header = names.map(|(name, unit)| with_unit(name, unit)).collect();
            }
            None => self.first = Some(first),
        }
    }

    /// The next row that is not blank.
    fn next(&mut self) -> Result<bool, Error> {
        if let Some(first) = self.first.take() {
            return first;
        }
        loop {
            let more = self.reader.read_byte_record(&mut self.record);
            self.passing.since_row.store(0, Ordering::Relaxed);
            match more {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(error) => {
                    let line = error.position().map(csv::Position::line);
                    let line = line.unwrap_or(self.line + 1);
                    return Err(Error::log(self.file.clone(), Some(line), fault(&error)));
                }
            }
            // A record's own position is before the blank lines above it; the
            // reader is at the line below it, and a quoted field may hold lines.
            let below = self.reader.position().line();
            let within = match std::mem::replace(&mut self.below, below) + 1 == below {
                true => 0,
                false => self
                    .record
                    .as_slice()
                    .iter()
                    .filter(|byte| **byte == b'\n')
                    .count(),
            };
            let above = self.passing.lines.load(Ordering::Relaxed);
            self.line = above + below.saturating_sub(1 + within as u64);
            if self.record.len() != 1 || !self.record[0].trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Rows for a batch, `most` of them at most; false at the end of the file.
    fn batch(&mut self, most: usize) -> Result<bool, Error> {
        self.batch.clear(self.header.len());
        while self.batch.rows() < most && !self.batch.is_full() {
            if !self.next()? {
                return Ok(false);
            }
            let pushed = self.batch.push(&self.record, self.line);
            pushed.map_err(|fault| self.error(fault))?;
        }
        Ok(true)
    }

    fn error(&self, (line, message): Fault) -> Error {
        Error::log(self.file.clone(), Some(line), message)
    }
}

impl RowSource for CsvSource {
    fn is_text(&self) -> bool {
        true
    }

    fn header(&self) -> &[String] {
        &self.header
    }

    fn names_line(&self) -> u64 {
        self.names_line
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        let mut left = count;
        while left > 0 {
            let more = self.batch(left);
            // What is wrong with a row above comes first.
            let parsed = self.batch.parse(columns, &mut self.links, raw);
            parsed.map_err(|fault| self.error(fault))?;
            if !more? {
                break;
            }
            left -= self.batch.rows();
        }
        Ok(())
    }

    // By the length of the rows so far; the row in which these bytes end is passed over, too.
    fn skip(&mut self, _: &Columns, rows: u64) -> Result<(), Error> {
        let at = self.reader.position();
        let length = at.byte() as f64 / at.line().max(1) as f64;
        let bytes = (length * rows as f64) as u64;
        self.passing.bytes.store(bytes, Ordering::Relaxed);
        if bytes > 0 {
            // The hash of a log of which rows are passed over is not used.
            self.meter.forget_hash();
        }
        Ok(())
    }

    fn progress(&self) -> (u64, Option<u64>) {
        self.meter.progress()
    }

    fn hash(&self) -> u64 {
        self.meter.hash()
    }
}

/// A column's name, without the marks and quotes that programs put around it.
fn name(text: &str) -> String {
    let text = text.trim_start_matches('\u{feff}').trim();
    let bare = text.strip_prefix('"').and_then(|t| t.strip_suffix('"'));
    bare.unwrap_or(text).trim().to_string()
}

/// The delimiter of a log that starts with `head`: the one that the line of its names, which
/// begins at `start`, has most of.
pub(crate) fn delimiter(head: &[u8], start: usize) -> Result<u8, String> {
    if head.is_empty() {
        return Err("empty; a log starts with a header row, the names of its columns".into());
    }
    if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
        return Err("UTF-16 text; save it as UTF-8".into());
    }
    if head.contains(&0) {
        return Err("not text; is this a CSV file?".into());
    }
    let mut quoted = false;
    let mut counts = [0usize; 3];
    let known = *b",;\t";
    for byte in &head[start..] {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' | b'\r' if !quoted => break,
            _ if quoted => {}
            _ => {
                if let Some(k) = known.iter().position(|d| d == byte) {
                    counts[k] += 1;
                }
            }
        }
    }
    // The comma among equals.
    let most = (0..3).rev().max_by_key(|k| counts[*k]).unwrap_or(0);
    Ok(known[most])
}

/// A fault that the CSV parser found.
fn fault(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Utf8 { .. } => NO_TEXT.to_string(),
        csv::ErrorKind::Io(error) => unreadable(error),
        _ => error.to_string(),
    }
}

fn unreadable(error: &io::Error) -> String {
    match error.kind() {
        // Our own words.
        io::ErrorKind::Other => error.to_string(),
        io::ErrorKind::UnexpectedEof => {
            "the file is cut off in its gzip packing; copy it again".to_string()
        }
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
            format!("the gzip packing is damaged ({error}); copy the file again")
        }
        _ => format!("cannot be read on: {error}"),
    }
}

/// A row longer than this is no posture, bytes.
const LONGEST_ROW: u64 = 4 << 20;

/// Bytes that are taken at once where rows are passed over.
const PASSED_AT_ONCE: usize = 256 << 10;

/// Rows on their way to the parser, and rows that are passed over.
#[derive(Debug, Default)]
struct Passing {
    /// Bytes handed to the parser since the last row.
    pub since_row: AtomicU64,
    /// Bytes that are to be, and the rest of the row that these end in.
    pub bytes: AtomicU64,
    /// Lines that were.
    pub lines: AtomicU64,
}

/// Input for the parser: rows end in `\n`, the last one too, and none is
/// endless, since an open quote could swallow the whole file.
struct RowInput<R> {
    input: R,
    passing: Arc<Passing>,
    /// Bytes that were taken from the input and not yet given out.
    rest: Cursor<Vec<u8>>,
    /// A `\r` of which it is not yet known whether a `\n` follows.
    held: bool,
    last: u8,
    ended: bool,
}

impl<R: Read> RowInput<R> {
    fn take(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.rest.read(buffer)? {
            0 => self.input.read(buffer),
            n => Ok(n),
        }
    }

    /// Take bytes; no more than the end of a row where rows behind it are to be passed over.
    fn next(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let passed_over = self.passing.bytes.load(Ordering::Relaxed);
        if passed_over == 0 {
            return self.take(buffer);
        }
        if self.last == b'\n' && !self.held {
            self.passing.bytes.store(0, Ordering::Relaxed);
            self.pass(passed_over)?;
            return self.take(buffer);
        }
        let n = self.take(buffer)?;
        let Some(end) = memchr(b'\n', &buffer[..n]) else {
            return Ok(n);
        };
        self.put_back(&buffer[end + 1..n]);
        Ok(end + 1)
    }

    /// Bytes that are given out before the others.
    fn put_back(&mut self, bytes: &[u8]) {
        let mut rest = bytes.to_vec();
        let at = usize::try_from(self.rest.position()).unwrap_or(usize::MAX);
        rest.extend(self.rest.get_ref().get(at..).unwrap_or_default());
        self.rest = Cursor::new(rest);
    }

    /// Pass over so many bytes, and the row that these end in.
    fn pass(&mut self, bytes: u64) -> io::Result<()> {
        let mut left = usize::try_from(bytes).unwrap_or(usize::MAX);
        let mut buffer = vec![0; PASSED_AT_ONCE];
        loop {
            let n = self.take(&mut buffer)?;
            if n == 0 {
                return Ok(());
            }
            let whole = n.min(left);
            left -= whole;
            let end = memchr(b'\n', &buffer[whole..n]);
            let passed = end.map_or(n, |end| whole + end + 1);
            let lines = memchr_iter(b'\n', &buffer[..passed]).count() as u64;
            self.passing.lines.fetch_add(lines, Ordering::Relaxed);
            if end.is_some() {
                self.put_back(&buffer[passed..n]);
                return Ok(());
            }
        }
    }

    /// Drop each `\r` before a `\n` from `bytes`; how many are left.
    fn unify(&mut self, bytes: &mut [u8]) -> usize {
        if memchr(b'\r', bytes).is_none() {
            self.held = false;
            return bytes.len();
        }
        let mut to = 0;
        for from in 0..bytes.len() {
            if bytes[from] == b'\n' && to > 0 && bytes[to - 1] == b'\r' {
                to -= 1;
            }
            bytes[to] = bytes[from];
            to += 1;
        }
        self.held = to > 0 && bytes[to - 1] == b'\r';
        to - usize::from(self.held)
    }
}

impl<R: Read> Read for RowInput<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.passing.since_row.load(Ordering::Relaxed) > LONGEST_ROW {
            return Err(io::Error::other(format!(
                "a row of more than {} MiB; is a quote left open, or is this no log?",
                LONGEST_ROW >> 20
            )));
        }
        // Room for a held byte and a new one; the parser gives thousands.
        if self.ended || buffer.len() < 2 {
            return Ok(0);
        }
        loop {
            let start = usize::from(self.held);
            buffer[0] = b'\r';
            let n = self.next(&mut buffer[start..])?;
            let kept = if n > 0 {
                self.unify(&mut buffer[..start + n])
            } else {
                self.ended = true;
                if self.held || self.last == b'\n' {
                    return Ok(start);
                }
                buffer[0] = b'\n';
                1
            };
            if kept > 0 {
                self.last = buffer[kept - 1];
                let handed = &self.passing.since_row;
                handed.fetch_add(kept as u64, Ordering::Relaxed);
                return Ok(kept);
            }
        }
    }
}

/// Text and ends of fields after which a batch is full, bytes: it stays in the second cache.
const FULL: usize = 1 << 20;
/// Parts of a batch.
const PARTS: usize = 4;
/// With fewer numbers a thread takes longer to start than it helps.
const LEAST: usize = 16_384;

const NO_TEXT: &str = "not text; is this a CSV file in UTF-8?";

/// Rows as fields.
#[derive(Default)]
struct Batch {
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
type Fault = (u64, String);

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
    if let Ok(number) = text.parse() {
        return Ok(number);
    }
    // Programs write whole numbers as 3.0 or 3e0, too.
    match text.parse() {
        _ if is_missing(text) => Ok(MISSING),
        Ok(number) => super::source::whole(number),
        Err(_) => Err(format!(
            "column `{POSE}`: `{}` is no whole number",
            short(text)
        )),
    }
}

/// Whether a field says that it has no value, as programs write it.
fn is_missing(text: &str) -> bool {
    let words = ["", "nan", "na", "n/a", "null", "none", "nil", "-", "--"];
    words.iter().any(|word| text.eq_ignore_ascii_case(word))
}

fn number(text: &str, column: &str) -> Result<f64, String> {
    // Blanks around it are rare.
    if let Ok(number) = text.parse() {
        return Ok(number);
    }
    let text = text.trim();
    if is_missing(text) {
        return Ok(f64::NAN);
    }
    text.parse().map_err(|_| {
        let why = match text.replace(',', ".").parse::<f64>() {
            Ok(_) => format!("`{}` has a decimal comma; write a point", short(text)),
            Err(_) => format!("`{}` is no number", short(text)),
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
