//! What the logs of a group held when they were last read, so that a second run opens none of
//! them.
//!
//! A log is taken for the same while its size, the time of its last change and its number on the
//! disk stay. The time is the one that programs cannot set, where the system keeps such a one;
//! a log that was changed less than two seconds before it was read is read again, since another
//! change may have the same time.

use std::collections::BTreeMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::content::{Content, Log, read_sidecar};
use crate::Error;

/// A change is older than this when a log is read, or it is read again the next time.
const SETTLED: Duration = Duration::from_secs(2);

/// What tells that a file was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    size: u64,
    /// Since 1970.
    changed: Duration,
    number: u64,
}

/// Hashes of logs by their paths, with the files' stamps.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Seen {
    logs: BTreeMap<PathBuf, (Stamp, String)>,
}

/// A log of a group, in memory if it had to be read.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub content: Content,
    pub log: Option<Log>,
}

impl Seen {
    /// The log at `path`, which is read unless it is known.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn held(&self, path: &Path, after: &mut Seen) -> Result<Held, Error> {
        let stamp = std::fs::metadata(path)
            .ok()
            .and_then(|about| Stamp::of(&about));
        let known = self
            .logs
            .get(path)
            .filter(|(known, _)| stamp == Some(*known));
        if let Some((stamp, hash)) = known {
            after
                .logs
                .insert(path.to_path_buf(), (*stamp, hash.clone()));
            let content = Content {
                hash: hash.clone(),
                size: stamp.size,
                sidecar: read_sidecar(path)?,
            };
            return Ok(Held { content, log: None });
        }
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let log = Log::read(path)?;
        let content = log.content();
        let settled = |stamp: &Stamp| stamp.changed + SETTLED <= now && stamp.size == content.size;
        if let Some(stamp) = stamp.filter(settled) {
            after
                .logs
                .insert(path.to_path_buf(), (stamp, log.hash.clone()));
        }
        Ok(Held {
            content,
            log: Some(log),
        })
    }
}

impl Stamp {
    #[cfg(unix)]
    fn of(about: &Metadata) -> Option<Stamp> {
        use std::os::unix::fs::MetadataExt as _;
        Some(Stamp {
            size: about.len(),
            changed: Duration::new(
                about.ctime().try_into().ok()?,
                about.ctime_nsec().try_into().ok()?,
            ),
            number: about.ino(),
        })
    }

    #[cfg(not(unix))]
    fn of(about: &Metadata) -> Option<Stamp> {
        Some(Stamp {
            size: about.len(),
            changed: about.modified().ok()?.duration_since(UNIX_EPOCH).ok()?,
            number: 0,
        })
    }
}
