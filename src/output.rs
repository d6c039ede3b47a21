//! Files that appear whole or not at all.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::Error;

/// A file under construction: written beside its target, renamed at the end,
/// removed if dropped before.
pub struct NewFile {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
}

impl NewFile {
    /// Start a file that will become `path`.
    pub fn create(path: &Path) -> Result<NewFile, Error> {
        // Renaming would replace a link or a device itself, not what it stands for.
        let path = &std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if path.exists() && !path.is_file() {
            return Err(Error::Usage(format!(
                "{} is no regular file; give the name of a file to write",
                path.display()
            )));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let file = NamedTempFile::new_in(folder).map_err(|source| failed(path, source))?;
        Ok(NewFile {
            path: path.to_path_buf(),
            file: BufWriter::new(file),
        })
    }

    /// Move the file to its place, readable like any other new file.
    pub fn finish(self) -> Result<(), Error> {
        let path = self.path;
        let file = self
            .file
            .into_inner()
            .map_err(|error| failed(&path, error.into_error()))?;
        file.persist(&path)
            .map_err(|error| failed(&path, error.error))?;
        // Temporary files are private; a result is for everyone the folder is for.
        open_to_readers(&path).map_err(|source| failed(&path, source))
    }
}

/// Whether `written` may be written beside what is `read`.
///
/// # Errors
/// When a file is both, is meant twice, or its folder takes no file.
pub fn check(read: &[PathBuf], written: &[&PathBuf]) -> Result<(), Error> {
    let place = |path: &Path| match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => {
            let folder = match folder.as_os_str().is_empty() {
                true => Path::new("."),
                false => folder,
            };
            let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
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

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

/// Write a whole text.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    let mut file = NewFile::create(path)?;
    file.write_all(text.as_bytes())
        .map_err(|source| failed(path, source))?;
    file.finish()
}

/// An error about writing `path`.
pub fn failed(path: &Path, source: std::io::Error) -> Error {
    Error::Write {
        file: path.display().to_string(),
        source,
    }
}

#[cfg(unix)]
fn open_to_readers(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    fs::set_permissions(path, fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn open_to_readers(_: &Path) -> std::io::Result<()> {
    Ok(())
}
