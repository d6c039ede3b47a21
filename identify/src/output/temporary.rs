//! Temporary files that go with the command, also when it is interrupted.
//!
//! ```text
//! main thread     lock, create, note, unlock … lock, rename, forget, unlock
//! signal thread                              lock, remove what is noted, exit
//! ```

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, TempPath};

/// Temporary files there are. Nobody is interrupted while holding the lock.
static NOTED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn noted() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list of paths is whole whatever its last holder died of.
    NOTED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The place of a temporary file; the file is removed with it.
pub struct Temporary(Option<TempPath>);

impl Temporary {
    /// A new file in `folder`, with the permissions of any new file.
    pub fn create(folder: &Path) -> io::Result<(File, Temporary)> {
        let mut noted = noted();
        // Errors of `NamedTempFile::new_in` speak of a name that nobody gave.
        let file = Builder::new().make_in(folder, |path| File::create_new(path))?;
        let (file, path) = file.into_parts();
        noted.push(path.to_path_buf());
        Ok((file, Temporary(Some(path))))
    }

    /// Move the file to `place`.
    pub fn persist(mut self, place: &Path) -> io::Result<()> {
        let mut noted = noted();
        let Some(path) = self.0.take() else {
            return Ok(());
        };
        noted.retain(|other| other != &*path);
        path.persist(place).map_err(|failure| failure.error)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(path) = self.0.take() {
            let mut noted = noted();
            noted.retain(|other| other != &*path);
            drop(path);
        }
    }
}

/// Run `work`, which is quick, to its end before any interruption.
pub fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    let _noted = noted();
    work()
}

/// Have SIGINT (Ctrl-C) and SIGTERM end this process without leftovers, by the
/// exit codes of a shell: 130 and 143.
#[cfg(unix)]
pub fn tidy_when_interrupted() -> io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals = Signals::new([SIGINT, SIGTERM])?;
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            // Held until the process is gone: no file is begun or renamed any more.
            let noted = noted();
            for path in &*noted {
                // Nobody is left to tell of a file that stays.
                let _ = std::fs::remove_file(path);
            }
            std::process::exit(128 + signal);
        }
    };
    std::thread::Builder::new().spawn(wait).map(drop)
}

/// Elsewhere files stay where a command is ended from outside.
#[cfg(not(unix))]
pub fn tidy_when_interrupted() -> io::Result<()> {
    Ok(())
}
