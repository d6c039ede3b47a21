//! Where logs and the entries of a store are: the files of this machine, or whatever a caller
//! reads and writes for us, such as an object store.

use std::fmt::Debug;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use sesc_model::files;

use crate::Error;
use crate::robot::Robot;

/// Largest URDF, bytes.
const URDF: u64 = 64 << 20;

/// What tells that a log was changed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Bytes.
    pub size: u64,
    /// Time of the last change since 1970, where a file that is written twice within a moment
    /// may keep its tag; none where every change gives another tag.
    pub changed: Option<Duration>,
    /// Another after a change: the number of a file on its disk, the ETag of an object.
    pub tag: String,
}

/// Reads logs and URDFs, reads and writes entries of the store.
pub trait Disk: Debug + Send + Sync {
    /// What tells that a log was changed; none where that is not known.
    fn stamp(&self, log: &Path) -> Option<Stamp>;

    /// All bytes of a file, which may have `most`.
    ///
    /// # Errors
    /// The kind `NotFound` where there is none; whatever else keeps it from being read.
    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>>;

    /// Write entries of a store in this order, each whole or not at all.
    ///
    /// # Errors
    /// When one cannot be written.
    fn write(&self, entries: &[(PathBuf, Vec<u8>)]) -> Result<(), Error>;

    /// Read a URDF.
    ///
    /// # Errors
    /// When it cannot be read, or everything that is wrong with it.
    fn robot(&self, urdf: &Path) -> Result<Robot, Error> {
        let file = urdf.display().to_string();
        let text = read_text(self, urdf, URDF);
        let text = text.map_err(|error| Error::read(file.clone(), error))?;
        Robot::parse(&text, &file)
    }
}

/// The text of a file that may have `most` bytes.
pub(super) fn read_text<D: Disk + ?Sized>(disk: &D, path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(disk.read(path, most)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8"))
}

/// The files of this machine.
#[derive(Debug, Clone, Copy, Default)]
pub struct Local;

impl Disk for Local {
    fn stamp(&self, log: &Path) -> Option<Stamp> {
        std::fs::metadata(log).ok().and_then(|about| stamp(&about))
    }

    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let file = regular(path)?;
        let stamp = files::Stamp::of(&file);
        (&file)
            .take(most.saturating_add(1))
            .read_to_end(&mut bytes)?;
        stamp.map_or(Ok(()), |stamp| stamp.check(&file))?;
        match bytes.len() as u64 > most {
            true => Err(io::Error::other(format!(
                "it has more than {most} bytes, more than such a file can need"
            ))),
            false => Ok(bytes),
        }
    }

    fn write(&self, entries: &[(PathBuf, Vec<u8>)]) -> Result<(), Error> {
        for (path, bytes) in entries {
            let folder = path.parent().unwrap_or(Path::new("."));
            std::fs::create_dir_all(folder)
                .map_err(|error| Error::write(folder.display().to_string(), error))?;
            // An entry begins with the hash of the rest: one that a power failure damages is
            // made again, and thousands need not wait for the disk.
            crate::files::write_unsynced(path, bytes)?;
        }
        Ok(())
    }

    fn robot(&self, urdf: &Path) -> Result<Robot, Error> {
        regular(urdf).map_err(|error| Error::read(urdf.display().to_string(), error))?;
        Robot::read(urdf)
    }
}

/// A regular file, opened: a pipe has no bytes until somebody writes them, and a device may have
/// no end, so that one of them would hold up the whole fleet.
fn regular(path: &Path) -> io::Result<std::fs::File> {
    let about = std::fs::metadata(path)?;
    let what = match (about.is_file(), about.is_dir()) {
        (true, _) => return std::fs::File::open(path),
        (false, true) => "it is a folder",
        (false, false) => "it is a pipe or a device; a fleet reads regular files",
    };
    Err(io::Error::other(what))
}

#[cfg(unix)]
fn stamp(about: &std::fs::Metadata) -> Option<Stamp> {
    use std::os::unix::fs::MetadataExt as _;
    let seconds = about.ctime().try_into().ok()?;
    Some(Stamp {
        size: about.len(),
        changed: Some(Duration::new(seconds, about.ctime_nsec().try_into().ok()?)),
        tag: about.ino().to_string(),
    })
}

#[cfg(not(unix))]
fn stamp(about: &std::fs::Metadata) -> Option<Stamp> {
    let since = about.modified().ok()?.duration_since(std::time::UNIX_EPOCH);
    Some(Stamp {
        size: about.len(),
        changed: Some(since.ok()?),
        tag: String::new(),
    })
}
