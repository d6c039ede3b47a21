//! Rows that were made, under the hash of everything that they depend on.
//!
//! ```text
//! key = hash(version, URDF, options, robot, day, logs with their sidecars)
//! DIR/<first two digits>/<key>.json:  hash of the rest, new line, the row as JSON
//! DIR/seen/<first two digits>/<hash(robot, day, paths)>.json:  likewise, what logs held
//! ```
//!
//! An entry is written whole or not at all. One that is damaged is made anew.

use std::path::{Path, PathBuf};

use super::content::{Content, content_hash, each_once};
use super::disk::{Disk, read_text};
use super::groups::Group;
use super::known_logs::Seen;
use super::options::Options;
use super::row::Row;
use crate::Error;
use crate::robot::Robot;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Grows when rows of the same logs become others without a new version.
const FORMAT: u32 = 2;
/// Largest entry that is read, bytes.
const ENTRY: u64 = 64 << 20;

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

    /// Remove what processes that were killed left in the folders of the store.
    pub(super) fn sweep(&self) {
        sesc_model::files::sweep_below(&self.folder, 2);
    }

    /// The name of a group's row.
    pub(super) fn key(
        robot: &Robot,
        options: &Options,
        (name, day): (&str, &str),
        logs: &[Content],
    ) -> String {
        let mut text = format!("{FORMAT}\n{}\n", env!("CARGO_PKG_VERSION"));
        // Lengths come before what may hold anything.
        let mut add = |part: &str| text += &format!("{}:{part}\n", part.len());
        add(robot.text());
        add(&options.key());
        add(name);
        add(day);
        for log in each_once(logs) {
            add(&format!("{} of {} bytes", log.hash, log.size));
            add(&log.sidecar);
        }
        content_hash(text.as_bytes())
    }

    /// The row under `key`; none where there is none, or a damaged one.
    pub fn get(&self, disk: &dyn Disk, key: &str) -> Option<Row> {
        entry(disk, &self.path(key))
    }

    /// Keep a row under `key`, and what the logs of its group held.
    ///
    /// # Errors
    /// When the folder or a file cannot be written.
    pub(super) fn put(
        &self,
        disk: &dyn Disk,
        (key, row): (&str, &Row),
        group: &Group,
        seen: &Seen,
    ) -> Result<(), Error> {
        let row = (self.path(key), text(row)?);
        let seen = (self.seen_path(group), text(seen)?);
        disk.write(&[row, seen])
    }

    /// What the logs of a group held; nothing where that is not known.
    pub(super) fn seen(&self, disk: &dyn Disk, group: &Group) -> Seen {
        entry(disk, &self.seen_path(group)).unwrap_or_default()
    }

    /// Keep what the logs of a group hold.
    ///
    /// # Errors
    /// When the folder or the file cannot be written.
    pub(super) fn put_seen(
        &self,
        disk: &dyn Disk,
        group: &Group,
        seen: &Seen,
    ) -> Result<(), Error> {
        disk.write(&[(self.seen_path(group), text(seen)?)])
    }

    fn path(&self, key: &str) -> PathBuf {
        place(&self.folder, key)
    }

    fn seen_path(&self, group: &Group) -> PathBuf {
        let logs = group.logs.iter().map(|path| format!("{path:?}\n"));
        let of: String = logs.collect();
        let key = format!("{FORMAT}\n{:?}\n{:?}\n{of}", group.robot, group.day);
        place(&self.folder.join("seen"), &content_hash(key.as_bytes()))
    }
}

fn place(folder: &Path, key: &str) -> PathBuf {
    let folder = folder.join(key.get(..2).unwrap_or("xx"));
    folder.join(format!("{key}.json"))
}

/// An entry that is whole.
fn entry<T: DeserializeOwned>(disk: &dyn Disk, path: &Path) -> Option<T> {
    let text = read_text(disk, path, ENTRY).ok()?;
    let (hash, rest) = text.split_once('\n')?;
    let is_whole = hash == content_hash(rest.as_bytes());
    is_whole.then(|| serde_json::from_str(rest).ok())?
}

/// The text of an entry.
fn text(what: &impl Serialize) -> Result<String, Error> {
    let text = serde_json::to_string(what).map_err(Error::serialise)?;
    Ok(format!("{}\n{text}", content_hash(text.as_bytes())))
}
