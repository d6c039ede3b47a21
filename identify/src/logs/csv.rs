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
//! Memory: a MiB of rows and one row more, which must not be endless, see [`RowInput`].
//!
//! ```text
//! RowInput ─▶ parser ─▶ rows of fields, a MiB of them ─▶ parts, on the processors ─▶ Raw
//! ```
//!
//! To make numbers of digits takes longer than to find where fields end. Numbers and errors are
//! those of reading row by row: the first faulty row is the one that is told.

use std::io::{self, BufRead, BufReader, Cursor, Read};

use csv::ByteRecord;
use memchr::memchr_iter;

use super::columns::{Columns, POSE, units, with_unit};
use super::input::Metered;
use super::names::short;
use super::source::{Interner, MISSING, Raw, RowSource};
use crate::Error;
use crate::threads::each_long;

/// A CSV file being read.
pub(super) struct CsvSource {
    file: String,
    reader: csv::Reader<RowInput>,
    record: ByteRecord,
    batch: Batch,
    header: Vec<String>,
    /// The line of the header.
    names_line: u64,
    /// The first row, which was looked at for units.
    first: Option<Result<bool, Error>>,
    meter: Metered,
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
        let meter = input.clone();
        let packed = head.starts_with(&[0x1f, 0x8b]);
        let mut input: Box<dyn Read + Send> = Box::new(Cursor::new(head).chain(input));
        if packed {
            input = Box::new(flate2::read::MultiGzDecoder::new(input));
        }
        let bad = |line, message| Error::log(file.to_string(), line, message);
        let mut head = Vec::new();
        let begun = (&mut input).take(64 << 10).read_to_end(&mut head);
        begun.map_err(|error| bad(None, unreadable(&error)))?;
        let above = preamble(&head);
        let told = delimiter(&head, above.start).map_err(|message| bad(None, message))?;
        let input = Cursor::new(head.split_off(above.start)).chain(input);
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(above.delimiter.unwrap_or(told))
            .flexible(true)
            .from_reader(RowInput {
                input: Box::new(BufReader::new(input)),
                line: Cursor::default(),
                since_row: 0,
                to_pass: 0,
                lines: above.line - 1,
            });
        let header: Vec<String> = match reader.headers() {
            Ok(header) => header.iter().map(name).collect(),
            Err(error) => return Err(bad(Some(above.line), fault(&error))),
        };
        if header.iter().all(String::is_empty) {
            let message = "no header row; a log starts with the names of its columns";
            return Err(bad(Some(above.line), message.into()));
        }
        reader.get_mut().since_row = 0;
        let mut source = CsvSource {
            file: file.to_string(),
            reader,
            record: ByteRecord::new(),
            batch: Batch::default(),
            header,
            names_line: above.line,
            first: None,
            meter,
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
        let units = units(fields).filter(|own| own.len() == self.header.len());
        match units.filter(|_| matches!(first, Ok(true))) {
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
            self.reader.get_mut().since_row = 0;
            match more {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(error) => {
                    let line = error.position().map(csv::Position::line);
                    return Err(self.error((line.unwrap_or(self.line + 1), fault(&error))));
                }
            }
            // A record's own position is before the blank lines above it; the
            // reader is at the line below it, and a quoted field may hold lines.
            let below = self.reader.position().line();
            let within = match std::mem::replace(&mut self.below, below) + 1 == below {
                true => 0,
                false => memchr_iter(b'\n', self.record.as_slice()).count(),
            };
            self.line = self.reader.get_ref().lines + below.saturating_sub(1 + within as u64);
            if self.record.len() != 1 || !self.record[0].trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Rows for a batch, `most` of them at most; false at the end of the file.
    fn batch(&mut self, most: usize) -> Result<bool, Error> {
        self.batch.clear();
        while self.batch.count < most && !self.batch.is_full() {
            if !self.next()? {
                return Ok(false);
            }
            let (fields, expected) = (self.record.len(), self.header.len());
            if fields != expected {
                let message = format!(
                    "{fields} fields where the header has {expected}; the row is ragged or cut off"
                );
                return Err(self.error((self.line, message)));
            }
            self.batch.push(&mut self.record, self.line);
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
            left -= self.batch.count;
        }
        Ok(())
    }

    // By the length of the rows so far; the row in which these bytes end is passed over, too.
    fn skip(&mut self, _: &Columns, rows: u64) -> Result<(), Error> {
        let at = self.reader.position();
        let length = at.byte() as f64 / at.line().max(1) as f64;
        self.reader.get_mut().to_pass = (length * rows as f64) as u64;
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
                let marked = marked.filter(|_| is_row_of_numbers(bare));
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

fn is_row_of_numbers(line: &str) -> bool {
    let fields = line.split([',', ';', '\t', ' ']).map(str::trim);
    let mut fields = fields.filter(|field| !field.is_empty()).peekable();
    fields.peek().is_some() && fields.all(|field| field.parse::<f64>().is_ok())
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
    let known = *b",;\t";
    let mut counts = [0usize; 3];
    let unquoted = head[start..]
        .split(|byte| *byte == b'"')
        .step_by(2)
        .flatten();
    for byte in unquoted.take_while(|byte| !matches!(byte, b'\n' | b'\r')) {
        if let Some(k) = known.iter().position(|delimiter| delimiter == byte) {
            counts[k] += 1;
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

/// Input for the parser: lines end in `\n`, the last one too, and no row is
/// endless, since an open quote could swallow the whole file.
struct RowInput {
    input: Box<dyn BufRead + Send>,
    /// The line that is handed to the parser.
    line: Cursor<Vec<u8>>,
    /// Bytes that were handed to it since the last row.
    since_row: u64,
    /// Bytes to pass over once the line is given out, and the rest of the line that these end in.
    to_pass: u64,
    /// Lines that the parser does not see.
    lines: u64,
}

impl RowInput {
    fn pass(&mut self) -> io::Result<()> {
        let mut left = usize::try_from(std::mem::take(&mut self.to_pass)).unwrap_or(usize::MAX);
        while left > 0 {
            let bytes = self.input.fill_buf()?;
            let n = bytes.len().min(left);
            self.lines += memchr_iter(b'\n', &bytes[..n]).count() as u64;
            self.input.consume(n);
            left -= n;
            if left == 0 || n == 0 {
                self.lines += u64::from(self.input.skip_until(b'\n')? > 0);
                return Ok(());
            }
        }
        Ok(())
    }

    fn next_line(&mut self) -> io::Result<()> {
        self.pass()?;
        self.line.set_position(0);
        let line = self.line.get_mut();
        line.clear();
        let n = (&mut self.input)
            .take(LONGEST_ROW)
            .read_until(b'\n', line)?;
        if line.ends_with(b"\r\n") {
            line.truncate(n - 2);
            line.push(b'\n');
        } else if n > 0 && (n as u64) < LONGEST_ROW && !line.ends_with(b"\n") {
            line.push(b'\n');
        }
        Ok(())
    }
}

impl Read for RowInput {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.since_row > LONGEST_ROW {
            return Err(io::Error::other(format!(
                "a row of more than {} MiB; is a quote left open, or is this no log?",
                LONGEST_ROW >> 20
            )));
        }
        let mut n = self.line.read(buffer)?;
        if n == 0 {
            self.next_line()?;
            n = self.line.read(buffer)?;
        }
        self.since_row += n as u64;
        Ok(n)
    }
}

/// Text and ends of fields after which a batch is full, bytes: it stays in the second cache.
const FULL: usize = 1 << 20;
/// Parts of a batch. With fewer numbers a thread takes longer to start than it helps.
const PARTS: usize = 4;
const LEAST: usize = 16_384;

const NO_TEXT: &str = "not text; is this a CSV file in UTF-8?";

/// Rows as fields.
#[derive(Default)]
struct Batch {
    /// Rows and their lines; those beyond `count` are room for others.
    rows: Vec<(u64, ByteRecord)>,
    count: usize,
    bytes: usize,
}

/// What is wrong with a row, and its line.
type Fault = (u64, String);

impl Batch {
    /// Forget all rows, and keep the room of those that are as long as a posture is.
    fn clear(&mut self) {
        self.rows.retain(|(_, row)| row.as_slice().len() < 16 << 10);
        (self.count, self.bytes) = (0, 0);
    }

    fn is_full(&self) -> bool {
        self.bytes >= FULL
    }

    /// Take a row, which stands at `line`.
    fn push(&mut self, record: &mut ByteRecord, line: u64) {
        // Columns may be many, and all of their fields empty.
        self.bytes += record.as_slice().len() + record.len() * size_of::<usize>();
        if self.count == self.rows.len() {
            self.rows.push(Default::default());
        }
        let (own_line, own) = &mut self.rows[self.count];
        *own_line = line;
        std::mem::swap(own, record);
        self.count += 1;
    }

    /// Append the rows to `raw`.
    ///
    /// # Errors
    /// What is wrong with the first row that is not what the columns want.
    fn parse(&self, columns: &Columns, links: &mut Interner, raw: &mut Raw) -> Result<(), Fault> {
        let rows = &self.rows[..self.count];
        let size = match rows.len() * columns.numbers.len() < LEAST {
            true => rows.len(),
            false => rows.len().div_ceil(PARTS),
        };
        for part in each_long(rows.chunks(size.max(1)), |rows| parse_rows(columns, rows)) {
            let (poses, numbers) = part?;
            raw.pose.extend(poses);
            raw.numbers.extend(numbers);
        }
        raw.line.extend(rows.iter().map(|(line, _)| line));
        if let Some(k) = columns.support {
            let names = rows.iter().map(|(_, row)| str::from_utf8(&row[k]));
            raw.support
                .extend(names.map(|name| links.get(name.unwrap_or_default().trim())));
        }
        Ok(())
    }
}

/// Poses and numbers of rows.
fn parse_rows(
    columns: &Columns,
    rows: &[(u64, ByteRecord)],
) -> Result<(Vec<i64>, Vec<f64>), Fault> {
    let mut poses = Vec::new();
    let mut numbers = Vec::with_capacity(rows.len() * columns.numbers.len());
    for (line, row) in rows {
        let mut parse = || -> Result<(), String> {
            // Checked at once, and cut between characters all the same: delimiters are ASCII.
            let text = str::from_utf8(row.as_slice()).map_err(|_| NO_TEXT)?;
            let field = |k: usize| {
                row.range(k)
                    .and_then(|own| text.get(own))
                    .unwrap_or_default()
            };
            if let Some(k) = columns.pose {
                poses.push(whole(field(k).trim())?);
            }
            for (&k, name) in columns.numbers.iter().zip(&columns.names) {
                numbers.push(number(field(k), name)?);
            }
            Ok(())
        };
        parse().map_err(|message| (*line, message))?;
    }
    Ok((poses, numbers))
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
        batch.clear();
        while !batch.is_full() {
            assert!(batch.count < 10);
            batch.push(&mut empty.clone(), 2);
        }
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
