//! Files that are read whole, up to a stated size, and that do not change while they are read.

use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::path::Path;
use std::time::SystemTime;

/// Largest file of a log's sidecar, MiB: it is a page.
pub const SIDECAR: u64 = 1;
/// Largest file of settings, MiB: joint limits, servos and soles have a line per joint or
/// corner, of which a robot has a thousand at most.
pub const SETTINGS: u64 = 4;
/// Largest model file and prior, MiB. Their numbers grow with the square of the parameters: a
/// model file with the sums of its fit has 10 MB for a robot of 500 joints, 90 kB for one of 40.
pub const MODEL: u64 = 16;
/// Largest factor file, MiB: sums of ten parts of a log, in numbers of eight bytes, which for a
/// robot of 1000 joints are 320 MB.
pub const PART: u64 = 512;

/// The text of a file of at most `mebibytes`: what is longer is another file, or a device
/// without an end.
///
/// # Errors
/// When it cannot be read, is longer, is no UTF-8, or changes while it is read.
pub fn read_text(path: &Path, mebibytes: u64) -> io::Result<String> {
    String::from_utf8(read_bytes(path, mebibytes)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is no text in UTF-8"))
}

/// The bytes of a file of at most `mebibytes`.
///
/// # Errors
/// When it cannot be read, is longer, or changes while it is read.
pub fn read_bytes(path: &Path, mebibytes: u64) -> io::Result<Vec<u8>> {
    let most = mebibytes << 20;
    let mut bytes = Vec::new();
    let file = File::open(path)?;
    let stamp = Stamp::of(&file);
    (&file).take(most + 1).read_to_end(&mut bytes)?;
    stamp.map_or(Ok(()), |stamp| stamp.check(&file))?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other(format!(
            "it is longer than {mebibytes} MiB, more than such a file can need"
        )));
    }
    Ok(bytes)
}

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
