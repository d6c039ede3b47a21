//! Files that appear whole or not at all.

mod temporary;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::Error;
use temporary::Temporary;
pub use temporary::{tidy_when_interrupted, undisturbed};

/// A file under construction: written beside its target, renamed at the end,
/// removed if dropped before.
pub struct NewFile {
    /// As the user calls it.
    name: PathBuf,
    /// Where it really goes.
    place: PathBuf,
    file: BufWriter<File>,
    temporary: Temporary,
}

impl NewFile {
    /// Start a file that will become `path`.
    pub fn create(path: &Path) -> Result<NewFile, Error> {
        // Renaming would replace a link or a device itself, not what it stands for.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if place.exists() && !place.is_file() {
            return Err(Error::request(format!(
                "{} is no regular file; give the name of a file to write",
                path.display()
            )));
        }
        let folder = match place.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let (file, temporary) = Temporary::create(folder).map_err(|source| failed(path, source))?;
        Ok(NewFile {
            name: path.to_path_buf(),
            place,
            file: BufWriter::new(file),
            temporary,
        })
    }

    /// Move the file to its place.
    pub fn finish(mut self) -> Result<(), Error> {
        let failed = |source| failed(&self.name, source);
        self.file.flush().map_err(failed)?;
        self.temporary.persist(&self.place).map_err(failed)
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
            return Err(Error::request(format!(
                "{} is read here; give the output another name",
                path.display()
            )));
        }
        if written[..k].iter().any(|other| place(other) == here) {
            return Err(Error::request(format!(
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
    Error::write(path.display().to_string(), source)
}
