//! Files that appear whole or not at all, also when the process is interrupted.
//!
//! ```text
//! main thread     lock, create, note, unlock … lock, rename, forget, unlock
//! signal thread                              lock, remove what is noted, exit
//! ```

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::Error;

/// Temporary files there are, and how many were made. Nobody is interrupted while
/// holding the lock.
static NOTED: Mutex<(Vec<PathBuf>, u64)> = Mutex::new((Vec::new(), 0));

type Noted = MutexGuard<'static, (Vec<PathBuf>, u64)>;

fn noted() -> Noted {
    // A list of paths is whole whatever its last holder died of.
    NOTED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file under construction: written beside its place, renamed at the end,
/// removed if dropped before.
pub struct NewFile {
    /// As the user calls it.
    name: PathBuf,
    /// Where it really goes.
    place: PathBuf,
    temporary: PathBuf,
    file: BufWriter<File>,
}

impl NewFile {
    /// Start a file that will become `path`, with the permissions of any new file.
    ///
    /// # Errors
    /// When `path` is a folder or device, or its folder takes no file.
    pub fn create(path: &Path) -> Result<NewFile, Error> {
        // Renaming would replace a link or a device itself, not what it stands for.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if place.exists() && !place.is_file() {
            let reason = "it is no regular file; give the name of a file to write";
            return Err(failed(path, io::Error::other(reason)));
        }
        let folder = place.parent().unwrap_or(Path::new(""));
        let mut noted = noted();
        let (temporary, file) = loop {
            noted.1 += 1;
            let own = format!(".sesc-{}-{}.part", std::process::id(), noted.1);
            let temporary = folder.join(own);
            match File::create_new(&temporary) {
                // A leftover of another process that had this number.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(path, error)),
                Ok(file) => break (temporary, BufWriter::new(file)),
            }
        };
        noted.0.push(temporary.clone());
        Ok(NewFile {
            name: path.to_path_buf(),
            place,
            temporary,
            file,
        })
    }

    /// Move the file to its place.
    ///
    /// # Errors
    /// When it cannot be written to its end or renamed.
    pub fn finish(mut self) -> Result<(), Error> {
        self.complete()?;
        self.put(&mut noted())
    }

    fn complete(&mut self) -> Result<(), Error> {
        self.file
            .flush()
            .map_err(|source| failed(&self.name, source))
    }

    fn put(&self, noted: &mut Noted) -> Result<(), Error> {
        fs::rename(&self.temporary, &self.place).map_err(|source| failed(&self.name, source))?;
        noted.0.retain(|other| *other != self.temporary);
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        let mut noted = noted();
        if let Some(at) = noted.0.iter().position(|other| *other == self.temporary) {
            noted.0.swap_remove(at);
            // A file that cannot be removed here can no longer be reported.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Write a whole text.
///
/// # Errors
/// When the file cannot be written; nothing half-written stays.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    written(path, text)?.finish()
}

fn written(path: &Path, text: &str) -> Result<NewFile, Error> {
    let mut file = NewFile::create(path)?;
    file.write_all(text.as_bytes())
        .map_err(|source| failed(path, source))?;
    file.complete()?;
    Ok(file)
}

/// Write files that belong together, in folders that are made for them: none takes its
/// place before all are on the disk, and what would not change is not touched. Returns
/// which of them changed.
///
/// # Errors
/// When a folder or file cannot be written; the files are as they were.
pub fn write_all_if_changed(files: &[(PathBuf, String)]) -> Result<Vec<bool>, Error> {
    let new = |(path, text): &(PathBuf, String)| {
        if fs::read(path).is_ok_and(|old| old == text.as_bytes()) {
            return Ok(None);
        }
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|source| failed(path, source))?;
        }
        written(path, text).map(Some)
    };
    let new: Vec<Option<NewFile>> = files.iter().map(new).collect::<Result<_, Error>>()?;
    let mut noted = noted();
    let put = new
        .iter()
        .flatten()
        .try_for_each(|file| file.put(&mut noted));
    // Files that are dropped take the lock themselves.
    drop(noted);
    put.map(|()| new.iter().map(Option::is_some).collect())
}

/// Remove every file that is not in its place yet and end the process: no file is begun
/// or renamed any more.
pub fn abandon(exit_code: i32) -> ! {
    let noted = noted();
    for path in &noted.0 {
        let _ = fs::remove_file(path);
    }
    std::process::exit(exit_code)
}

/// An error about writing `path`.
pub fn failed(path: &Path, source: io::Error) -> Error {
    Error::Write {
        file: path.display().to_string(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own for a test, removed with it.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Folder {
            let own = format!("sesc-files-{}-{name}", std::process::id());
            let folder = std::env::temp_dir().join(own);
            fs::create_dir_all(&folder).unwrap();
            Folder(folder)
        }

        fn names(&self) -> Vec<String> {
            let entries = fs::read_dir(&self.0).unwrap();
            let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
            let mut names: Vec<_> = entries.map(name).collect();
            names.sort();
            names
                .into_iter()
                .map(|name| name.into_string().unwrap())
                .collect()
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_file_appears_when_it_is_finished_and_leaves_nothing_when_dropped() {
        let folder = Folder::new("whole");
        let path = folder.0.join("a.txt");
        write(&path, "old").unwrap();
        let mut file = NewFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        drop(file);
        assert_eq!(folder.names(), ["a.txt"]);
        write(&path, "new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        let error = write(&folder.0, "text").unwrap_err();
        assert!(format!("{error:?}").contains("no regular file"));
        assert!(write(&folder.0.join("none/a.txt"), "text").is_err());
        assert_eq!(folder.names(), ["a.txt"]);
    }

    #[test]
    fn files_that_belong_together_appear_together() {
        let folder = Folder::new("together");
        let file = |name: &str, text: &str| (folder.0.join(name), text.to_string());
        let both = [file("new/a.c", "1"), file("new/a.h", "2")];
        assert_eq!(write_all_if_changed(&both).unwrap(), [true, true]);
        let one = [file("new/a.c", "1"), file("new/a.h", "3")];
        assert_eq!(write_all_if_changed(&one).unwrap(), [false, true]);
        // A folder in the place of the second: the first stays as it was.
        let bad = [file("new/a.c", "4"), file("new", "5")];
        assert!(write_all_if_changed(&bad).is_err());
        assert_eq!(fs::read_to_string(folder.0.join("new/a.c")).unwrap(), "1");
        assert_eq!(fs::read_dir(folder.0.join("new")).unwrap().count(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = Folder::new("link");
        let link = folder.0.join("link");
        write(&folder.0.join("a.txt"), "old").unwrap();
        std::os::unix::fs::symlink(folder.0.join("a.txt"), &link).unwrap();
        write(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(fs::read_to_string(folder.0.join("a.txt")).unwrap(), "new");
    }
}
