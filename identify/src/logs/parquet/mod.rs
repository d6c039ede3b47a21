//! Parquet logs, as data frames write them: one column per name, numbers of
//! any width, `support` as text. Timestamps are seconds since 1970, as those of tables.
//!
//! Memory: one page of each wanted column.

mod sink;

use std::fs::File;
use std::io;

use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaDataReader;
use parquet::file::reader::{ChunkReader, FileReader};
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::schema::types::{ColumnDescPtr, ColumnDescriptor};

pub(super) use self::sink::ParquetSink;
use super::columns::{Columns, POSE, SUPPORT};
use super::input::{Metered, Place};
use super::source::{Raw, RowSource, catch_panic, repeated, whole};
use crate::{Error, Setting, message};

/// A Parquet file being read.
pub(super) struct ParquetSource {
    file: String,
    place: Place,
    reader: Box<dyn FileReader>,
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
    /// Rows were passed over: nobody asks for the hash.
    passed: bool,
}

/// Whether the footer is signed, as it is where columns are encrypted: it is whole without the 28
/// bytes of the signature behind it.
fn is_signed(input: &impl ChunkReader) -> Option<bool> {
    let end = input.len().checked_sub(8)?;
    let size = input.get_bytes(end, 4).ok()?;
    let size = u32::from_le_bytes(size[..].try_into().ok()?);
    let start = end.checked_sub(u64::from(size))?;
    let footer = input.get_bytes(start, size.checked_sub(28)? as usize);
    Some(ParquetMetaDataReader::decode_metadata(&footer.ok()?).is_ok())
}

/// Read the footer of a file.
///
/// # Errors
/// What the library finds, and claims that a file of this length cannot hold: rows of a constant
/// take next to no bytes, and are made one by one.
fn opened(input: impl ChunkReader + 'static) -> Result<Box<dyn FileReader>, ParquetError> {
    let refused = |said: String| Err(ParquetError::General(said));
    let length = input.len();
    if guarded(|| Ok(is_signed(&input)))?.unwrap_or(false) {
        return refused("encrypted columns".to_string());
    }
    let reader = guarded(|| SerializedFileReader::new(input))?;
    let sum = |claims: &mut dyn Iterator<Item = i64>| {
        claims.fold(0, |sum: u64, n| sum.saturating_add(n.max(0) as u64))
    };
    let groups = reader.metadata().row_groups().iter();
    let rows = sum(&mut groups.clone().map(|group| group.num_rows()));
    let packed = sum(&mut groups
        .flat_map(|group| group.columns())
        .map(|own| own.compressed_size()));
    if rows > 1_000_000_u64.saturating_add(length.saturating_mul(1000)) {
        return refused(format!("it claims {rows} rows in {length} bytes"));
    } else if packed > length {
        return refused(format!("its columns claim {packed} bytes of {length}"));
    }
    Ok(Box::new(reader))
}

impl ParquetSource {
    /// Read the columns' names; `file` names the log in messages.
    pub fn open(place: &Place, file: &str) -> Result<ParquetSource, Error> {
        let unread = |source| Error::read(file.to_string(), source);
        let reader = match place {
            Place::File(path) => opened(File::open(path).map_err(unread)?),
            Place::Bytes(bytes) => opened(Bytes::from_owner(bytes.clone())),
            Place::Stream(_) | Place::Table(_) => {
                return Err(unread(io::ErrorKind::Unsupported.into()));
            }
        };
        let reader = reader.map_err(|error| damaged(file, None, &error))?;
        let about = reader.metadata();
        let columns = about.file_metadata().schema_descr().columns().iter();
        let names = columns.map(|column| match column.path().string() {
            // The row labels of a data frame.
            index if index.starts_with("__index_level_") => match unit(column) {
                Some(_) => "timestamp".to_string(),
                None => String::new(),
            },
            name => name.trim().to_string(),
        });
        let rows = about.row_groups().iter().map(|group| group.num_rows());
        Ok(ParquetSource {
            file: file.to_string(),
            place: place.clone(),
            header: names.collect(),
            total: rows.map(|rows| rows.max(0) as u64).sum(),
            reader,
            groups: 0,
            open: Vec::new(),
            left: 0,
            done: 0,
            hash: None,
            passed: false,
        })
    }

    /// Open the wanted columns of the next group with rows, where none is left of the open one;
    /// false after the last.
    fn next_group(&mut self, columns: &Columns) -> Result<bool, Error> {
        while self.left == 0 {
            if self.groups == self.reader.num_row_groups() {
                return Ok(false);
            }
            let open = guarded(|| {
                let group = self.reader.get_row_group(self.groups)?;
                let wanted = columns.numbers.iter().copied();
                let wanted = wanted.chain(columns.pose).chain(columns.support);
                let rows = u64::try_from(group.metadata().num_rows())?;
                // The chunks of an empty group have no pages to look at.
                let wanted = wanted.filter(|_| rows > 0);
                let open = wanted.map(|k| group.get_column_reader(k));
                Ok((rows, open.collect::<Result<Vec<_>, ParquetError>>()?))
            });
            (self.left, self.open) = open.map_err(|error| self.broken(&error))?;
            self.groups += 1;
        }
        Ok(true)
    }

    fn bad(&self, message: String) -> Error {
        Error::log(self.file.clone(), Some(self.done + 1), message)
    }

    /// Check once that every wanted column holds what it should.
    fn check_types(&self, columns: &Columns) -> Result<(), Error> {
        let numbers = columns.numbers.iter().zip(&columns.names);
        let bad =
            |name: &str, what: &str| Err(self.bad(format!("column `{name}` holds no {what}")));
        for (k, name) in numbers {
            if !is_number(&self.column(*k)) {
                let what = "plain numbers; store float64, float32, integers or timestamps";
                return bad(name, what);
            }
        }
        if columns.pose.is_some_and(|k| !is_number(&self.column(k))) {
            return bad(POSE, "whole numbers");
        }
        let is_text =
            |own: ColumnDescPtr| is_flat(&own) && own.physical_type() == Physical::BYTE_ARRAY;
        match columns.support.is_none_or(|k| is_text(self.column(k))) {
            true => Ok(()),
            false => bad(SUPPORT, "text"),
        }
    }

    fn column(&self, k: usize) -> ColumnDescPtr {
        self.reader
            .metadata()
            .file_metadata()
            .schema_descr()
            .column(k)
    }

    /// Read `n` rows that the open group still has.
    fn rows(&mut self, columns: &Columns, n: usize, raw: &mut Raw) -> Result<(), Error> {
        let (width, start) = (columns.numbers.len(), raw.numbers.len());
        raw.numbers.resize(start + n * width, f64::NAN);
        // Rows that the pages have and the group does not count would be lost.
        let asked = n + usize::from(self.left == n as u64);
        let mut open = std::mem::take(&mut self.open);
        for (k, reader) in open.iter_mut().enumerate() {
            if let ColumnReader::ByteArrayColumnReader(reader) = reader {
                let texts = read(reader, asked, &ByteArray::from(""), ByteArray::clone);
                let texts = texts.map_err(|e| self.broken(&e))?;
                self.complete(texts.len(), n)?;
                for text in &texts {
                    let text = text.as_utf8().map_err(|e| self.broken(&e))?;
                    let link = repeated(raw.support.last(), text.trim());
                    raw.support.push(link);
                }
                continue;
            }
            let values = read_numbers(reader, asked).map_err(|e| self.broken(&e))?;
            self.complete(values.len(), n)?;
            if k < width {
                let factor = unit(&self.column(columns.numbers[k])).unwrap_or(1.0);
                let places = raw.column(start + k, width);
                places.zip(values).for_each(|(to, x)| *to = x * factor);
            } else {
                for (line, value) in (self.done + 1..).zip(values) {
                    let pose = whole(value);
                    let pose = pose.map_err(|said| Error::log(self.file.clone(), Some(line), said));
                    raw.pose.push(pose?);
                }
            }
        }
        self.open = open;
        raw.line.extend((1..=n as u64).map(|k| self.done + k));
        self.left -= n as u64;
        self.done += n as u64;
        Ok(())
    }

    fn broken(&self, error: &ParquetError) -> Error {
        damaged(&self.file, Some(self.done + 1), error)
    }

    fn complete(&self, found: usize, expected: usize) -> Result<(), Error> {
        let said = match found {
            _ if found == expected => return Ok(()),
            _ if found < expected => "the file ends within a column; copy it again",
            _ => "a column has more rows than its group says; the file is damaged",
        };
        Err(self.bad(said.into()))
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
        while missing > 0 && self.next_group(columns)? {
            let n = missing.min(usize::try_from(self.left).unwrap_or(usize::MAX));
            self.rows(columns, n, raw)?;
            missing -= n;
        }
        if missing > 0 && !self.passed && self.hash.is_none() {
            // Columns lie one behind the other, so that no reader of rows meets the bytes in
            // their order.
            let mut all = Metered::open(&self.place, &self.file)?;
            let read = io::copy(&mut all, &mut io::sink());
            read.map_err(|source| Error::read(self.file.clone(), source))?;
            self.hash = Some(all.hash());
        }
        Ok(())
    }

    fn skip(&mut self, columns: &Columns, mut rows: u64) -> Result<(), Error> {
        self.passed = true;
        while rows > 0 && self.next_group(columns)? {
            if rows >= self.left {
                rows -= self.left;
                self.done += self.left;
                self.left = 0;
            } else {
                let n = rows.min(1 << 16);
                self.rows(columns, n as usize, &mut Raw::default())?;
                rows -= n;
            }
        }
        Ok(())
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
    } else if said.contains("encrypted") {
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
    let done = catch_panic(step);
    done.unwrap_or_else(|| Err(ParquetError::General("contradicts itself".into())))
}

/// A plain column, not a list or a field of a structure.
fn is_flat(column: &ColumnDescriptor) -> bool {
    column.max_rep_level() == 0 && column.max_def_level() <= 1
}

/// A plain column whose bits mean the number they spell, or a time.
fn is_number(column: &ColumnDescriptor) -> bool {
    let plain = matches!(
        column.logical_type_ref(),
        // A column that is null throughout has the last of them.
        None | Some(LogicalType::Integer { .. } | LogicalType::Unknown)
    );
    let physical = column.physical_type();
    let number = [
        Physical::INT32,
        Physical::INT64,
        Physical::FLOAT,
        Physical::DOUBLE,
    ];
    is_flat(column) && (unit(column).is_some() || plain && number.contains(&physical))
}

/// The unit of a column of timestamps, s.
fn unit(column: &ColumnDescriptor) -> Option<f64> {
    match (column.physical_type(), column.logical_type_ref()) {
        // Nanoseconds, as Spark and Hive count them.
        (Physical::INT96, _) => Some(1e-9),
        (Physical::INT64, Some(LogicalType::Timestamp(time))) => Some(match time.unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        }),
        (Physical::INT64, None) => match column.converted_type() {
            ConvertedType::TIMESTAMP_MILLIS => Some(1e-3),
            ConvertedType::TIMESTAMP_MICROS => Some(1e-6),
            _ => None,
        },
        _ => None,
    }
}

/// Up to `n` values of a flat column of numbers, fewer at its end; NaN for none.
fn read_numbers(reader: &mut ColumnReader, n: usize) -> Result<Vec<f64>, ParquetError> {
    const NONE: &f64 = &f64::NAN;
    match reader {
        ColumnReader::Int32ColumnReader(reader) => read(reader, n, NONE, |x| f64::from(*x)),
        ColumnReader::Int64ColumnReader(reader) => read(reader, n, NONE, |x| *x as f64),
        ColumnReader::Int96ColumnReader(reader) => read(reader, n, NONE, |x| x.to_nanos() as f64),
        ColumnReader::FloatColumnReader(reader) => read(reader, n, NONE, |x| f64::from(*x)),
        ColumnReader::DoubleColumnReader(reader) => read(reader, n, NONE, |x| *x),
        _ => Ok(Vec::new()),
    }
}

/// Up to `n` values of a flat column, `none` where one is missing.
fn read<T: DataType, V: Clone>(
    reader: &mut ColumnReaderImpl<T>,
    n: usize,
    none: &V,
    value: impl Fn(&T::T) -> V,
) -> Result<Vec<V>, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::with_capacity(n.min(1 << 16)));
    let (records, found, _) =
        guarded(|| reader.read_records(n, Some(&mut levels), None, &mut values))?;
    let mut values = values.iter().map(value);
    if found == records {
        return Ok(values.collect());
    }
    let of = |level: &i16| if *level > 0 { values.next() } else { None };
    let all = levels.iter().take(records).map(of);
    Ok(all.map(|own| own.unwrap_or_else(|| none.clone())).collect())
}
