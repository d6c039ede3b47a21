//! Rows that were made, each in a file under the hash of everything that it depends on.
//!
//! ```text
//! key = hash(version, URDF, options, robot, day, logs with their sidecars)
//! DIR/<first two digits>/<key>.json:  {"key": key, "hash": of the row's text, "row": the row}
//! ```
//!
//! An entry is written whole or not at all. One that is damaged, or of another key, is made anew;
//! what is no regular file is no entry, and nothing is written in its place.

use std::fs;
use std::path::PathBuf;

use crate::files;
use serde::{Deserialize, Serialize};

use super::log::{Log, content_hash};
use super::options::Options;
use super::row::Row;
use crate::Error;
use crate::robot::Robot;

/// Grows when rows of the same logs become others without a new version.
const FORMAT: u32 = 7;
/// Largest entry that is read, bytes: covariances of a robot of 500 joints are 10 MB.
const ENTRY: u64 = 64 << 20;

/// A folder of rows.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Store {
    /// The folder.
    pub folder: PathBuf,
}

#[derive(Serialize, Deserialize)]
struct Entry<R> {
    key: String,
    hash: String,
    row: R,
}

/// The hash of a row's text, which is the same after it was read.
fn hash(row: &Row) -> Result<String, Error> {
    let text = serde_json::to_vec(row).map_err(Error::serialise)?;
    Ok(content_hash(&text))
}

impl Store {
    /// The store in `folder`, which is made with the first row.
    pub fn new(folder: impl Into<PathBuf>) -> Store {
        Store {
            folder: folder.into(),
        }
    }

    /// The row under `key`; none where there is none, or a damaged one.
    pub(super) fn get(&self, key: &str) -> Option<Row> {
        let path = self.path(key);
        let about = fs::symlink_metadata(&path).ok()?;
        if !about.is_file() || about.len() > ENTRY {
            return None;
        }
        let entry: Entry<Row> = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
        let is_own = entry.key == key && entry.hash == hash(&entry.row).ok()?;
        (is_own && entry.row.is_whole()).then_some(entry.row)
    }

    /// Keep a row under `key`.
    ///
    /// # Errors
    /// When the folder or the file cannot be written.
    pub(super) fn put(&self, key: &str, row: &Row) -> Result<(), Error> {
        let path = self.path(key);
        if fs::symlink_metadata(&path).is_ok_and(|about| !about.is_file()) {
            return Ok(());
        }
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)
            .map_err(|error| Error::write(folder.display().to_string(), error))?;
        let (key, hash) = (key.to_string(), hash(row)?);
        let entry = serde_json::to_vec(&Entry { key, hash, row }).map_err(Error::serialise)?;
        // An entry that a power failure damages is made again: it need not wait for the disk.
        Ok(files::write_unsynced(&path, entry)?)
    }

    fn path(&self, key: &str) -> PathBuf {
        let folder = self.folder.join(key.get(..2).unwrap_or("xx"));
        folder.join(format!("{key}.json"))
    }
}

/// The name of a group's row.
pub(super) fn key(
    robot: &Robot,
    options: &Options,
    (name, day): (&str, &str),
    logs: &[Log],
) -> String {
    let mut text = format!("{FORMAT} row\n{}\n", env!("CARGO_PKG_VERSION"));
    // Lengths come before what may hold anything.
    let mut add = |part: &str| text += &format!("{}:{part}\n", part.len());
    add(robot.text());
    add(&options.key());
    add(name);
    add(day);
    for log in logs {
        add(&format!("{} of {} bytes", log.hash, log.bytes.len()));
        add(&log.sidecar);
    }
    content_hash(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "ab34";

    fn row() -> Row {
        Row {
            robot: "r".into(),
            params: vec![1.0, 2.0],
            std: vec![None, Some(0.1)],
            covariance: vec![1.0, 0.5, 1.0],
            ..Row::default()
        }
    }

    /// A store with an entry whose row is of other content and whose hash is right.
    fn forged(row: &Row, key: &str) -> Option<Row> {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path());
        store.put(key, row).unwrap();
        if key != KEY {
            fs::rename(store.path(key), store.path(KEY)).unwrap();
        }
        store.get(KEY)
    }

    #[test]
    fn an_entry_is_believed_under_its_own_key_and_with_sound_numbers_alone() {
        assert_eq!(forged(&row(), KEY), Some(row()));
        assert_eq!(forged(&row(), "ab35"), None);
        let with = |change: &dyn Fn(&mut Row)| {
            let mut row = row();
            change(&mut row);
            forged(&row, KEY)
        };
        assert_eq!(with(&|row| row.params[0] = 1e308), None);
        assert_eq!(with(&|row| row.std[1] = Some(-0.1)), None);
        assert_eq!(with(&|row| row.params.truncate(1)), None);
        assert_eq!(with(&|row| row.covariance.truncate(2)), None);
        assert_eq!(with(&|row| row.noise_floor = Some(-1.0)), None);
    }

    /// A link in the place of an entry is not followed, and a folder does not end the run.
    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_no_entry_and_stays() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path().join("store"));
        let precious = folder.path().join("precious");
        fs::write(&precious, "do not touch").unwrap();
        fs::create_dir_all(store.path(KEY).parent().unwrap()).unwrap();
        std::os::unix::fs::symlink(&precious, store.path(KEY)).unwrap();
        fs::create_dir(store.path("ab35")).unwrap();
        for key in [KEY, "ab35"] {
            store.put(key, &row()).unwrap();
            assert_eq!(store.get(key), None);
        }
        assert_eq!(fs::read_to_string(&precious).unwrap(), "do not touch");
    }
}
