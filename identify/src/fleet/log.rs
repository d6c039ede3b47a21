//! A log in memory, by what it holds.

use std::io;
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sesc_model::files;
use sesc_model::text::visible;

use crate::logs::{LogSource, Sidecar};
use crate::robot::Robot;
use crate::{Error, ErrorKind, Message};

/// Largest log, MiB.
const LOG: u64 = 1 << 24;
/// Largest URDF, MiB.
const URDF: u64 = 64;

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
    const START: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = (1 << 88) + 0x13b;
    let hash = bytes.iter().fold(START, |hash, byte| {
        (hash ^ u128::from(*byte)).wrapping_mul(PRIME)
    });
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
        let bytes = files::read_found(path, LOG);
        let bytes = bytes.map_err(|error| match error.kind() {
            io::ErrorKind::NotFound if path.to_string_lossy().contains('\u{fffd}') => failed(
                path,
                io::Error::other("its name is no text in UTF-8; give it another name"),
            ),
            _ => failed(path, error),
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
    let text = files::read_found_text(path, URDF);
    let text = text.map_err(|error| Error::read(file.clone(), error))?;
    Robot::parse(&text, &file)
}

/// Logs sorted by what they hold, each once. Of two with the same bytes the one with a sidecar
/// is kept.
pub(super) fn each_once(logs: &[Log]) -> Vec<Log> {
    let mut logs = logs.to_vec();
    logs.sort_by_cached_key(|log| {
        (
            log.hash.clone(),
            log.sidecar.is_empty(),
            log.sidecar.clone(),
        )
    });
    logs.dedup_by(|a, b| a.hash == b.hash);
    logs
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
        let error = match std::error::Error::source(error) {
            Some(cause) if error.kind() == ErrorKind::Read => format!("{error}: {cause}"),
            _ => error.to_string(),
        };
        Failed {
            input: path.display().to_string(),
            error,
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
