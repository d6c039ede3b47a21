//! Parquet logs, as data frames write them: one column per name, numbers of
//! any width, `support` as text. Timestamps are seconds since 1970, as those of tables.
//!
//! Memory: one page of each wanted column, and what files claim is held against their
//! bytes (`limits`).

mod hashing;
mod limits;
mod sink;
mod values;

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;

use parquet::basic::Type as Physical;
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::schema::types::ColumnDescPtr;

use self::hashing::Hashing;
use self::limits::{ENCRYPTED, Input};
pub(super) use self::sink::ParquetSink;
use self::values::{is_flat, is_number, read, read_numbers, spread, unit};
use super::columns::{Columns, POSE, SUPPORT};
use super::guard::Guard;
use super::input::{Bytes, Place};
use super::source::{Interner, Raw, RowSource, whole};
use crate::{Error, Setting, message};

/// Who reads on beyond so many rows reads all of them: what begins a fit is known from fewer.
const MANY: u64 = 30_000;

/// A Parquet file being read.
pub(super) struct ParquetSource {
    file: String,
    place: Place,
    input: Input,
    footer: ParquetMetaData,
    header: Vec<String>,
    /// Row groups that were opened.
    groups: usize,
    /// The wanted columns of the open group: numbers, then pose, then support.
    open: Vec<ColumnReader>,
    /// Rows left in it.
    left: u64,
    done: u64,
    total: u64,
    /// Hash of all bytes, once the last row was read and none was passed over.
    hash: Option<u64>,
    /// The hash, while it is under way.
    hashing: Option<Hashing>,
    /// Rows were passed over: nobody asks for the hash.
    passed: bool,
    links: Interner,
}

impl ParquetSource {
    /// Read the columns' names; `file` names the log in messages.
    pub fn open(place: &Place, file: &str) -> Result<ParquetSource, Error> {
        let input = Bytes::open(place).map_err(|source| Error::read(file.to_string(), source))?;
        let input = match input {
            Bytes::File(file) => Input::File(Arc::new(file)),
            Bytes::Memory(bytes) => Input::Memory(bytes::Bytes::from_owner(bytes.into_inner())),
            Bytes::Stream(_) => return Err(Error::log(file.to_string(), None, "a stream")),
        };
        let footer = guarded(|| input.footer()).map_err(|error| damaged(file, None, &error))?;
        let about = footer.file_metadata();
        let header: Vec<String> = about
            .schema_descr()
            .columns()
            .iter()
            .map(|column| match column.path().string() {
                // The row labels of a data frame.
                index if index.starts_with("__index_level_") => match unit(column) {
                    Some(_) => "timestamp".to_string(),
                    None => String::new(),
                },
                name => name.trim().to_string(),
            })
            .collect();
        let rows = footer.row_groups().iter();
        let total = rows
            .map(|group| u64::try_from(group.num_rows()).unwrap_or(0))
            .fold(0u64, u64::saturating_add);
        Ok(ParquetSource {
            file: file.to_string(),
            place: place.clone(),
            input,
            footer,
            header,
            groups: 0,
            open: Vec::new(),
            left: 0,
            done: 0,
            total,
            hash: None,
            hashing: None,
            passed: false,
            links: Interner::default(),
        })
    }

    /// Open the wanted columns of the next group; false after the last.
    fn next_group(&mut self, columns: &Columns) -> Result<bool, Error> {
        let at = Some(self.done + 1);
        let Some(group) = self.footer.row_groups().get(self.groups) else {
            return Ok(false);
        };
        if group.num_rows() == 0 {
            // Its chunks have no pages to look at.
            self.groups += 1;
            return Ok(true);
        }
        let open = guarded(|| {
            let rows = usize::try_from(group.num_rows())?;
            let wanted = columns.numbers.iter().copied();
            let wanted = wanted.chain(columns.pose).chain(columns.support);
            let open = wanted.map(|k| {
                let pages = self.input.pages(group.column(k), rows)?;
                Ok(get_column_reader(self.column(k), pages))
            });
            Ok((rows as u64, open.collect::<Result<Vec<_>, ParquetError>>()?))
        });
        let (rows, open) = open.map_err(|error| damaged(&self.file, at, &error))?;
        self.open = open;
        self.left = rows;
        self.groups += 1;
        Ok(true)
    }

    fn bad(&self, message: String) -> Error {
        Error::log(self.file.clone(), Some(self.done + 1), message)
    }

    /// Check once that every wanted column holds what it should.
    fn check_types(&self, columns: &Columns) -> Result<(), Error> {
        let named = columns.numbers.iter().copied().zip(&columns.names);
        for (k, name) in named {
            if !is_number(&self.column(k)) {
                return Err(self.bad(format!(
                    "column `{name}` holds no plain numbers; store float64, float32, integers or timestamps"
                )));
            }
        }
        if columns.pose.is_some_and(|k| !is_number(&self.column(k))) {
            return Err(self.bad(format!("column `{POSE}` holds no whole numbers")));
        }
        if columns.support.is_some_and(|k| {
            let column = self.column(k);
            !is_flat(&column) || column.physical_type() != Physical::BYTE_ARRAY
        }) {
            return Err(self.bad(format!("column `{SUPPORT}` holds no text")));
        }
        Ok(())
    }

    fn column(&self, k: usize) -> ColumnDescPtr {
        self.footer.file_metadata().schema_descr().column(k)
    }

    /// Read `n` rows that the open group still has.
    fn rows(&mut self, columns: &Columns, n: usize, raw: &mut Raw) -> Result<(), Error> {
        let width = columns.numbers.len();
        let start = raw.numbers.len();
        raw.numbers.resize(start + n * width, f64::NAN);
        let mut open = std::mem::take(&mut self.open);
        for (k, reader) in open.iter_mut().enumerate() {
            if k < width {
                let place = raw.numbers[start..].iter_mut().skip(k).step_by(width);
                let values = self.numbers(reader, n)?;
                let factor = unit(&self.column(columns.numbers[k])).unwrap_or(1.0);
                place
                    .zip(values)
                    .for_each(|(to, value)| *to = value * factor);
            } else if k == width && columns.pose.is_some() {
                let values = self.numbers(reader, n)?;
                for (at, value) in values.iter().enumerate() {
                    raw.pose.push(whole(*value).map_err(|message| {
                        Error::log(self.file.clone(), Some(self.done + 1 + at as u64), message)
                    })?);
                }
            } else if let ColumnReader::ByteArrayColumnReader(reader) = reader {
                let (values, levels) = read(reader, n).map_err(|e| self.broken(&e))?;
                let all = levels.unwrap_or_else(|| vec![1; values.len()]);
                self.complete(all.len(), n)?;
                for value in spread(values.iter(), &all) {
                    let text = value.map_or(Ok(""), ByteArray::as_utf8);
                    let text = text.map_err(|e| self.broken(&e))?.trim();
                    raw.support.push(self.links.get(text));
                }
            }
        }
        if self.left == n as u64 {
            // Rows that the pages have and the group does not count would be lost.
            for reader in &mut open {
                let more = match reader {
                    ColumnReader::ByteArrayColumnReader(reader) => read(reader, 1)
                        .map(|(values, levels)| levels.map_or(values.len(), |l| l.len())),
                    numbers => read_numbers(numbers, 1).map(|v| v.len()),
                };
                if more.map_err(|e| self.broken(&e))? > 0 {
                    let message = "a column has more rows than its group says; the file is damaged";
                    return Err(self.bad(message.into()));
                }
            }
        }
        self.open = open;
        raw.line.extend((1..=n as u64).map(|k| self.done + k));
        self.left -= n as u64;
        self.done += n as u64;
        Ok(())
    }

    /// Pass over `n` rows of the open group, of which it has more.
    fn pass(&mut self, n: u64) -> Result<(), Error> {
        let mut open = std::mem::take(&mut self.open);
        let count = usize::try_from(n).unwrap_or(usize::MAX);
        for reader in &mut open {
            let passed = guarded(|| match reader {
                ColumnReader::Int32ColumnReader(reader) => reader.skip_records(count),
                ColumnReader::Int64ColumnReader(reader) => reader.skip_records(count),
                ColumnReader::Int96ColumnReader(reader) => reader.skip_records(count),
                ColumnReader::FloatColumnReader(reader) => reader.skip_records(count),
                ColumnReader::DoubleColumnReader(reader) => reader.skip_records(count),
                ColumnReader::ByteArrayColumnReader(reader) => reader.skip_records(count),
                // Of no column that a log has.
                ColumnReader::BoolColumnReader(_)
                | ColumnReader::FixedLenByteArrayColumnReader(_) => Ok(count),
            });
            self.complete(passed.map_err(|e| self.broken(&e))?, count)?;
        }
        self.open = open;
        self.left -= n;
        self.done += n;
        Ok(())
    }

    /// `n` values of a column of numbers.
    fn numbers(&self, reader: &mut ColumnReader, n: usize) -> Result<Vec<f64>, Error> {
        let values = read_numbers(reader, n).map_err(|e| self.broken(&e))?;
        self.complete(values.len(), n)?;
        Ok(values)
    }

    fn broken(&self, error: &ParquetError) -> Error {
        damaged(&self.file, Some(self.done + 1), error)
    }

    fn complete(&self, found: usize, expected: usize) -> Result<(), Error> {
        if found == expected {
            return Ok(());
        }
        Err(self.bad("the file ends within a column; copy it again".into()))
    }
}

impl RowSource for ParquetSource {
    fn header(&self) -> &[String] {
        &self.header
    }

    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error> {
        if self.groups == 0 {
            self.check_types(columns)?;
        }
        let mut missing = count;
        while missing > 0 {
            if self.left == 0 {
                if self.next_group(columns)? {
                    continue;
                }
                break;
            }
            let n = missing.min(usize::try_from(self.left).unwrap_or(usize::MAX));
            self.rows(columns, n, raw)?;
            missing -= n;
        }
        if self.passed || self.hash.is_some() {
            return Ok(());
        }
        if missing == 0 && self.done > MANY && self.hashing.is_none() {
            self.hashing = Hashing::begin(&self.place);
        }
        if missing > 0 {
            let hash = match self.hashing.take() {
                Some(hashing) => hashing.end(),
                None => hashing::of(&self.place),
            };
            self.hash = Some(hash.map_err(|source| Error::read(self.file.clone(), source))?);
        }
        Ok(())
    }

    fn skip(&mut self, columns: &Columns, rows: u64) -> Result<(), Error> {
        self.passed = true;
        let mut rows = rows;
        while rows >= self.left {
            rows -= self.left;
            self.done += self.left;
            self.left = 0;
            if !self.next_group(columns)? {
                return Ok(());
            }
        }
        self.pass(rows)
    }

    fn progress(&self) -> (u64, Option<u64>) {
        (self.done, Some(self.total))
    }

    fn hash(&self) -> u64 {
        self.hash.unwrap_or_default()
    }
}

fn damaged(file: &str, line: Option<u64>, error: &ParquetError) -> Error {
    let said = error.to_string();
    let message = if said.contains("compile time: zstd") {
        message![
            "packed with zstd, which this build leaves out; ",
            Setting::Feature("zstd"),
            " adds it, or write the log with snappy"
        ]
    } else if said.contains("compile time") {
        format!("packed in a way that cannot be read ({said}); write it with snappy").into()
    } else if said.contains(ENCRYPTED) {
        "the Parquet file is encrypted; decrypt it first".into()
    } else {
        let said = said.trim_start_matches("External: ");
        let said = said.trim_start_matches("Parquet error: ");
        format!("the Parquet file is cut off or damaged ({said}); copy it again").into()
    };
    Error::log(file.to_string(), line, message)
}

/// Run a step of the Parquet library, which meets some damages with a panic: the file's
/// fault, so an error here.
fn guarded<T>(step: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    let _guard = Guard::new();
    let done = panic::catch_unwind(AssertUnwindSafe(step));
    done.unwrap_or_else(|_| Err(ParquetError::General("contradicts itself".into())))
}
