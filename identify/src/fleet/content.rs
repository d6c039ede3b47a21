//! Logs by what they hold.

use std::io;
use std::path::Path;

use sesc_model::files;
use sesc_model::text::visible;

use super::disk::{Disk, read_text};
use crate::Error;
use crate::logs::{LogSource, Sidecar};

/// A log in memory, named by what it holds.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Log {
    /// Hash of its bytes, 32 hexadecimal digits.
    pub hash: String,
    /// The bytes of its file.
    pub bytes: std::sync::Arc<[u8]>,
    /// The text of its sidecar; empty where it has none.
    pub sidecar: String,
}

/// What a log holds, without its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Content {
    pub hash: String,
    /// Bytes.
    pub size: u64,
    pub sidecar: String,
}

/// 128 bits of FNV-1a over bytes, as 32 hexadecimal digits.
///
/// ```text
/// h_0 = 0x6c62272e07bb014262b821756295c58d    h_k = (h_{k−1} xor byte_k) · (2⁸⁸ + 0x13b)  mod 2¹²⁸
/// ```
///
/// It tells the logs of a fleet apart and is no protection against somebody who forges one.
pub fn content_hash(bytes: &[u8]) -> String {
    const START: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = (1 << 88) + 0x13b;
    let hash = bytes.iter().fold(START, |hash, byte| {
        (hash ^ u128::from(*byte)).wrapping_mul(PRIME)
    });
    format!("{hash:032x}")
}

impl Log {
    /// A log of these bytes with the text of its sidecar, which may be empty.
    pub fn new(bytes: impl Into<std::sync::Arc<[u8]>>, sidecar: impl Into<String>) -> Log {
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
    pub fn read(disk: &dyn Disk, path: &Path) -> Result<Log, Error> {
        let bytes = disk.read(path, u64::MAX);
        let bytes = bytes.map_err(|error| Error::read(file_name(path), unspelled(path, error)))?;
        Ok(Log::new(bytes, read_sidecar(disk, path)?))
    }

    pub(super) fn content(&self) -> Content {
        Content {
            hash: self.hash.clone(),
            size: self.bytes.len() as u64,
            sidecar: self.sidecar.clone(),
        }
    }

    /// What messages call it: the same wherever the file is.
    pub(super) fn name(&self) -> String {
        name_of(&self.hash)
    }

    /// The log for a diagnosis, with its sidecar.
    pub(super) fn source(&self) -> Result<LogSource, Error> {
        let name = self.name();
        let parsed = Sidecar::parse(&self.sidecar, &name);
        let (sidecar, _) =
            parsed.map_err(|message| Error::log(&name, None, format!("sidecar: {message}")))?;
        let bytes = std::sync::Arc::clone(&self.bytes);
        Ok(LogSource::bytes(name, bytes).with_sidecar(sidecar))
    }
}

impl Content {
    /// What messages call the log: the same wherever the file is.
    pub fn name(&self) -> String {
        name_of(&self.hash)
    }
}

/// What messages call the log of this hash.
pub(super) fn name_of(hash: &str) -> String {
    format!("log {}", hash.get(..12).unwrap_or(hash))
}

/// The text of the sidecar beside a log; empty where there is none.
///
/// # Errors
/// When it cannot be read; the error names the file without its folder.
pub(super) fn read_sidecar(disk: &dyn Disk, log: &Path) -> Result<String, Error> {
    for beside in Sidecar::paths(log) {
        match read_text(disk, &beside, files::SIDECAR << 20) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            read => return read.map_err(|error| Error::read(file_name(&beside), error)),
        }
    }
    Ok(String::new())
}

/// The error of a file that no name in UTF-8 opens.
fn unspelled(path: &Path, error: io::Error) -> io::Error {
    let is_odd = path.to_string_lossy().contains('\u{fffd}');
    match error.kind() {
        io::ErrorKind::NotFound if is_odd => {
            io::Error::other("its name is no text in UTF-8; give it another name")
        }
        _ => error,
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    visible(&name.to_string_lossy())
}

/// Logs, or what they hold, sorted by it, each once. Of two with the same bytes the one with a
/// sidecar is kept.
pub(super) fn each_once<T: Holds + Clone>(logs: &[T]) -> Vec<T> {
    let mut logs = logs.to_vec();
    logs.sort_by(|a, b| {
        let key = |log: &T| {
            let (hash, sidecar) = log.holds();
            (hash.to_string(), sidecar.is_empty(), sidecar.to_string())
        };
        key(a).cmp(&key(b))
    });
    logs.dedup_by(|a, b| a.holds().0 == b.holds().0);
    logs
}

/// What is known by the hash of its bytes and the text of its sidecar.
pub(super) trait Holds {
    fn holds(&self) -> (&str, &str);
}

impl Holds for Log {
    fn holds(&self) -> (&str, &str) {
        (&self.hash, &self.sidecar)
    }
}

impl Holds for Content {
    fn holds(&self) -> (&str, &str) {
        (&self.hash, &self.sidecar)
    }
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
}
