//! Rows that were made, and the parts of logs, under the hash of everything that they depend on.
//!
//! ```text
//! key = hash(version, URDF, options, robot, day, logs with their sidecars)
//! DIR/<first two digits>/<key>.json:  hash of the rest, new line, the row as JSON
//! key = hash(version, URDF, options, support, one log with its sidecar)
//! DIR/parts/<first two digits>/<key>.part:  likewise, what the log contributes to a fit
//! DIR/seen/<first two digits>/<hash(path)>.json:  likewise, what a log held
//! ```
//!
//! An entry is written whole or not at all. One that is damaged is made anew.

use std::path::{Path, PathBuf};

use super::content::{Content, content_hash, each_once};
use super::disk::Disk;
use super::known_logs::Seen;
use super::options::Options;
use super::part_of_log::{Contribution, Gathering};
use super::row::Row;
use crate::Error;
use crate::robot::Robot;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Grows when rows or parts of the same logs become others without a new version.
const FORMAT: u32 = 6;
/// Largest entry that is read, bytes.
const ENTRY: u64 = 64 << 20;
/// Digits of the hash that an entry begins with.
const DIGITS: usize = 32;

/// A folder of rows and parts.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Store {
    /// The folder.
    pub folder: PathBuf,
}

/// A file of the store and its bytes.
pub(super) type Entry = (PathBuf, Vec<u8>);

impl Store {
    /// The store in `folder`, which is made with the first row.
    pub fn new(folder: impl Into<PathBuf>) -> Store {
        Store {
            folder: folder.into(),
        }
    }

    /// The name of a group's row.
    pub(super) fn key(
        robot: &Robot,
        options: &Options,
        (name, day): (&str, &str),
        logs: &[Content],
    ) -> String {
        let mut text = Named::new("row");
        text.add(robot.text());
        text.add(&options.key());
        text.add(name);
        text.add(day);
        for log in each_once(logs) {
            text.add_log(&log);
        }
        text.hash()
    }

    /// The name of a log's part.
    pub(super) fn part_key(how: &Gathering, log: &Content) -> String {
        let mut text = Named::new("part");
        text.add(how.robot.text());
        text.add(&how.options.of_parts().key());
        text.add(how.support);
        text.add(if how.alone { "alone" } else { "among others" });
        text.add_log(log);
        text.hash()
    }

    /// The row under `key`; none where there is none, or a damaged one.
    pub fn get(&self, disk: &dyn Disk, key: &str) -> Option<Row> {
        parsed(disk, &self.path(key))
    }

    /// The entry of a row under `key`.
    ///
    /// # Errors
    /// When it cannot be written down.
    pub(super) fn entry_of_row(&self, key: &str, row: &Row) -> Result<Entry, Error> {
        Ok((self.path(key), written(&json(row)?)))
    }

    /// What a log contributes to a fit; none where that is not there, or damaged.
    pub(super) fn part(
        &self,
        disk: &dyn Disk,
        how: &Gathering,
        log: &Content,
    ) -> Option<Contribution> {
        let bytes = whole(disk, &self.part_path(how, log))?;
        Contribution::from_bytes(&bytes, how, log)
    }

    /// Keep what a log contributes to a fit.
    ///
    /// # Errors
    /// When the folder or the file cannot be written.
    pub(super) fn put_part(
        &self,
        disk: &dyn Disk,
        (how, log): (&Gathering, &Content),
        part: &Contribution,
    ) -> Result<(), Error> {
        disk.write(&[(self.part_path(how, log), written(&part.to_bytes()?))])
    }

    /// What the log at a path held; none where that is not known.
    pub(super) fn seen(&self, disk: &dyn Disk, log: &Path) -> Option<Seen> {
        parsed(disk, &self.seen_path(log))
    }

    /// The entry of what the log at a path held.
    ///
    /// # Errors
    /// When it cannot be written down.
    pub(super) fn entry_of_seen(&self, log: &Path, seen: &Seen) -> Result<Entry, Error> {
        Ok((self.seen_path(log), written(&json(seen)?)))
    }

    fn path(&self, key: &str) -> PathBuf {
        place(&self.folder, key, "json")
    }

    fn part_path(&self, how: &Gathering, log: &Content) -> PathBuf {
        place(
            &self.folder.join("parts"),
            &Store::part_key(how, log),
            "part",
        )
    }

    fn seen_path(&self, log: &Path) -> PathBuf {
        let key = content_hash(format!("{FORMAT}\n{log:?}").as_bytes());
        place(&self.folder.join("seen"), &key, "json")
    }
}

/// Everything that an entry depends on.
struct Named(String);

impl Named {
    fn new(kind: &str) -> Named {
        Named(format!("{FORMAT} {kind}\n{}\n", env!("CARGO_PKG_VERSION")))
    }

    /// Lengths come before what may hold anything.
    fn add(&mut self, part: &str) {
        self.0 += &format!("{}:{part}\n", part.len());
    }

    fn add_log(&mut self, log: &Content) {
        self.add(&format!("{} of {} bytes", log.hash, log.size));
        self.add(&log.sidecar);
    }

    fn hash(&self) -> String {
        content_hash(self.0.as_bytes())
    }
}

fn place(folder: &Path, key: &str, end: &str) -> PathBuf {
    let folder = folder.join(key.get(..2).unwrap_or("xx"));
    folder.join(format!("{key}.{end}"))
}

/// What an entry that is whole holds.
fn whole(disk: &dyn Disk, path: &Path) -> Option<Vec<u8>> {
    let mut bytes = disk.read(path, ENTRY).ok()?;
    let (hash, rest) = bytes.split_at_checked(DIGITS)?;
    let rest = rest.strip_prefix(b"\n")?;
    let is_whole = hash == content_hash(rest).as_bytes();
    is_whole.then(|| bytes.split_off(DIGITS + 1))
}

fn parsed<T: DeserializeOwned>(disk: &dyn Disk, path: &Path) -> Option<T> {
    serde_json::from_slice(&whole(disk, path)?).ok()
}

/// The bytes of an entry.
fn written(what: &[u8]) -> Vec<u8> {
    [content_hash(what).as_bytes(), b"\n", what].concat()
}

fn json(what: &impl Serialize) -> Result<Vec<u8>, Error> {
    serde_json::to_vec(what).map_err(Error::serialise)
}
