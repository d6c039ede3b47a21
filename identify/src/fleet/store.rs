//! Rows that were made, under the hash of everything that they depend on.
//!
//! ```text
//! key = hash(version, URDF, options, robot, day, logs with their sidecars)
//! DIR/<first two digits>/<key>.json:  hash of the rest, new line, the row as JSON
//! ```
//!
//! An entry is written whole or not at all. One that is damaged is made anew.

use std::path::{Path, PathBuf};

use sesc_model::files;

use super::content::{Log, content_hash, each_once};
use super::options::Options;
use super::row::Row;
use crate::Error;
use crate::robot::Robot;

/// Grows when rows of the same logs become others without a new version.
const FORMAT: u32 = 1;
/// Largest entry that is read, MiB.
const ENTRY: u64 = 64;

/// A folder of rows.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Store {
    /// The folder.
    pub folder: PathBuf,
}

impl Store {
    /// The store in `folder`, which is made with the first row.
    pub fn new(folder: impl Into<PathBuf>) -> Store {
        Store {
            folder: folder.into(),
        }
    }

    /// The name of a group's row.
    pub fn key(
        robot: &Robot,
        options: &Options,
        (name, day): (&str, &str),
        logs: &[Log],
    ) -> String {
        let mut text = format!("{FORMAT}\n{}\n", env!("CARGO_PKG_VERSION"));
        // Lengths come before what may hold anything.
        let mut add = |part: &str| text += &format!("{}:{part}\n", part.len());
        add(robot.text());
        add(&options.key());
        add(name);
        add(day);
        for log in each_once(logs) {
            add(&format!("{} of {} bytes", log.hash, log.bytes.len()));
            add(&log.sidecar);
        }
        content_hash(text.as_bytes())
    }

    fn path(&self, key: &str) -> PathBuf {
        let folder = self.folder.join(key.get(..2).unwrap_or("xx"));
        folder.join(format!("{key}.json"))
    }

    /// The row under `key`; none where there is none, or a damaged one.
    pub fn get(&self, key: &str) -> Option<Row> {
        let text = files::read_text(&self.path(key), ENTRY).ok()?;
        let (hash, row) = text.split_once('\n')?;
        let is_whole = hash == content_hash(row.as_bytes());
        is_whole.then(|| serde_json::from_str(row).ok())?
    }

    /// Keep a row under `key`.
    ///
    /// # Errors
    /// When the folder or the file cannot be written.
    pub fn put(&self, key: &str, row: &Row) -> Result<(), Error> {
        let path = self.path(key);
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder)
            .map_err(|error| Error::write(folder.display().to_string(), error))?;
        let row = serde_json::to_string(row).map_err(Error::serialise)?;
        Ok(files::write(
            &path,
            &format!("{}\n{row}", content_hash(row.as_bytes())),
        )?)
    }
}
