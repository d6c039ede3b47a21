//! Temporary files: held by the process that writes them, swept by the next one if it died.
//!
//! A file is locked as long as its process lives; the system lets go of it however the
//! process ends. A sweep removes what it can lock itself. It may come between the making
//! of a file and its lock, so that a file is looked for again once it is locked.

use std::fs::{self, File};
use std::path::Path;

/// Around the numbers in the names of temporary files.
const BEGINS: &str = ".sesc-";
const ENDS: &str = ".part";

/// A name for the temporary file number `k` of this process.
pub(super) fn name(k: u64) -> String {
    format!("{BEGINS}{}-{k}{ENDS}", std::process::id())
}

/// Hold a temporary file that was just made; whether it is still there.
pub(super) fn hold(file: &File, path: &Path) -> bool {
    // Without locks (some network drives) nothing is swept either.
    file.lock().is_err() || is_at(file, path)
}

#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;

    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(own), Ok(there)) => (own.dev(), own.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Remove temporary files of processes that were killed.
pub(super) fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_ours = |name: &str| {
            let between = name.strip_prefix(BEGINS).and_then(|n| n.strip_suffix(ENDS));
            between.is_some_and(|n| n.chars().all(|c| c.is_ascii_digit() || c == '-'))
        };
        // A link of this name is nobody's temporary file.
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !name.to_str().is_some_and(is_ours) {
            continue;
        }
        let path = entry.path();
        if let Ok(file) = File::open(&path)
            && file.try_lock().is_ok()
        {
            // If it cannot be removed, it stays.
            let _ = fs::remove_file(path);
        }
    }
}
