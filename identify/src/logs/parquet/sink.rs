//! Writing Parquet logs. Memory: two groups of rows.

use std::io;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::files::NewFile;
use crate::logs::columns::{Field, POSE, Row, SUPPORT, Written, fields};

/// A Parquet file being written, a group of rows at a time.
pub(in crate::logs) struct ParquetSink {
    /// Those of the group, column by column.
    group: Vec<Values>,
    rows: usize,
    writer: SerializedFileWriter<NewFile>,
}

enum Values {
    Whole(Vec<i64>),
    Text(Vec<ByteArray>),
    Number(Vec<f64>),
}

impl ParquetSink {
    /// Start a file with the columns `names`: `pose` whole, `support` text, the
    /// others numbers.
    pub fn new(file: NewFile, names: &[String]) -> io::Result<ParquetSink> {
        let group = names.iter().map(|name| match name.as_str() {
            POSE => Values::Whole(Vec::new()),
            SUPPORT => Values::Text(Vec::new()),
            _ => Values::Number(Vec::new()),
        });
        let group: Vec<Values> = group.collect();
        let fields = names.iter().zip(&group).map(|(name, values)| {
            let (physical, logical) = match values {
                Values::Whole(_) => (Physical::INT64, None),
                Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
                Values::Number(_) => (Physical::DOUBLE, None),
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
            group,
            rows: 0,
            writer: SerializedFileWriter::new(file, schema, properties.into())?,
        })
    }

    /// Append a row.
    pub fn row(&mut self, row: &Row, columns: Written) -> io::Result<()> {
        for (field, values) in fields(row, columns).zip(&mut self.group) {
            match (field, values) {
                (Field::Whole(x), Values::Whole(all)) => all.push(x),
                (Field::Text(text), Values::Text(all)) => all.push(text.into()),
                (Field::Number(x), Values::Number(all)) => all.push(x),
                // Names and fields are in one order.
                _ => {}
            }
        }
        self.rows += 1;
        if self.rows == 65_536 {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.rows = 0;
        let mut group = self.writer.next_row_group()?;
        for values in &mut self.group {
            let Some(mut column) = group.next_column()? else {
                break;
            };
            match values {
                Values::Whole(all) => {
                    let to = column.typed::<Int64Type>();
                    to.write_batch(&std::mem::take(all), None, None)?
                }
                Values::Text(all) => {
                    let to = column.typed::<ByteArrayType>();
                    to.write_batch(&std::mem::take(all), None, None)?
                }
                Values::Number(all) => {
                    let to = column.typed::<DoubleType>();
                    to.write_batch(&std::mem::take(all), None, None)?
                }
            };
            column.close()?;
        }
        group.close()?;
        Ok(())
    }

    /// Write what is left; the file is yet to be moved to its place.
    pub fn finish(mut self) -> io::Result<NewFile> {
        if self.rows > 0 {
            self.flush()?;
        }
        Ok(self.writer.into_inner()?)
    }
}
