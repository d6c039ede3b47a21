//! The rows as a table: Parquet or CSV, the same bytes for the same rows.
//!
//! Lists are lists in Parquet and JSON texts in CSV; `effects` and `health` are JSON texts in
//! both.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::files::{self, NewFile};

use super::row::{Row, by_number, json};
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

/// The rows sorted by robot and day, URDF and support; a robot that has several URDFs is told so
/// in a sentence of its rows.
pub fn assembled(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| {
        let urdf = |row: &Row| [&row.urdf_hash, &row.support].map(String::clone);
        by_number(&a.robot, &b.robot)
            .then_with(|| by_number(&a.day, &b.day))
            .then_with(|| urdf(a).cmp(&urdf(b)))
    });
    let mut urdfs: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for row in rows.iter().filter(|row| !row.urdf_hash.is_empty()) {
        urdfs.entry(&row.robot).or_default().insert(&row.urdf_hash);
    }
    let several = urdfs.into_iter().filter(|(_, hashes)| hashes.len() > 1);
    let several: BTreeMap<String, usize> = several
        .map(|(robot, hashes)| (robot.to_string(), hashes.len()))
        .collect();
    for row in &mut rows {
        if let Some(count) = several.get(&row.robot) {
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
    match end(path) {
        #[cfg(not(feature = "parquet"))]
        "parquet" => Err(Error::without(
            "parquet",
            "Parquet",
            &path.display().to_string(),
        )),
        #[cfg(feature = "parquet")]
        "parquet" => Ok(()),
        "csv" => Ok(()),
        _ => Err(Error::request(format!(
            "{}: the fleet's table is written as .parquet or .csv",
            path.display()
        ))),
    }
}

fn end(path: &Path) -> &str {
    path.extension().and_then(|end| end.to_str()).unwrap_or("")
}

/// Write the table, as the end of its name says. It appears whole or not at all.
///
/// # Errors
/// As [`check_table`], and when the file cannot be written.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), Error> {
    check_table(path)?;
    match end(path) {
        #[cfg(feature = "parquet")]
        "parquet" => super::parquet::write(path, rows),
        _ => csv(path, rows),
    }
}

fn csv(path: &Path, rows: &[Row]) -> Result<(), Error> {
    let failed = |error: csv::Error| files::failed(path, std::io::Error::other(error));
    let mut writer = csv::Writer::from_writer(NewFile::create(path)?);
    writer.write_record(COLUMNS).map_err(failed)?;
    for row in rows {
        let number = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
        let record = [
            row.robot.clone(),
            row.day.clone(),
            row.urdf_hash.clone(),
            row.support.clone(),
            row.postures.to_string(),
            row.independent.to_string(),
            number(row.noise_floor),
            number(row.held_out_rmse),
            row.verdict_name().to_string(),
            row.sentence.clone(),
            json(&row.effects),
            json(&row.health),
            json(&row.params),
            json(&row.std),
            json(&row.inputs),
            row.error.clone().unwrap_or_default(),
            row.version.clone(),
        ];
        writer.write_record(record).map_err(failed)?;
    }
    let file = writer.into_inner();
    let file =
        file.map_err(|error| files::failed(path, std::io::Error::other(error.to_string())))?;
    Ok(file.finish()?)
}
