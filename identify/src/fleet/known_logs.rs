//! What the logs of a group held when they were last read, so that a second run opens none of
//! them.
//!
//! A log is taken for the same while its size, the time of its last change and its number on the
//! disk stay; one of an object store while its size and its ETag stay. The time is the one that
//! programs cannot set, where the system keeps such a one;
//! a log that was changed less than two seconds before it was read is read again, since another
//! change may have the same time.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::content::{Content, Log, read_sidecar};
use super::disk::{Disk, Stamp};
use crate::Error;

/// A change is older than this when a log is read, or it is read again the next time.
const SETTLED: Duration = Duration::from_secs(2);

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
    pub fn held(&self, disk: &dyn Disk, path: &Path, after: &mut Seen) -> Result<Held, Error> {
        let stamp = disk.stamp(path);
        let known = self
            .logs
            .get(path)
            .filter(|(known, _)| stamp.as_ref() == Some(known));
        if let Some((stamp, hash)) = known {
            after
                .logs
                .insert(path.to_path_buf(), (stamp.clone(), hash.clone()));
            let content = Content {
                hash: hash.clone(),
                size: stamp.size,
                sidecar: read_sidecar(disk, path)?,
            };
            return Ok(Held { content, log: None });
        }
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let log = Log::read(disk, path)?;
        let content = log.content();
        let settled = |stamp: &Stamp| {
            let is_old = stamp.changed.is_none_or(|changed| changed + SETTLED <= now);
            is_old && stamp.size == content.size
        };
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
