//! Which build writes a [`Recording`], and how.

use std::path::Path;

use crate::files::NewFile;

use super::recording::Recording;
use crate::{Error, Watch};

/// What begins a file with a recording, whose postures have these stamps, ns.
type Begin = fn(&Recording, &[u64], &Path, &mut dyn Watch) -> Result<NewFile, Error>;

#[cfg(feature = "mcap")]
fn writer(_: &Path) -> Result<Begin, Error> {
    Ok(super::mcap::begun)
}

#[cfg(not(feature = "mcap"))]
fn writer(path: &Path) -> Result<Begin, Error> {
    Err(Error::without("mcap", "MCAP", &path.display().to_string()))
}

impl Recording {
    /// Whether this build can write one.
    ///
    /// # Errors
    /// Where the format is left out, naming the file that was asked for.
    pub fn check_format(path: &Path) -> Result<(), Error> {
        writer(path).map(drop)
    }

    /// The recording as a file, not yet in its place.
    ///
    /// # Errors
    /// Times that stamps do not hold, a file that cannot be written,
    /// [`check_format`](Self::check_format), and the kind `Interrupted` where `watch` stops it.
    pub fn begun(&self, path: &Path, watch: &mut dyn Watch) -> Result<NewFile, Error> {
        writer(path)?(self, &self.stamps()?, path, watch)
    }
}
