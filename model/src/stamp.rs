//! Files that change while they are read.
//!
//! What is read of a file that somebody writes to is neither what it was nor what it becomes,
//! and may look whole. A file is therefore asked for its size and the time of its last change
//! before the first byte and after the last one.

use std::fs::{File, Metadata};
use std::io;
use std::time::SystemTime;

/// What tells that a regular file was changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    size: u64,
    modified: Option<SystemTime>,
    /// Device and number, where files have them: another file may be put in its place.
    place: (u64, u64),
}

impl Stamp {
    /// The stamp of an open file; none of a pipe or a device, which have no state to keep.
    pub fn of(file: &File) -> Option<Stamp> {
        let about = file.metadata().ok()?;
        about.is_file().then(|| Stamp {
            size: about.len(),
            modified: about.modified().ok(),
            place: place(&about),
        })
    }

    /// Whether the file is what it was.
    ///
    /// # Errors
    /// A sentence with the remedy where it is not.
    pub fn check(&self, file: &File) -> io::Result<()> {
        match Stamp::of(file) {
            Some(now) if now == *self => Ok(()),
            now => Err(io::Error::other(format!(
                "it changed while it was read, {} bytes before and {} after; wait until it is \
                 written, or read a copy",
                self.size,
                now.map_or(0, |now| now.size)
            ))),
        }
    }
}

#[cfg(unix)]
fn place(about: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt as _;

    (about.dev(), about.ino())
}

#[cfg(not(unix))]
fn place(_: &Metadata) -> (u64, u64) {
    (0, 0)
}

#[cfg(test)]
mod tests {
    use std::fs::{self, OpenOptions};
    use std::io::Write as _;

    use super::*;

    #[test]
    fn a_row_more_is_a_change_and_reading_is_none() {
        let path = std::env::temp_dir().join(format!("sesc_stamp_{}", std::process::id()));
        fs::write(&path, "one row\n").unwrap();
        let file = File::open(&path).unwrap();
        let stamp = Stamp::of(&file).unwrap();
        io::read_to_string(&file).unwrap();
        stamp.check(&file).unwrap();
        let mut log = OpenOptions::new().append(true).open(&path).unwrap();
        log.write_all(b"one more\n").unwrap();
        let said = stamp.check(&file).unwrap_err().to_string();
        assert!(said.contains("8 bytes before and 17 after"), "{said}");
        fs::remove_file(path).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_have_no_stamp() {
        assert_eq!(Stamp::of(&File::open("/dev/null").unwrap()), None);
    }
}
