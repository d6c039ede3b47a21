//! The rows as a table: Parquet that pandas, Polars, DuckDB and Spark read, or CSV; the same
//! bytes for the same rows. Memory: one group of rows.
//!
//! Lists are lists in Parquet and JSON texts in CSV; `effects` and `health` are JSON texts in
//! both.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use crate::files::{self, NewFile};
use serde_json::Value;

use super::row::{Row, by_number};
use crate::Error;

/// The columns, in their order.
pub const COLUMNS: [&str; 17] = [
    "robot",
    "day",
    "urdf_hash",
    "support",
    "postures",
    "independent",
    "noise_floor",
    "held_out_rmse",
    "verdict",
    "sentence",
    "effects",
    "health",
    "params",
    "std",
    "inputs",
    "error",
    "version",
];

/// A row's values in the order of the columns.
fn cells(row: &Row) -> [Value; COLUMNS.len()] {
    let mut all = serde_json::to_value(row).unwrap_or_default();
    let text = |list: serde_json::Result<String>| list.unwrap_or_default().into();
    COLUMNS.map(|column| match column {
        "effects" => text(serde_json::to_string(&row.effects)),
        "health" => text(serde_json::to_string(&row.health)),
        _ => all[column].take(),
    })
}

/// The rows sorted by robot and day, URDF and support; a robot that has several URDFs is told so
/// in a sentence of its rows.
pub(super) fn assembled(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| {
        let urdf = |row: &Row| [&row.urdf_hash, &row.support].map(String::clone);
        by_number(&a.robot, &b.robot)
            .then_with(|| by_number(&a.day, &b.day))
            .then_with(|| urdf(a).cmp(&urdf(b)))
    });
    let mut urdfs: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for row in rows.iter().filter(|row| !row.urdf_hash.is_empty()) {
        let hashes = urdfs.entry(row.robot.clone()).or_default();
        hashes.insert(row.urdf_hash.clone());
    }
    for row in &mut rows {
        let count = urdfs.get(&row.robot).map_or(0, BTreeSet::len);
        if count > 1 {
            let space = if row.sentence.is_empty() { "" } else { " " };
            row.sentence += &format!(
                "{space}This robot has {count} URDFs among its days; this row is of URDF {}, and \
                 rows of different URDFs are not compared.",
                row.urdf_hash
            );
        }
    }
    rows
}

/// Whether a table can be written under this name, before long work.
///
/// # Errors
/// When its end is neither `.parquet` nor `.csv`, or this build has no Parquet.
pub fn check_table(path: &Path) -> Result<(), Error> {
    let file = path.display();
    match path.extension().and_then(|end| end.to_str()) {
        Some("csv") => Ok(()),
        #[cfg(feature = "parquet")]
        Some("parquet") => Ok(()),
        #[cfg(not(feature = "parquet"))]
        Some("parquet") => Err(Error::without("parquet", "Parquet", &file.to_string())),
        _ => Err(Error::request(format!(
            "{file}: the fleet's table is written as .parquet or .csv"
        ))),
    }
}

/// Write the table, as the end of its name says. It appears whole or not at all.
///
/// # Errors
/// As [`check_table`], and when the file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
    check_table(path)?;
    #[cfg(feature = "parquet")]
    if path.extension().is_some_and(|end| end == "parquet") {
        return parquet::write(path, rows);
    }
    let failed = |error: csv::Error| files::failed(path, io::Error::other(error));
    let mut writer = csv::Writer::from_writer(NewFile::create(path)?);
    writer.write_record(COLUMNS).map_err(failed)?;
    for row in rows {
        let record = cells(row).map(|cell| match cell {
            Value::Null => String::new(),
            Value::String(text) => text,
            // Without an exponent, as numbers of CSV logs.
            Value::Number(x) if x.is_f64() => x.as_f64().unwrap_or(f64::NAN).to_string(),
            other => other.to_string(),
        });
        writer.write_record(record).map_err(failed)?;
    }
    let file = writer.into_inner();
    let file = file.map_err(|error| files::failed(path, io::Error::other(error.to_string())))?;
    Ok(file.finish()?)
}

#[cfg(feature = "parquet")]
mod parquet {
    use std::sync::Arc;

    use ::parquet::basic::Compression;
    use ::parquet::column::writer::ColumnWriter;
    use ::parquet::data_type::ByteArray;
    use ::parquet::errors::ParquetError;
    use ::parquet::file::properties::WriterProperties;
    use ::parquet::file::writer::SerializedFileWriter;
    use ::parquet::schema::parser::parse_message_type;

    use super::*;

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

    pub(super) fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
        let unwritten = |error: ParquetError| files::failed(path, io::Error::other(error));
        let schema = parse_message_type(SCHEMA).map_err(unwritten)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .build();
        let file = NewFile::create(path)?;
        let writer = SerializedFileWriter::new(file, Arc::new(schema), properties.into());
        let mut writer = writer.map_err(unwritten)?;
        for rows in rows.chunks(GROUP) {
            group(&mut writer, rows).map_err(unwritten)?;
        }
        Ok(writer.into_inner().map_err(unwritten)?.finish()?)
    }

    fn group(writer: &mut SerializedFileWriter<NewFile>, rows: &[Row]) -> Result<(), ParquetError> {
        let columns = writer.schema_descr().columns().to_vec();
        let rows: Vec<_> = rows.iter().map(cells).collect();
        let mut group = writer.next_row_group()?;
        for (at, column) in columns.iter().enumerate() {
            let (mut values, mut defined, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
            for row in &rows {
                let list = match &row[at] {
                    Value::Array(list) => list.as_slice(),
                    value => std::slice::from_ref(value),
                };
                if list.is_empty() {
                    defined.push(0);
                    repeated.push(0);
                }
                for (k, value) in list.iter().enumerate() {
                    defined.push(column.max_def_level() - i16::from(value.is_null()));
                    repeated.push(i16::from(k > 0));
                    values.extend((!value.is_null()).then_some(value));
                }
            }
            let defined = (column.max_def_level() > 0).then_some(defined.as_slice());
            let repeated = (column.max_rep_level() > 0).then_some(repeated.as_slice());
            let Some(mut to) = group.next_column()? else {
                break;
            };
            let values = values.into_iter();
            match to.untyped() {
                ColumnWriter::ByteArrayColumnWriter(to) => {
                    let texts = values.map(|text| text.as_str().unwrap_or_default().into());
                    to.write_batch(&texts.collect::<Vec<ByteArray>>(), defined, repeated)?
                }
                ColumnWriter::DoubleColumnWriter(to) => {
                    let numbers = values.map(|x| x.as_f64().unwrap_or(f64::NAN));
                    to.write_batch(&numbers.collect::<Vec<f64>>(), defined, repeated)?
                }
                ColumnWriter::Int64ColumnWriter(to) => {
                    let counts = values.map(|count| count.as_i64().unwrap_or(i64::MAX));
                    to.write_batch(&counts.collect::<Vec<i64>>(), defined, repeated)?
                }
                _ => {
                    return Err(ParquetError::General(
                        "a column of another type".to_string(),
                    ));
                }
            };
            to.close()?;
        }
        group.close()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "parquet")]
    #[test]
    fn lists_and_missing_values_are_read_back() {
        use super::*;
        use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
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
        let rows = reader.get_row_iter(None).unwrap();
        let rows: Vec<String> = rows.map(|row| row.unwrap().to_string()).collect();
        for (row, words) in rows.iter().zip([
            "robot: \"a\"|postures: 60|[0.5, 0.25]|[null, 0.125]|[\"11\", \"22\"]|error: null",
            "robot: \"b\"|postures: 0|params: []|inputs: []|noise_floor: null|error: \"broken\"",
        ]) {
            for word in words.split('|') {
                assert!(row.contains(word), "{word}: {row}");
            }
        }
        assert_eq!(rows.len(), 2);
    }
}
