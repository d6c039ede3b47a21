//! Outputs of commands: asked about before any work, gone when a command is interrupted.

use std::path::{Path, PathBuf};

use sesc_model::files::NewFile;

use crate::Error;

/// Whether `written` may be written beside what is `read`.
///
/// # Errors
/// When a file is both, is meant twice, or its folder takes no file.
pub(super) fn check(read: &[PathBuf], written: &[&PathBuf]) -> Result<(), Error> {
    let place = |path: &Path| match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => {
            let folder = match folder.as_os_str().is_empty() {
                true => Path::new("."),
                false => folder,
            };
            let whole = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
            whole.join(name)
        }
        _ => path.to_path_buf(),
    };
    for (k, path) in written.iter().enumerate() {
        let here = place(path);
        if read
            .iter()
            .any(|other| place(other) == here && other.exists())
        {
            return Err(Error::Usage(format!(
                "{} is read here; give the output another name",
                path.display()
            )));
        }
        if written[..k].iter().any(|other| place(other) == here) {
            return Err(Error::Usage(format!(
                "{} is meant for two outputs; give each a name of its own",
                path.display()
            )));
        }
        // A file that is dropped leaves nothing behind.
        drop(NewFile::create(path)?);
    }
    Ok(())
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
