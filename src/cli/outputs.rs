//! Files of commands: what is read is not written, outputs are asked about before any
//! work, and they are gone when a command is interrupted.

use std::path::{Path, PathBuf};

use sesc_identify::logs::Sidecar;
use sesc_model::files::{self, Access, NewFile};

use super::message;
use crate::Error;

/// The files of a command. Every command that writes names here all that it reads and
/// writes, with the sidecars that belong to logs.
#[derive(Default)]
pub(super) struct Files(Access);

impl Files {
    /// Files that are read, where they are given.
    pub(super) fn reads<'a>(self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        Files(self.0.reads(paths))
    }

    /// A setting that may name a file.
    pub(super) fn may_read<'a>(self, settings: impl IntoIterator<Item = &'a String>) -> Files {
        Files(self.0.reads(settings.into_iter().map(PathBuf::from)))
    }

    /// Logs that are read, and their sidecars: a file that took the place of one would be
    /// read as it from then on.
    pub(super) fn reads_logs<'a>(self, logs: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        logs.into_iter().fold(self, |files, log| {
            let [own, older] = Sidecar::paths(log);
            let is_read = |path: &PathBuf| !own.exists() || *path == own;
            let sidecars: Vec<PathBuf> = [own.clone(), older].into_iter().filter(is_read).collect();
            Files(files.0.reads([log]).reserves(sidecars))
        })
    }

    /// Files that are written, where they are asked for.
    pub(super) fn writes<'a>(self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        Files(self.0.writes(paths))
    }

    /// Logs that are written, and the sidecars that come with them.
    pub(super) fn writes_logs<'a>(self, logs: impl IntoIterator<Item = &'a PathBuf>) -> Files {
        logs.into_iter().fold(self, |files, log| {
            // A log that ends like a sidecar is refused when it is begun.
            let sidecar = Some(Sidecar::path(log)).filter(|path| path != log);
            Files(files.0.writes([log]).writes(sidecar))
        })
    }

    /// Whether all of them can go together, before anything is written.
    ///
    /// # Errors
    /// When a file is read and written, or meant for two outputs.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.0.check().map_err(Error::Usage)
    }

    /// [`Files::check`], and whether every folder takes a file: before long work, not
    /// behind it.
    ///
    /// # Errors
    /// Besides those, a file that cannot be begun.
    pub(super) fn check_writable(&self) -> Result<(), Error> {
        self.check()?;
        let written: &[PathBuf] = self.0.written();
        for path in written.iter().map(Path::new) {
            // A file that is dropped leaves nothing behind.
            drop(NewFile::create(path)?);
        }
        Ok(())
    }
}

/// Files of one result: all of them are on the disk before the first takes its place, so that
/// a command that ends in between leaves those of an earlier run together.
#[derive(Default)]
pub(super) struct Together(Vec<(PathBuf, NewFile)>);

impl Together {
    /// A file with this text, not yet in its place.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(super) fn add(&mut self, path: &Path, text: &str) -> Result<(), Error> {
        self.0.push((path.to_path_buf(), files::begun(path, text)?));
        Ok(())
    }

    /// Move them to their places, and say so.
    ///
    /// # Errors
    /// When one cannot be written to its end.
    pub(super) fn finish(self) -> Result<(), Error> {
        let (paths, new): (Vec<PathBuf>, Vec<NewFile>) = self.0.into_iter().unzip();
        files::finish_together(new)?;
        for path in paths {
            message(&format!("wrote {}", path.display()));
        }
        Ok(())
    }
}

/// Have SIGINT (Ctrl-C) and SIGTERM end this process without unfinished files, by the
/// exit codes of a shell: 130 and 143.
#[cfg(unix)]
pub(super) fn tidy_when_interrupted() -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            sesc_model::files::abandon(128 + signal);
        }
    };
    std::thread::Builder::new().spawn(wait).map(drop)
}

/// Elsewhere files stay where a command is ended from outside.
#[cfg(not(unix))]
pub(super) fn tidy_when_interrupted() -> std::io::Result<()> {
    Ok(())
}
