//! Files that are read whole, up to a stated size, and that do not change while they are read.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use crate::stamp::Stamp;

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
