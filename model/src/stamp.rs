//! Files that change while they are read.

use std::fs::{File, Metadata};
use std::io;
use std::time::SystemTime;

/// What tells that a regular file was changed.
///
/// What is read of a file that somebody writes to is neither what it was nor what it becomes,
/// and may look whole. A file is therefore asked for its size and the time of its last change
/// before the first byte and after the last one. Where the system keeps the time of any change
/// to a file, that one tells, too: a program may put back the time of its last writing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    size: u64,
    modified: Option<SystemTime>,
    /// Device and number, zeros where there are none: another file may be put in its place.
    place: (u64, u64),
    /// How many names it has.
    names: u64,
    /// When anything of it was changed: s, and ns beyond.
    changed: (i64, i64),
}

impl Stamp {
    /// The stamp of an open file; none of a pipe or a device, which have no state to keep.
    pub fn of(file: &File) -> Option<Stamp> {
        let about = file.metadata().ok()?;
        let (place, names, changed) = unix(&about);
        about.is_file().then(|| Stamp {
            size: about.len(),
            modified: about.modified().ok(),
            place,
            names,
            changed,
        })
    }

    /// Whether the file is what it was.
    ///
    /// # Errors
    /// A sentence with the remedy where it is not.
    pub fn check(&self, file: &File) -> io::Result<()> {
        let mut now = Stamp::of(file);
        if let Some(now) = now.as_mut().filter(|now| now.names != self.names) {
            // A name more or less is noted as a change, and is none of what the file holds.
            (now.names, now.changed) = (self.names, self.changed);
        }
        if now.as_ref() == Some(self) {
            return Ok(());
        }
        Err(io::Error::other(format!(
            "it changed while it was read, {} bytes before and {} after; wait until it is \
             written, or read a copy",
            self.size,
            now.map_or(0, |now| now.size)
        )))
    }
}

#[cfg(unix)]
fn unix(about: &Metadata) -> ((u64, u64), u64, (i64, i64)) {
    use std::os::unix::fs::MetadataExt as _;

    let place = (about.dev(), about.ino());
    (place, about.nlink(), (about.ctime(), about.ctime_nsec()))
}

#[cfg(not(unix))]
fn unix(_: &Metadata) -> ((u64, u64), u64, (i64, i64)) {
    Default::default()
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
    fn a_time_of_writing_that_is_put_back_hides_no_change() {
        let path = std::env::temp_dir().join(format!("sesc_put_back_{}", std::process::id()));
        fs::write(&path, "0.010\n").unwrap();
        let file = File::open(&path).unwrap();
        let stamp = Stamp::of(&file).unwrap();
        let modified = file.metadata().unwrap().modified().unwrap();
        let mut log = OpenOptions::new().write(true).open(&path).unwrap();
        // The clock of a file system ticks every few milliseconds.
        std::thread::sleep(std::time::Duration::from_millis(30));
        log.write_all(b"0.020\n").unwrap();
        log.set_modified(modified).unwrap();
        assert_eq!(Stamp::of(&file).unwrap().modified, stamp.modified);
        stamp.check(&file).unwrap_err();
        // A name more is none.
        let stamp = Stamp::of(&file).unwrap();
        let other = path.with_extension("link");
        std::thread::sleep(std::time::Duration::from_millis(30));
        fs::hard_link(&path, &other).unwrap();
        stamp.check(&file).unwrap();
        fs::remove_file(other).unwrap();
        fs::remove_file(path).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_have_no_stamp() {
        assert_eq!(Stamp::of(&File::open("/dev/null").unwrap()), None);
    }
}
