//! CSV logs, plain or packed with gzip.
//!
//! The line with the names of columns tells the delimiter (`,`, `;` or a tab). Above it:
//!
//! ```text
//! # robot: post               lines of comments, `sep=;` of Excel: passed over
//! # pose,ankle,cop_x          a mark before the first name, where numbers follow: names
//! ```
//!
//! A byte order mark, Windows line ends, blanks around fields and quoted names are all fine.
//! Memory: a MiB of rows and one row more, which must not be endless.
//!
//! ```text
//! lines ─▶ parser ─▶ rows of fields, a MiB of them ─▶ parts, on the processors ─▶ Raw
//! ```
//!
//! To make numbers of digits takes longer than to find where fields end. Numbers and errors are
//! those of reading row by row: the first faulty row is the one that is told.

use std::io::{self, BufRead, BufReader, Cursor, Read};

use csv_core::ReadRecordResult;

use super::columns::{Columns, POSE, are_numbers, with_units};
use super::input::Metered;
use super::names::short;
use super::source::{Raw, RowSource, repeated, whole};
use crate::Error;
use crate::threads::by_parts;

/// A CSV file being read.
pub(super) struct CsvSource {
    input: Box<dyn BufRead + Send>,
    /// The last line of it, and how much of that was parsed.
    text: Vec<u8>,
    at: usize,
    /// Lines and bytes up to its end.
    lines: u64,
    bytes: u64,
    parser: csv_core::Reader,
    header: Vec<String>,
    /// The line of the header.
    names_line: u64,
    /// The first row, which was looked at for units.
    first: Option<Row>,
    /// Rows that are not numbers yet.
    rows: Vec<Row>,
    meter: Metered,
}

/// Fields one behind the other, where each ends, and the line on which they begin.
#[derive(Default)]
struct Row {
    line: u64,
    text: Vec<u8>,
    ends: Vec<usize>,
}

impl Row {
    /// Its fields, where it is text; delimiters are ASCII, so that fields are cut between characters.
    fn fields<'a>(&'a self) -> Option<impl Fn(usize) -> &'a str> {
        let text = str::from_utf8(&self.text).ok()?;
        let start = |k: usize| k.checked_sub(1).map_or(0, |last| self.ends[last]);
        Some(move |k| &text[start(k)..self.ends[k]])
    }
}

impl CsvSource {
    /// Start reading; `head` are the bytes that were taken from `input` already.
    pub(super) fn open(head: Vec<u8>, input: Metered) -> Result<CsvSource, Error> {
        let meter = input.clone();
        let packed = head.starts_with(&[0x1f, 0x8b]);
        let mut input: Box<dyn Read + Send> = Box::new(Cursor::new(head).chain(input));
        if packed {
            input = Box::new(flate2::read::MultiGzDecoder::new(input));
        }
        let mut head = Vec::new();
        let begun = (&mut input).take(64 << 10).read_to_end(&mut head);
        begun.map_err(|error| Error::row(None, unreadable(&error)))?;
        let above = preamble(&head);
        let told = delimiter(&head, above.start).map_err(|message| Error::row(None, message))?;
        let input = Cursor::new(head.split_off(above.start)).chain(input);
        let mut source = CsvSource {
            input: Box::new(BufReader::new(input)),
            text: Vec::new(),
            at: 0,
            lines: above.line - 1,
            bytes: 0,
            parser: csv_core::ReaderBuilder::new()
                .delimiter(above.delimiter.unwrap_or(told))
                .build(),
            header: Vec::new(),
            names_line: above.line,
            first: None,
            rows: Vec::new(),
            meter,
        };
        let names = source.next()?.unwrap_or_default();
        let field = names.fields();
        let field = field.ok_or_else(|| Error::row(Some(above.line), NO_TEXT))?;
        source.header = (0..names.ends.len()).map(|k| name(field(k))).collect();
        if source.header.iter().all(String::is_empty) {
            let message = "no header row; a log starts with the names of its columns";
            return Err(Error::row(Some(above.line), message));
        }
        source.first = source.next()?;
        let first = source.first.as_ref();
        let fields = first.and_then(|row| Some((0..row.ends.len()).map(row.fields()?).collect()));
        // A row of units below the names becomes a part of these.
        if let Some(names) = fields.and_then(|fields| with_units(&source.header, fields)) {
            (source.header, source.first) = (names, None);
        }
        Ok(source)
    }

    /// The next row that is not blank; none at the end. A line without an end has one here, and
    /// no row is endless, since an open quote could swallow the whole file.
    fn next(&mut self) -> Result<Option<Row>, Error> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let (mut row, mut written, mut fields, mut size) = (Row::default(), 0, 0, 0);
        loop {
            if self.at == self.text.len() {
                let read = self.next_line();
                read.map_err(|error| Error::row(Some(self.lines + 1), unreadable(&error)))?;
            }
            // Blank lines are no part of a row.
            if written + fields == 0 {
                (row.line, size) = (self.lines, 0);
            }
            let rest = &self.text[self.at..];
            row.text.resize(written + rest.len(), 0);
            row.ends.resize(fields + self.header.len() + 1, 0);
            let (text, ends) = (&mut row.text[written..], &mut row.ends[fields..]);
            let (result, read, more, count) = self.parser.read_record(rest, text, ends);
            self.at += read;
            size += read;
            (written, fields) = (written + more, fields + count);
            match result {
                ReadRecordResult::End => return Ok(None),
                ReadRecordResult::Record => {
                    row.text.truncate(written);
                    row.ends.truncate(fields);
                    if fields != 1 || !row.text.trim_ascii().is_empty() {
                        return Ok(Some(row));
                    }
                    (written, fields) = (0, 0);
                }
                _ if size > LONGEST_ROW => {
                    let message = format!(
                        "a row of more than {} MiB; is a quote left open, or is this no log?",
                        LONGEST_ROW >> 20
                    );
                    return Err(Error::row(Some(row.line), message));
                }
                _ => {}
            }
        }
    }

    /// Take the next line, or a piece of an endless one.
    fn next_line(&mut self) -> io::Result<()> {
        self.text.clear();
        self.at = 0;
        let mut piece = (&mut self.input).take(LONGEST_ROW as u64);
        let n = piece.read_until(b'\n', &mut self.text)?;
        self.bytes += n as u64;
        self.lines += u64::from(n > 0);
        if self.text.ends_with(b"\r\n") {
            self.text.truncate(n - 2);
            self.text.push(b'\n');
        }
        Ok(())
    }

    /// Take the next rows, `most` at most and some MiB of them; false at the end of the file.
    fn take_rows(&mut self, most: usize) -> Result<bool, Error> {
        self.rows.clear();
        let mut bytes = 0;
        while self.rows.len() < most && bytes < FULL {
            let Some(row) = self.next()? else {
                return Ok(false);
            };
            let (fields, expected) = (row.ends.len(), self.header.len());
            if fields != expected {
                let message = format!(
                    "{fields} fields where the header has {expected}; the row is ragged or cut off"
                );
                return Err(Error::row(Some(row.line), message));
            }
            // Columns may be many, and all of their fields empty.
            bytes += row.text.len() + fields * size_of::<usize>();
            self.rows.push(row);
        }
        Ok(true)
    }

    /// Append the rows that were taken to `raw`.
    ///
    /// # Errors
    /// What is wrong with the first row that is not what the columns want.
    fn parse(&mut self, columns: &Columns, raw: &mut Raw) -> Result<(), Error> {
        let rows = &self.rows;
        let part = rows.len().div_ceil(PARTS).max(1);
        let parts = by_parts(0..rows.len(), part, |part| parse_rows(columns, &rows[part]));
        for part in parts {
            let (poses, numbers) = part?;
            raw.pose.extend(poses);
            let columns = raw.numbers.iter_mut().zip(numbers);
            columns.for_each(|(to, numbers)| to.extend(numbers));
        }
        raw.line.extend(rows.iter().map(|row| row.line));
        if let Some(k) = columns.support {
            for field in rows.iter().filter_map(Row::fields) {
                let link = repeated(raw.support.last(), field(k).trim());
                raw.support.push(link);
            }
        }
        Ok(())
    }
}

impl RowSource for CsvSource {
    fn header(&self) -> &[String] {
        &self.header
    }

    fn names_line(&self) -> Option<u64> {
        Some(self.names_line)
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        let mut left = count;
        while left > 0 {
            let more = self.take_rows(left);
            // What is wrong with a row above comes first.
            self.parse(columns, raw)?;
            if !more? {
                break;
            }
            left -= self.rows.len();
        }
        Ok(())
    }

    // By the length of the rows so far; the row in which these bytes end is passed over, too.
    fn skip(&mut self, _: &Columns, rows: u64) -> Result<(), Error> {
        let length = self.bytes as f64 / self.lines.max(1) as f64;
        let end = self.bytes + (length * rows as f64) as u64;
        let mut more = end > self.bytes;
        while more && self.bytes <= end {
            let passed = self.input.skip_until(b'\n');
            let n = passed.map_err(|error| Error::row(Some(self.lines + 1), unreadable(&error)))?;
            more = n > 0;
            self.bytes += n as u64;
            self.lines += u64::from(more);
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

/// Marks before a line of comments, or before the first name.
const MARKS: [char; 2] = ['#', '%'];
/// A name that begins with one of them.
const TIME_OF_ROSTOPIC: &str = "%time";

/// Where the names of columns begin in a table in text.
#[derive(Debug, PartialEq)]
pub(super) struct Preamble {
    /// Bytes before the first name.
    pub start: usize,
    /// The line of the names, from 1.
    pub line: u64,
    /// The delimiter that a line of Excel says.
    pub delimiter: Option<u8>,
}

/// Find the names of columns in the first bytes of a text.
pub(super) fn preamble(head: &[u8]) -> Preamble {
    let (mut at, mut delimiter, mut marked) = (0, None, None);
    let mut line = 0;
    loop {
        line += 1;
        let (text, next) = first_line(head, at);
        let bare = text.trim_start_matches('\u{feff}').trim();
        let more = next > at && next < head.len() && line <= 1000;
        match bare.strip_prefix("sep=").map(str::as_bytes) {
            Some([own]) if line == 1 && more => delimiter = Some(*own),
            _ if bare.starts_with(MARKS) && !bare.starts_with(TIME_OF_ROSTOPIC) && more => {
                let names = bare.trim_start_matches(MARKS).trim_start();
                let start = text.len() - names.len() - (text.len() - text.trim_end().len());
                marked = Some((at + start, line));
            }
            _ if bare.is_empty() && more => {}
            _ => {
                // Above numbers the names stand in the last of the marked lines.
                let fields = bare.split([',', ';', '\t', ' ']).map(str::trim);
                let marked = marked.filter(|_| are_numbers(fields));
                let (start, line) = marked.unwrap_or((at, line));
                return Preamble {
                    start,
                    line,
                    delimiter,
                };
            }
        }
        at = next;
    }
}

/// The line of a text that begins at `at`, and where the next one does; of what is no text that
/// there is something.
fn first_line(head: &[u8], at: usize) -> (&str, usize) {
    let rest = &head[at..];
    let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
    let end = end.unwrap_or(rest.len());
    let both = rest[end..].starts_with(b"\r\n");
    let next = (end + 1 + usize::from(both)).min(rest.len());
    (str::from_utf8(&rest[..end]).unwrap_or("?"), at + next)
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
    let unquoted = head[start..].split(|byte| *byte == b'"').step_by(2);
    let line = unquoted
        .flatten()
        .take_while(|byte| !matches!(byte, b'\n' | b'\r'));
    let count = |delimiter: &u8| line.clone().filter(|byte| *byte == delimiter).count();
    // The comma among equals.
    Ok(b"\t;,".iter().copied().max_by_key(count).unwrap_or(b','))
}

fn unreadable(error: &io::Error) -> String {
    match error.kind() {
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
const LONGEST_ROW: usize = 4 << 20;
/// Text and ends of fields that are taken at once, bytes: they stay in the second cache.
const FULL: usize = 1 << 20;
/// Parts of them that become numbers side by side.
const PARTS: usize = 4;

const NO_TEXT: &str = "not text; is this a CSV file in UTF-8?";

/// Poses and numbers of rows.
fn parse_rows(columns: &Columns, rows: &[Row]) -> Result<(Vec<i64>, Vec<Vec<f64>>), Error> {
    let mut poses = Vec::new();
    let mut numbers = vec![Vec::with_capacity(rows.len()); columns.numbers.len()];
    for row in rows {
        let mut parse = || -> Result<(), String> {
            let field = row.fields().ok_or(NO_TEXT)?;
            if let Some(k) = columns.pose {
                poses.push(pose(field(k).trim())?);
            }
            for (own, to) in columns.numbers.iter().zip(&mut numbers) {
                to.push(number(field(own.column), &own.name)?);
            }
            Ok(())
        };
        parse().map_err(|message| Error::row(Some(row.line), message))?;
    }
    Ok((poses, numbers))
}

/// A whole number; programs write it as 3.0 or 3e0, too.
fn pose(text: &str) -> Result<i64, String> {
    match text.parse() {
        Ok(number) => Ok(number),
        Err(_) => whole(number(text, POSE)?),
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
    use crate::logs::input::Place;

    #[test]
    fn empty_fields_fill_a_batch() {
        let row = ",".repeat(19_999) + "\n";
        let place = Place::Bytes(format!("a{}", row.repeat(50)).into());
        let input = Metered::open(&place).unwrap();
        let mut source = CsvSource::open(Vec::new(), input).unwrap();
        assert!(source.take_rows(40).unwrap());
        assert!(source.rows.len() < 10, "{}", source.rows.len());
    }

    #[test]
    fn names_of_columns_are_found_below_comments_and_behind_a_mark() {
        for (text, names, line) in [
            ("a,b\n1,2\n", "a,b\n", 1),
            ("# robot: post\n\n# by hand\na,b\n1,2\n", "a,b\n", 4),
            ("# a,b \n1,2\n", "a,b \n", 1),
            ("% note\r\n%\ta b\r\n1 2\r\n", "a b\r\n", 2),
            ("sep=;\r\na;b\r\n1;2\r\n", "a;b\r\n", 2),
            ("%time,a\n1,2\n", "%time,a\n", 1),
            ("# a", "# a", 1),
            ("", "", 1),
        ] {
            let found = preamble(text.as_bytes());
            assert!(text[found.start..].starts_with(names), "{text:?}");
            assert_eq!(found.line, line, "{text:?}");
        }
        assert_eq!(preamble(b"sep=;\na;b\n").delimiter, Some(b';'));
    }
}
