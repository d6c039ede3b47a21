//! Files that are read whole, up to a stated size, and that do not change while they are read.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Component, Path, PathBuf};

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

/// The text of a file that nobody typed: it was found, or another file names it.
///
/// # Errors
/// As of [`read_text`], and when it is no regular file: opening a pipe waits until it is written,
/// and a device may have no end.
pub fn read_found_text(path: &Path, mebibytes: u64) -> io::Result<String> {
    check_regular(path)?;
    read_text(path, mebibytes)
}

/// The bytes of a file that nobody typed.
///
/// # Errors
/// As of [`read_bytes`], and when it is no regular file.
pub fn read_found(path: &Path, mebibytes: u64) -> io::Result<Vec<u8>> {
    check_regular(path)?;
    read_bytes(path, mebibytes)
}

/// Whether a file that nobody typed may be opened.
///
/// # Errors
/// When it is not there, or no regular file.
pub fn check_regular(path: &Path) -> io::Result<()> {
    let about = fs::metadata(path)?;
    let what = match (about.is_file(), about.is_dir()) {
        (true, _) => return Ok(()),
        (false, true) => "it is a folder",
        (false, false) => "it is a pipe or a device, where a regular file is read",
    };
    Err(io::Error::other(what))
}

/// The place of a file that a file in `folder` names.
///
/// # Errors
/// When it is not in the folder, by its name or by a link, or no regular file.
pub fn named_in(folder: &Path, name: &str) -> io::Result<PathBuf> {
    let folder = match folder.as_os_str().is_empty() {
        true => Path::new("."),
        false => folder,
    };
    let place = folder.join(name);
    let mut parts = Path::new(name).components();
    let mut is_within = parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if is_within && place.exists() {
        is_within = fs::canonicalize(&place)?.starts_with(fs::canonicalize(folder)?);
        check_regular(&place)?;
    }
    match is_within {
        true => Ok(place),
        false => Err(io::Error::other(
            "it is outside the folder of the file that names it",
        )),
    }
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
