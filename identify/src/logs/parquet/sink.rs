//! Writing Parquet logs. Memory: two groups of rows.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::Error;
use crate::files::{self, NewFile};
use crate::logs::columns::{POSE, Row, SUPPORT, Written, numbers};

/// Rows of a group.
const GROUP: usize = 65_536;

/// A Parquet file being written, a group of rows at a time.
pub(in crate::logs) struct ParquetSink {
    path: PathBuf,
    group: Group,
    writer: SerializedFileWriter<NewFile>,
}

/// Rows that are written together.
#[derive(Default)]
struct Group {
    pose: Vec<i64>,
    support: Vec<ByteArray>,
    /// Column by column.
    numbers: Vec<Vec<f64>>,
    t: Vec<f64>,
}

impl ParquetSink {
    /// Start a file with the columns `names`: `pose` whole, `support` text, the
    /// others numbers.
    pub fn create(path: &Path, names: &[String]) -> Result<ParquetSink, Error> {
        let failed = |error| unwritten(path, error);
        let kind = |name: &str| match name {
            POSE => Physical::INT64,
            SUPPORT => Physical::BYTE_ARRAY,
            _ => Physical::DOUBLE,
        };
        let field = |name: &String| {
            let text = (name == SUPPORT).then_some(LogicalType::String);
            Type::primitive_type_builder(name, kind(name))
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(text)
                .build()
                .map(Arc::new)
        };
        let fields: Result<Vec<_>, _> = names.iter().map(field).collect();
        let schema = Type::group_type_builder("postures")
            .with_fields(fields.map_err(failed)?)
            .build()
            .map_err(failed)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_dictionary_enabled(false)
            .build();
        let writer =
            SerializedFileWriter::new(NewFile::create(path)?, Arc::new(schema), properties.into())
                .map_err(failed)?;
        Ok(ParquetSink {
            path: path.to_path_buf(),
            group: Group::default(),
            writer,
        })
    }

    /// Append a row.
    pub fn row(&mut self, row: &Row, columns: Written) -> Result<(), Error> {
        let group = &mut self.group;
        group.pose.push(row.pose);
        if columns.t {
            group.t.push(row.t);
        }
        if columns.support {
            group.support.push(row.support.into());
        }
        for (k, x) in numbers(row, columns).enumerate() {
            if k == group.numbers.len() {
                group.numbers.push(Vec::new());
            }
            group.numbers[k].push(x);
        }
        if group.pose.len() == GROUP {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Error> {
        let written = std::mem::take(&mut self.group).write(&mut self.writer);
        written.map_err(|error| unwritten(&self.path, error))
    }

    /// Write what is left; the file is yet to be moved to its place.
    pub fn finish(mut self) -> Result<NewFile, Error> {
        if !self.group.pose.is_empty() {
            self.flush()?;
        }
        let file = self.writer.into_inner();
        file.map_err(|error| unwritten(&self.path, error))
    }
}

impl Group {
    fn write(&self, writer: &mut SerializedFileWriter<NewFile>) -> Result<(), ParquetError> {
        let mut group = writer.next_row_group()?;
        // In the order of the header: pose, t, support, numbers.
        let t = (!self.t.is_empty()).then_some(&self.t);
        let mut numbers = t.into_iter().chain(&self.numbers);
        while let Some(mut column) = group.next_column()? {
            match column.untyped() {
                ColumnWriter::Int64ColumnWriter(to) => {
                    to.write_batch(&self.pose, None, None)?;
                }
                ColumnWriter::DoubleColumnWriter(to) => {
                    let values = numbers.next().map_or(&[][..], Vec::as_slice);
                    to.write_batch(values, None, None)?;
                }
                ColumnWriter::ByteArrayColumnWriter(to) => {
                    to.write_batch(&self.support, None, None)?;
                }
                _ => {}
            }
            column.close()?;
        }
        group.close()?;
        Ok(())
    }
}

fn unwritten(path: &Path, error: ParquetError) -> Error {
    files::failed(path, std::io::Error::other(error)).into()
}
