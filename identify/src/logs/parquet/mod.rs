//! Parquet logs, as data frames write them: one column per name, numbers of
//! any width, `support` as text. Timestamps are seconds since 1970, as those of tables.
//!
//! Memory: one page of each wanted column, and what files claim is held against their
//! bytes (`limits`). A file that is written takes two groups of rows.

mod limits;

use std::cmp::Ordering;
use std::fs::File;
use std::io;
use std::mem::take;
use std::sync::Arc;

use parquet::basic::Type as Physical;
use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::ChunkReader;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescPtr, ColumnDescriptor, Type};

use self::limits::ENCRYPTED;
use super::columns::{Columns, Field, POSE, Row, SUPPORT, Written, fields};
use super::input::{Metered, Place};
use super::source::{Raw, RowSource, catch_panic, repeated};
use crate::files::NewFile;
use crate::{Error, Setting, message};

/// A Parquet file being read.
struct ParquetSource<R> {
    place: Place,
    input: Arc<R>,
    footer: ParquetMetaData,
    header: Vec<String>,
    /// Row groups that were opened.
    groups: usize,
    /// The wanted columns of the open group.
    open: Vec<ColumnReader>,
    /// Rows left in it.
    left: u64,
    done: u64,
    total: u64,
    /// Hash of all bytes, once the last row was read; nobody asks for it where rows were passed over.
    hash: Option<u64>,
}

/// Read the columns' names.
pub(super) fn open(place: &Place) -> Result<Box<dyn RowSource>, Error> {
    match place {
        Place::File(path) => ParquetSource::open(File::open(path).map_err(Error::unread)?, place),
        Place::Bytes(bytes) => ParquetSource::open(bytes.clone(), place),
        Place::Table(_) => Err(Error::unread(io::ErrorKind::Unsupported.into())),
    }
}

impl<R: ChunkReader + 'static> ParquetSource<R> {
    fn open(input: R, place: &Place) -> Result<Box<dyn RowSource>, Error> {
        let read = guarded(|| limits::footer(&input));
        let (footer, total) = read.map_err(|error| damaged(None, &error))?;
        let columns = footer.file_metadata().schema_descr().columns().iter();
        let header = columns.map(|column| match column.path().string() {
            // The row labels of a data frame.
            index if index.starts_with("__index_level_") => match unit(column) {
                Some(_) => "timestamp".to_string(),
                None => String::new(),
            },
            name => name.trim().to_string(),
        });
        Ok(Box::new(ParquetSource {
            place: place.clone(),
            input: Arc::new(input),
            header: header.collect(),
            footer,
            groups: 0,
            open: Vec::new(),
            left: 0,
            done: 0,
            total,
            hash: None,
        }))
    }

    /// Open the wanted columns of the next group with rows, where none is left of the open one;
    /// false after the last.
    fn next_group(&mut self, columns: &Columns) -> Result<bool, Error> {
        while self.left == 0 {
            let Some(group) = self.footer.row_groups().get(self.groups) else {
                return Ok(false);
            };
            self.groups += 1;
            // The chunks of an empty group have no pages to look at.
            if group.num_rows() == 0 {
                continue;
            }
            let open = guarded(|| {
                let rows = usize::try_from(group.num_rows())?;
                let open = wanted(columns).map(|(k, _)| {
                    let pages = limits::pages(&self.input, group.column(k), rows)?;
                    Ok(get_column_reader(self.column(k), pages))
                });
                Ok((rows as u64, open.collect::<Result<Vec<_>, ParquetError>>()?))
            });
            (self.left, self.open) = open.map_err(|error| self.broken(&error))?;
        }
        Ok(true)
    }

    fn bad(&self, message: String) -> Error {
        Error::row(Some(self.done + 1), message)
    }

    /// Check once that every wanted column holds what it should.
    fn check_types(&self, columns: &Columns) -> Result<(), Error> {
        for (k, name) in wanted(columns) {
            let column = self.column(k);
            let is_text = is_flat(&column) && column.physical_type() == Physical::BYTE_ARRAY;
            let (is_so, what) = match name {
                SUPPORT => (is_text, "text"),
                POSE => (is_number(&column), "whole numbers"),
                _ => (
                    is_number(&column),
                    "plain numbers; store float64, float32, integers or timestamps",
                ),
            };
            if !is_so {
                return Err(self.bad(format!("column `{name}` holds no {what}")));
            }
        }
        Ok(())
    }

    fn column(&self, k: usize) -> ColumnDescPtr {
        self.footer.file_metadata().schema_descr().column(k)
    }

    /// Read `n` rows that the open group still has.
    fn rows(&mut self, columns: &Columns, n: usize, raw: &mut Raw) -> Result<(), Error> {
        // Rows that the pages have and the group does not count would be lost.
        let asked = n + usize::from(self.left == n as u64);
        let mut open = take(&mut self.open);
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
            match columns.numbers.get(k) {
                Some(own) => {
                    let factor = unit(&self.column(own.column)).unwrap_or(1.0);
                    raw.numbers[k].extend(values.iter().map(|x| x * factor));
                }
                None => raw.poses(self.done + 1, values)?,
            }
        }
        self.open = open;
        raw.line.extend((1..=n as u64).map(|k| self.done + k));
        self.left -= n as u64;
        self.done += n as u64;
        Ok(())
    }

    fn broken(&self, error: &ParquetError) -> Error {
        damaged(Some(self.done + 1), error)
    }

    fn complete(&self, found: usize, expected: usize) -> Result<(), Error> {
        let said = match found.cmp(&expected) {
            Ordering::Equal => return Ok(()),
            Ordering::Less => "the file ends within a column; copy it again",
            Ordering::Greater => "a column has more rows than its group says; the file is damaged",
        };
        Err(self.bad(said.into()))
    }
}

impl<R: ChunkReader + 'static> RowSource for ParquetSource<R> {
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
        if missing > 0 && self.hash.is_none() {
            // Columns lie one behind the other, so that no reader of rows meets the bytes in
            // their order.
            let mut all = Metered::open(&self.place)?;
            io::copy(&mut all, &mut io::sink()).map_err(Error::unread)?;
            self.hash = Some(all.hash());
        }
        Ok(())
    }

    fn skip(&mut self, columns: &Columns, mut rows: u64) -> Result<(), Error> {
        self.hash.get_or_insert(0);
        while rows > 0 && self.next_group(columns)? {
            if rows >= self.left {
                rows -= self.left;
                self.done += self.left;
                self.left = 0;
            } else {
                let n = rows.min(1 << 16);
                self.rows(columns, n as usize, &mut Raw::new(columns))?;
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

/// Places and names of the wanted columns: numbers, then pose, then support.
fn wanted(columns: &Columns) -> impl Iterator<Item = (usize, &str)> {
    let numbers = columns
        .numbers
        .iter()
        .map(|own| (own.column, own.name.as_str()));
    let pose = columns.pose.map(|k| (k, POSE));
    numbers
        .chain(pose)
        .chain(columns.support.map(|k| (k, SUPPORT)))
}

fn damaged(line: Option<u64>, error: &ParquetError) -> Error {
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
    Error::row(line, message)
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
    let is_numeric = matches!(
        column.physical_type(),
        Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE
    );
    is_flat(column) && (unit(column).is_some() || plain && is_numeric)
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

/// A Parquet file being written, a group of rows at a time.
pub(super) struct ParquetSink {
    /// The group's poses and supports, and its numbers column by column.
    poses: Vec<i64>,
    supports: Vec<ByteArray>,
    numbers: Vec<Vec<f64>>,
    writer: SerializedFileWriter<NewFile>,
}

impl ParquetSink {
    /// Start a file with the columns `names`: `pose` whole, `support` text, the
    /// others numbers.
    pub(super) fn new(file: NewFile, names: &[String]) -> io::Result<ParquetSink> {
        let fields = names.iter().map(|name| {
            let (physical, logical) = match name.as_str() {
                POSE => (Physical::INT64, None),
                SUPPORT => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
                _ => (Physical::DOUBLE, None),
            };
            let field = Type::primitive_type_builder(name, physical)
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(logical);
            field.build().map(Arc::new)
        });
        let fields = fields.collect::<Result<_, ParquetError>>()?;
        let schema = Type::group_type_builder("postures").with_fields(fields);
        let schema = Arc::new(schema.build()?);
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .build();
        Ok(ParquetSink {
            poses: Vec::new(),
            supports: Vec::new(),
            numbers: vec![Vec::new(); names.len()],
            writer: SerializedFileWriter::new(file, schema, properties.into())?,
        })
    }

    /// Append a row.
    pub(super) fn row(&mut self, row: &Row, columns: Written) -> io::Result<()> {
        for (field, numbers) in fields(row, columns).zip(&mut self.numbers) {
            match field {
                Field::Whole(pose) => self.poses.push(pose),
                Field::Text(support) => self.supports.push(support.into()),
                Field::Number(x) => numbers.push(x),
            }
        }
        match self.poses.len() {
            65_536 => self.flush(),
            _ => Ok(()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        let mut group = self.writer.next_row_group()?;
        for numbers in &mut self.numbers {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            match column.untyped() {
                ColumnWriter::Int64ColumnWriter(to) => {
                    to.write_batch(&take(&mut self.poses), None, None)?
                }
                ColumnWriter::ByteArrayColumnWriter(to) => {
                    to.write_batch(&take(&mut self.supports), None, None)?
                }
                ColumnWriter::DoubleColumnWriter(to) => {
                    to.write_batch(&take(numbers), None, None)?
                }
                _ => 0,
            };
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Write what is left; the file is yet to be moved to its place.
    pub(super) fn finish(mut self) -> io::Result<NewFile> {
        if !self.poses.is_empty() {
            self.flush()?;
        }
        Ok(self.writer.into_inner()?)
    }
}
