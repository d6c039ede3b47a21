//! Lists of logs, and manifests: tables of logs with what is said of each.
//!
//! A manifest is read as logs are: a byte order mark, `;` or tabs between fields and names in
//! capitals are all fine.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use sesc_model::files;

use super::input::{Input, is_address};
use crate::Error;
use crate::logs::delimiter;

/// Largest list or manifest, MiB.
const LIST: u64 = 1024;
/// The column of a manifest that makes it one.
const PATH: &str = "path";
/// What a manifest may say of a log besides its keys.
const ABOUT: [&str; 2] = ["urdf", "support"];

fn read(path: &Path) -> Result<String, Error> {
    files::read_text(path, LIST).map_err(|error| Error::read(path.display().to_string(), error))
}

/// A path relative to a folder, or an address such as `s3://bucket/log.csv`.
fn place(folder: &Path, text: &str) -> PathBuf {
    match is_address(text) {
        true => PathBuf::from(text),
        false => folder.join(text),
    }
}

/// The logs of a list.
///
/// # Errors
/// When it cannot be read.
pub(super) fn list(path: &Path, by: &[String], found: &mut Vec<Input>) -> Result<(), Error> {
    let beside = path.parent().unwrap_or(Path::new("."));
    let text = read(path)?;
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    for line in lines.filter(|line| !line.is_empty() && !line.starts_with('#')) {
        found.push(Input::new(place(beside, line), &BTreeMap::new(), by));
    }
    Ok(())
}

/// Whether a CSV file is a manifest: a log has no column `path`.
pub(super) fn is_manifest(path: &Path) -> bool {
    // Who opens a pipe waits for its writer.
    if path.extension().is_none_or(|end| end != "csv") || !path.is_file() {
        return false;
    }
    let Ok(file) = std::fs::File::open(path) else {
        return false;
    };
    let mut header = Vec::new();
    let read = BufReader::new(file.take(1 << 16)).read_until(b'\n', &mut header);
    let header = String::from_utf8_lossy(&header);
    read.is_ok()
        && delimiter(header.as_bytes()).is_ok_and(|between| {
            let mut names = header.split(char::from(between));
            names.any(|name| bare(name.trim_end()).eq_ignore_ascii_case(PATH))
        })
}

/// The name of a column without quotes and blanks around it, and without a byte order mark.
fn bare(name: &str) -> &str {
    let name = name.trim_start_matches('\u{feff}').trim();
    name.trim_matches('"').trim()
}

/// The logs of a manifest.
///
/// # Errors
/// When it cannot be read, and rows that name no log.
pub(super) fn manifest(path: &Path, by: &[String], found: &mut Vec<Input>) -> Result<(), Error> {
    let file = path.display().to_string();
    let beside = path.parent().unwrap_or(Path::new("."));
    let bad = |error: csv::Error| {
        let line = error.position().map(csv::Position::line);
        Error::log(
            file.clone(),
            line,
            "is no manifest: a row has more or fewer fields than the header",
        )
    };
    let text = read(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let between = delimiter(text.as_bytes());
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .delimiter(between.map_err(|message| Error::log(file.clone(), None, message))?)
        .from_reader(text.as_bytes());
    let known: Vec<&str> = by.iter().map(String::as_str).collect();
    let known = [&known[..], &[PATH], &ABOUT].concat();
    let header = reader.headers().map_err(bad)?.clone();
    let header: Vec<&str> = header.iter().map(|name| ours(bare(name), &known)).collect();
    for record in reader.records() {
        let record = record.map_err(bad)?;
        let fields = header.iter().zip(&record);
        let mut said: BTreeMap<String, String> = fields
            .map(|(key, value)| (key.to_string(), value.to_string()))
            .collect();
        let Some(log) = said.remove(PATH).filter(|log| !log.is_empty()) else {
            let line = record.position().map(csv::Position::line);
            return Err(Error::log(
                file.clone(),
                line,
                "this row of the manifest has no path",
            ));
        };
        if let Some(urdf) = said.get_mut("urdf").filter(|urdf| !urdf.is_empty()) {
            *urdf = place(beside, urdf).display().to_string();
        }
        found.push(Input::new(place(beside, &log), &said, by));
    }
    Ok(())
}

/// Our spelling of a column's name, whatever letters of it are capitals.
fn ours<'a>(name: &'a str, known: &[&'a str]) -> &'a str {
    let same = known.iter().find(|own| **own == name);
    let alike = || known.iter().find(|own| own.eq_ignore_ascii_case(name));
    same.or_else(alike).copied().unwrap_or(name)
}
