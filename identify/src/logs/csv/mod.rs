//! CSV logs, plain or packed with gzip.
//!
//! The first line names the columns and tells the delimiter (`,`, `;` or a
//! tab). A byte order mark, Windows line ends, blanks around fields and quoted
//! names are all fine. Memory: a MiB of rows and one row more, which must not be endless, see
//! [`RowInput`].

mod batch;
mod rows;

use std::io::{self, Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csv::ByteRecord;

use self::batch::{Batch, Fault, NO_TEXT};
use self::rows::{Passing, RowInput};
use super::columns::Columns;
use super::input::{Meter, Metered};
use super::source::{Interner, Raw, RowSource};
use crate::Error;

/// What is looked at to tell the kind of a file, bytes.
const HEAD: u64 = 64 << 10;

/// A CSV file being read.
pub(super) struct CsvSource {
    file: String,
    reader: csv::Reader<Box<dyn Read + Send>>,
    record: ByteRecord,
    batch: Batch,
    header: Vec<String>,
    meter: Arc<Meter>,
    /// Bytes handed to the parser since the last row.
    since_row: Arc<AtomicU64>,
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
        let delimiter = delimiter(&head).map_err(|message| bad(None, message))?;
        let since_row = Arc::new(AtomicU64::new(0));
        let passing = Arc::new(Passing::default());
        let input: Box<dyn Read + Send> = Box::new(RowInput::new(
            Cursor::new(head).chain(input),
            since_row.clone(),
            passing.clone(),
        ));
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .flexible(true)
            .from_reader(input);
        let header: Vec<String> = match reader.headers() {
            Ok(header) => header.iter().map(name).collect(),
            Err(error) => return Err(bad(Some(1), fault(&error))),
        };
        if header.iter().all(String::is_empty) {
            return Err(bad(
                Some(1),
                "no header row; a log starts with the names of its columns".into(),
            ));
        }
        since_row.store(0, Ordering::Relaxed);
        Ok(CsvSource {
            file: file.to_string(),
            reader,
            record: ByteRecord::new(),
            batch: Batch::default(),
            header,
            meter,
            since_row,
            passing,
            links: Interner::default(),
            line: 1,
            below: 0,
        })
    }

    /// The next row that is not blank.
    fn next(&mut self) -> Result<bool, Error> {
        loop {
            let more = self.reader.read_byte_record(&mut self.record);
            self.since_row.store(0, Ordering::Relaxed);
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
    fn skip(&mut self, _: &Columns, rows: u64) -> Result<bool, Error> {
        let at = self.reader.position();
        let length = at.byte() as f64 / at.line().max(1) as f64;
        let bytes = (length * rows as f64) as u64;
        self.passing.bytes.store(bytes, Ordering::Relaxed);
        if bytes > 0 {
            // The hash of a log of which rows are passed over is not used.
            self.meter.forget_hash();
        }
        Ok(true)
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

/// The delimiter of a log that starts with `head`: the one its first line has most of.
pub(crate) fn delimiter(head: &[u8]) -> Result<u8, String> {
    if head.is_empty() {
        return Err("empty; a log starts with a header row, the names of its columns".into());
    }
    if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
        return Err("UTF-16 text; save it as UTF-8".into());
    }
    if head.starts_with(b"PK\x03\x04") {
        return Err("a packed folder or spreadsheet; export it as CSV".into());
    }
    if head.contains(&0) {
        return Err("not text; is this a CSV file?".into());
    }
    let mut quoted = false;
    let mut counts = [0usize; 3];
    let known = *b",;\t";
    for byte in head {
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
