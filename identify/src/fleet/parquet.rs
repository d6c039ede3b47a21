//! The rows as Parquet that pandas, Polars, DuckDB and Spark read. Memory: one group of rows.

use std::path::Path;
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::row::{Row, json};
use crate::Error;
use crate::files::{self, NewFile};

/// Rows of a group.
const GROUP: usize = 10_000;

const SCHEMA: &str = "message fleet {
    REQUIRED BYTE_ARRAY robot (UTF8);
    REQUIRED BYTE_ARRAY day (UTF8);
    REQUIRED BYTE_ARRAY urdf_hash (UTF8);
    REQUIRED BYTE_ARRAY support (UTF8);
    REQUIRED INT64 postures;
    REQUIRED INT64 independent;
    OPTIONAL DOUBLE noise_floor;
    OPTIONAL DOUBLE held_out_rmse;
    REQUIRED BYTE_ARRAY verdict (UTF8);
    REQUIRED BYTE_ARRAY sentence (UTF8);
    REQUIRED BYTE_ARRAY effects (UTF8);
    REQUIRED BYTE_ARRAY health (UTF8);
    REQUIRED GROUP params (LIST) { REPEATED GROUP list { OPTIONAL DOUBLE element; } }
    REQUIRED GROUP std (LIST) { REPEATED GROUP list { OPTIONAL DOUBLE element; } }
    REQUIRED GROUP inputs (LIST) { REPEATED GROUP list { REQUIRED BYTE_ARRAY element (UTF8); } }
    OPTIONAL BYTE_ARRAY error (UTF8);
    REQUIRED BYTE_ARRAY version (UTF8);
}";

/// Values of one column with where they belong.
#[derive(Default)]
struct Values<T> {
    values: Vec<T>,
    /// None of a column that is required and no list.
    defined: Option<Vec<i16>>,
    repeated: Option<Vec<i16>>,
}

enum Column {
    Text(Values<ByteArray>),
    Whole(Vec<i64>),
    Number(Values<f64>),
}

/// Write the table; it appears whole or not at all.
pub(super) fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
    let unwritten = |error: ParquetError| files::failed(path, std::io::Error::other(error));
    let schema = parse_message_type(SCHEMA).map_err(unwritten)?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .build();
    let file = NewFile::create(path)?;
    let mut writer =
        SerializedFileWriter::new(file, Arc::new(schema), properties.into()).map_err(unwritten)?;
    for rows in rows.chunks(GROUP) {
        group(&mut writer, rows).map_err(unwritten)?;
    }
    Ok(writer.into_inner().map_err(unwritten)?.finish()?)
}

fn group(writer: &mut SerializedFileWriter<NewFile>, rows: &[Row]) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for column in columns(rows) {
        let Some(mut to) = group.next_column()? else {
            break;
        };
        match (to.untyped(), column) {
            (ColumnWriter::ByteArrayColumnWriter(to), Column::Text(all)) => {
                to.write_batch(&all.values, all.defined.as_deref(), all.repeated.as_deref())?;
            }
            (ColumnWriter::Int64ColumnWriter(to), Column::Whole(all)) => {
                to.write_batch(&all, None, None)?;
            }
            (ColumnWriter::DoubleColumnWriter(to), Column::Number(all)) => {
                to.write_batch(&all.values, all.defined.as_deref(), all.repeated.as_deref())?;
            }
            _ => return Err(ParquetError::General("columns out of order".to_string())),
        }
        to.close()?;
    }
    group.close()?;
    Ok(())
}

/// All columns in the order of the schema.
fn columns(rows: &[Row]) -> Vec<Column> {
    let text = |of: &dyn Fn(&Row) -> String| {
        Column::Text(Values {
            values: rows.iter().map(|row| of(row).as_str().into()).collect(),
            ..Values::default()
        })
    };
    let whole =
        |of: &dyn Fn(&Row) -> u64| Column::Whole(rows.iter().map(|row| of(row) as i64).collect());
    let number = |of: &dyn Fn(&Row) -> Option<f64>| Column::Number(optional(rows.iter().map(of)));
    vec![
        text(&|row| row.robot.clone()),
        text(&|row| row.day.clone()),
        text(&|row| row.urdf_hash.clone()),
        text(&|row| row.support.clone()),
        whole(&|row| row.postures),
        whole(&|row| row.independent),
        number(&|row| row.noise_floor),
        number(&|row| row.held_out_rmse),
        text(&|row| row.verdict_name().to_string()),
        text(&|row| row.sentence.clone()),
        text(&|row| json(&row.effects)),
        text(&|row| json(&row.health)),
        Column::Number(lists(
            rows.iter().map(|row| row.params.iter().copied().map(Some)),
            true,
        )),
        Column::Number(lists(rows.iter().map(|row| row.std.iter().copied()), true)),
        Column::Text(lists(
            rows.iter()
                .map(|row| row.inputs.iter().map(|hash| Some(hash.as_str().into()))),
            false,
        )),
        Column::Text(optional(
            rows.iter()
                .map(|row| row.error.as_deref().map(ByteArray::from)),
        )),
        text(&|row| row.version.clone()),
    ]
}

/// A value a row, or none.
fn optional<T>(all: impl Iterator<Item = Option<T>>) -> Values<T> {
    let (mut values, mut defined) = (Vec::new(), Vec::new());
    for value in all {
        defined.push(i16::from(value.is_some()));
        values.extend(value);
    }
    Values {
        values,
        defined: Some(defined),
        repeated: None,
    }
}

/// A list a row. A list is there (1) with elements that may be missing (2), or it is empty (0).
fn lists<T, L: Iterator<Item = Option<T>>>(
    all: impl Iterator<Item = L>,
    optional: bool,
) -> Values<T> {
    let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
    for list in all {
        let before = repeated.len();
        for value in list {
            repeated.push(i16::from(repeated.len() > before));
            defined.push(1 + i16::from(optional && value.is_some()));
            values.extend(value);
        }
        if repeated.len() == before {
            repeated.push(0);
            defined.push(0);
        }
    }
    Values {
        values,
        defined: Some(defined),
        repeated: Some(repeated),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader as _, SerializedFileReader};

    #[test]
    fn lists_and_missing_values_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fleet.parquet");
        let full = Row {
            robot: "a".into(),
            postures: 60,
            noise_floor: Some(1e-4),
            params: vec![0.5, 0.25],
            std: vec![None, Some(0.125)],
            inputs: vec!["11".into(), "22".into()],
            ..Row::default()
        };
        let empty = Row {
            robot: "b".into(),
            error: Some("broken".into()),
            ..Row::default()
        };
        write(&path, &[full, empty]).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let rows: Vec<String> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap().to_string())
            .collect();
        for (row, words) in rows.iter().zip([
            [
                "robot: \"a\"",
                "postures: 60",
                "[0.5, 0.25]",
                "[null, 0.125]",
                "[\"11\", \"22\"]",
                "error: null",
            ],
            [
                "robot: \"b\"",
                "postures: 0",
                "params: []",
                "inputs: []",
                "noise_floor: null",
                "error: \"broken\"",
            ],
        ]) {
            for word in words {
                assert!(row.contains(word), "{word}: {row}");
            }
        }
        assert_eq!(rows.len(), 2);
    }
}
