//! What a log held when it was last read, so that a second run does not open it.
//!
//! A log is taken for the same while its size, the time of its last change and its number on the
//! disk stay; one of an object store while its size and its ETag stay. The time is the one that
//! programs cannot set, where the system keeps such a one;
//! a log that was changed less than two seconds before it was read is read again, since another
//! change may have the same time.

use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::content::{Content, Log, read_sidecar};
use super::disk::{Disk, Stamp};
use crate::Error;

/// A change is older than this when a log is read, or it is read again the next time.
const SETTLED: Duration = Duration::from_secs(2);

/// The hash of a log, with the stamp of its file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Seen {
    stamp: Stamp,
    hash: String,
}

/// A log of a group, in memory if it had to be read.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub content: Content,
    pub log: Option<Log>,
    /// Whether its file was opened.
    pub opened: bool,
    /// What it is known by the next time, where the store does not have that yet.
    pub seen: Option<Seen>,
}

impl Held {
    /// The log at `path`, which is read unless a store knows it: `known` is none without a store,
    /// and otherwise what that has of the log.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn of(disk: &dyn Disk, path: &Path, known: Option<Option<Seen>>) -> Result<Held, Error> {
        let Some(known) = known else {
            return Held::read(disk, path, None);
        };
        let stamp = disk.stamp(path);
        if let Some(known) = known.filter(|known| stamp.as_ref() == Some(&known.stamp)) {
            let content = Content {
                hash: known.hash,
                size: known.stamp.size,
                sidecar: read_sidecar(disk, path)?,
            };
            return Ok(Held {
                content,
                log: None,
                opened: false,
                seen: None,
            });
        }
        Held::read(disk, path, stamp)
    }

    /// The log at `path`, which had this stamp before it is read.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn read(disk: &dyn Disk, path: &Path, stamp: Option<Stamp>) -> Result<Held, Error> {
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let log = Log::read(disk, path)?;
        let content = log.content();
        let settled = |stamp: &Stamp| {
            let is_old = stamp.changed.is_none_or(|changed| changed + SETTLED <= now);
            is_old && stamp.size == content.size
        };
        let seen = stamp.filter(settled).map(|stamp| Seen {
            stamp,
            hash: log.hash.clone(),
        });
        Ok(Held {
            content,
            log: Some(log),
            opened: true,
            seen,
        })
    }
}
