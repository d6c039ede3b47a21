//! Logs in memory, named by what they hold, and the store of rows.
//!
//! The store has each row that was made in a file under the hash of everything that it depends on.
//!
//! ```text
//! key = hash(version, URDF, options, robot, day, logs with their sidecars)
//! DIR/<first two digits>/<key>.json:  {"key": key, "hash": of the row's text, "row": the row}
//! ```
//!
//! An entry is written whole or not at all. One that is damaged, or of another key, is made anew;
//! what is no regular file is no entry, and nothing is written in its place.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::{fs, io};

use serde::{Deserialize, Serialize};
use sesc_model::files;
use sesc_model::text::visible;

use super::Options;
use super::row::Row;
use crate::logs::{LogSource, Sidecar};
use crate::robot::Robot;
use crate::{Error, ErrorKind, Message};

/// A log in memory, named by what it holds.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Log {
    /// Hash of its bytes, 32 hexadecimal digits.
    pub hash: String,
    /// The bytes of its file.
    pub bytes: Arc<[u8]>,
    /// The text of its sidecar; empty where it has none.
    pub sidecar: String,
}

/// 128 bits of FNV-1a over bytes, as 32 hexadecimal digits.
///
/// ```text
/// h_0 = 0x6c62272e07bb014262b821756295c58d    h_k = (h_{k−1} xor byte_k) · (2⁸⁸ + 0x13b)  mod 2¹²⁸
/// ```
///
/// It tells the logs of a fleet apart and is no protection against forgery.
pub fn content_hash(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(
        0x6c62_272e_07bb_0142_62b8_2175_6295_c58d_u128,
        |hash, byte| (hash ^ u128::from(*byte)).wrapping_mul((1 << 88) + 0x13b),
    );
    format!("{hash:032x}")
}

impl Log {
    /// A log of these bytes with the text of its sidecar, which may be empty.
    pub fn new(bytes: impl Into<Arc<[u8]>>, sidecar: impl Into<String>) -> Log {
        let bytes = bytes.into();
        Log {
            hash: content_hash(&bytes),
            bytes,
            sidecar: sidecar.into(),
        }
    }

    /// Read a log and the sidecar beside it.
    ///
    /// # Errors
    /// When one of them cannot be read; the error names the file without its folder.
    pub fn read(path: &Path) -> Result<Log, Error> {
        let failed = |path: &Path, error| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            Error::read(visible(&name), error)
        };
        let bytes = files::read_found(path, 1 << 24).map_err(|mut error| {
            let is_text = !path.to_string_lossy().contains('\u{fffd}');
            if !is_text && error.kind() == io::ErrorKind::NotFound {
                error = io::Error::other("its name is no text in UTF-8; give it another name");
            }
            failed(path, error)
        })?;
        for beside in Sidecar::paths(path) {
            match files::read_found_text(&beside, files::SIDECAR) {
                Ok(sidecar) => return Ok(Log::new(bytes, sidecar)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(failed(&beside, error)),
            }
        }
        Ok(Log::new(bytes, ""))
    }

    /// The log with its sidecar, and what is odd about that.
    pub(super) fn source(&self) -> Result<(LogSource, Sidecar, Vec<Message>), Error> {
        let name = name_of_log(&self.hash);
        let (sidecar, odd) = Sidecar::parse(&self.sidecar, &name)
            .map_err(|message| Error::log(&name, None, format!("sidecar: {message}")))?;
        let log = LogSource::bytes(name, Arc::clone(&self.bytes)).with_sidecar(sidecar.clone());
        Ok((log, sidecar, odd))
    }
}

/// A URDF that was found beside a log or that a manifest names: its text is read and no program
/// is started for it.
pub(super) fn read_urdf(path: &Path) -> Result<Robot, Error> {
    let file = path.display().to_string();
    let text = files::read_found_text(path, 64);
    let text = text.map_err(|error| Error::read(file.clone(), error))?;
    Robot::parse(&text, &file)
}

/// Logs sorted by what they hold, each once. Of two with the same bytes the one with a sidecar
/// is kept.
pub(super) fn each_once(logs: &[Log]) -> Vec<Log> {
    let mut logs = logs.to_vec();
    logs.sort_by(|a, b| {
        let [one, other] = [a, b].map(|log| (log.sidecar.is_empty(), &log.sidecar));
        a.hash.cmp(&b.hash).then(one.cmp(&other))
    });
    logs.dedup_by(|a, b| a.hash == b.hash);
    logs
}

/// The row of these logs, of which nothing came yet.
pub(super) fn row_of((robot, day): (&str, &str), logs: &[Log]) -> Row {
    Row {
        robot: robot.to_string(),
        day: day.to_string(),
        inputs: logs.iter().map(|log| log.hash.clone()).collect(),
        version: env!("CARGO_PKG_VERSION").to_string(),
        ..Row::default()
    }
}

/// What messages call the log of this hash: the same wherever the file is.
pub(super) fn name_of_log(hash: &str) -> String {
    format!("log {}", hash.get(..12).unwrap_or(hash))
}

/// What messages call the URDF of this hash: the same wherever the file is.
pub(super) fn name_of_urdf(hash: &str) -> String {
    format!("URDF {}", hash.get(..12).unwrap_or(hash))
}

/// A log, or a group, that came to nothing or to less than it should.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Failed {
    /// The file.
    pub input: String,
    /// What is wrong with it.
    pub error: String,
}

impl Failed {
    /// A file that cannot be read, with what the system says of it.
    pub(super) fn reading(path: &Path, error: &Error) -> Failed {
        let cause = std::error::Error::source(error).filter(|_| error.kind() == ErrorKind::Read);
        let cause = cause.map_or(String::new(), |cause| format!(": {cause}"));
        Failed {
            input: path.display().to_string(),
            error: format!("{error}{cause}"),
        }
    }
}

/// What rows say of an error: the URDF by its hash and not by its path, on which nothing of a row
/// depends.
pub(super) fn without_path(error: &Error, robot: &Robot) -> String {
    let said = error.to_string();
    let about = &robot.description;
    match said.strip_prefix(&about.file) {
        Some(rest) if error.model().is_some() && !about.file.is_empty() => {
            format!("{}{rest}", name_of_urdf(&about.hash))
        }
        _ => said,
    }
}

/// Grows when rows of the same logs become others without a new version.
const FORMAT: u32 = 8;

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
        // Covariances of a robot of 500 joints are 10 MB.
        let entry = files::read_found(&self.entry(key)?, 64).ok()?;
        let entry: Entry<Row> = serde_json::from_slice(&entry).ok()?;
        let is_own = entry.key == key && entry.hash == hash(&entry.row).ok()?;
        (is_own && entry.row.is_whole()).then_some(entry.row)
    }

    /// Keep a row under `key`.
    ///
    /// # Errors
    /// When the folder or the file cannot be written.
    pub(super) fn put(&self, key: &str, row: &Row) -> Result<(), Error> {
        let Some(path) = self.entry(key) else {
            return Ok(());
        };
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)
            .map_err(|error| Error::write(folder.display().to_string(), error))?;
        let (key, hash) = (key.to_string(), hash(row)?);
        let entry = serde_json::to_vec(&Entry { key, hash, row }).map_err(Error::serialise)?;
        // An entry that a power failure damages is made again: it need not wait for the disk.
        Ok(crate::files::write_unsynced(&path, entry)?)
    }

    /// The file under `key`, which may not be there; none where something else is in its place.
    fn entry(&self, key: &str) -> Option<PathBuf> {
        let folder = self.folder.join(key.get(..2).unwrap_or("xx"));
        let path = folder.join(format!("{key}.json"));
        let about = fs::symlink_metadata(&path);
        about.map_or(true, |about| about.is_file()).then_some(path)
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

    /// From the publication of the hash.
    #[test]
    fn the_hash_is_fnv1a_with_128_bits() {
        assert_eq!(content_hash(b""), "6c62272e07bb014262b821756295c58d");
        assert_eq!(content_hash(b"a"), "d228cb696f1a8caf78912b704e4a8964");
    }

    #[test]
    fn a_log_that_comes_twice_is_kept_once_with_its_sidecar() {
        let logs = [
            Log::new(*b"b", ""),
            Log::new(*b"a", "robot = 'r'"),
            Log::new(*b"a", ""),
        ];
        let mut turned = logs.clone();
        turned.reverse();
        let kept = each_once(&logs);
        assert_eq!(kept.len(), 2);
        assert!(kept.iter().any(|log| log.sidecar == "robot = 'r'"));
        let hashes = |logs: &[Log]| logs.iter().map(|l| l.hash.clone()).collect::<Vec<_>>();
        assert_eq!(hashes(&kept), hashes(&each_once(&turned)));
    }

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
            fs::rename(store.entry(key).unwrap(), store.entry(KEY).unwrap()).unwrap();
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
        fs::create_dir_all(store.entry(KEY).unwrap().parent().unwrap()).unwrap();
        std::os::unix::fs::symlink(&precious, store.entry(KEY).unwrap()).unwrap();
        fs::create_dir(store.entry("ab35").unwrap()).unwrap();
        for key in [KEY, "ab35"] {
            store.put(key, &row()).unwrap();
            assert_eq!(store.get(key), None);
        }
        assert_eq!(fs::read_to_string(&precious).unwrap(), "do not touch");
    }
}
