//! Files that appear whole or not at all, also when the process is killed.
//!
//! ```text
//! main thread     lock, create, note, unlock … lock, rename, forget, unlock
//! signal thread                              lock, remove what is noted, exit
//! ```
//!
//! A file is written beside its place, brought to the disk, and renamed. Files that belong
//! together take their places while their folders are locked, so that of two processes that
//! write the same pair one has both.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use sesc_model::Error;
pub use sesc_model::files::failed;
use sesc_model::files::{self, folder_of, lock_folders, sync_folders, to_write};
use tempfile::NamedTempFile;

/// Files of this process that are not in their places yet: a signal ends all of its threads at
/// once. Nobody is interrupted while holding the lock.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    // A list of paths is whole whatever its last holder died of.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file under construction: written beside its place, renamed at the end, removed if dropped
/// before.
pub struct NewFile {
    /// Its name as the user gave it.
    name: PathBuf,
    /// Where it really goes.
    place: PathBuf,
    /// None once it is in its place.
    file: Option<BufWriter<NamedTempFile>>,
}

impl NewFile {
    /// Start a file that will become `path`, with the permissions of the file that is there,
    /// else of any new file.
    ///
    /// # Errors
    /// When `path` is a folder, a device or write-protected, or its folder takes no file.
    pub fn create(path: &Path) -> Result<NewFile, Error> {
        let place = to_write(path)?;
        let refused = |source| failed(path, source);
        let mut builder = tempfile::Builder::new();
        builder.prefix(".sesc-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // The system takes away what the user's mask forbids.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let mut unfinished = unfinished();
        let file = builder.tempfile_in(folder_of(&place)).map_err(refused)?;
        unfinished.push(file.path().to_path_buf());
        drop(unfinished);
        let old = fs::metadata(&place).ok().map(|about| about.permissions());
        let new = NewFile {
            name: path.to_path_buf(),
            place,
            file: Some(BufWriter::new(file)),
        };
        if let (Some(old), Some(file)) = (old, &new.file) {
            let kept = file.get_ref().as_file().set_permissions(old);
            kept.map_err(refused)?;
        }
        Ok(new)
    }

    /// Move the file to its place.
    ///
    /// # Errors
    /// When it cannot be written to its end or renamed.
    pub fn finish(self) -> Result<(), Error> {
        finish_together(vec![self])
    }

    fn open(&mut self) -> io::Result<&mut BufWriter<NamedTempFile>> {
        let closed = || io::Error::other("it is in its place");
        self.file.as_mut().ok_or_else(closed)
    }

    fn put(&mut self, unfinished: &mut Vec<PathBuf>) -> Result<(), Error> {
        let Some(file) = self.file.take() else {
            return Ok(());
        };
        let refused = |source| failed(&self.name, source);
        let file = file
            .into_inner()
            .map_err(|error| refused(error.into_error()))?;
        let temporary = file.path().to_path_buf();
        // Where it cannot be renamed it is removed.
        let put = file.persist(&self.place);
        unfinished.retain(|other| *other != temporary);
        put.map(drop).map_err(|error| refused(error.error))
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut unfinished = unfinished();
            // What is buffered is of no use.
            let (file, _) = file.into_parts();
            unfinished.retain(|other| other != file.path());
            drop(file);
        }
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.open()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.open()?.flush()
    }
}

/// Write a whole file.
///
/// # Errors
/// When the file cannot be written; nothing half-written stays.
pub fn write(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    begun(path, contents)?.finish()
}

/// Write a whole file that can be made again: nobody ever reads half of it, but it does not wait
/// for the disk, and a power failure may leave an empty or damaged file in its place.
///
/// # Errors
/// When the file cannot be written; nothing half-written stays.
pub(crate) fn write_unsynced(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    begun(path, contents)?.put(&mut unfinished())
}

/// A file with these contents, not yet in its place.
///
/// # Errors
/// When the file cannot be written.
pub fn begun(path: &Path, contents: impl AsRef<[u8]>) -> Result<NewFile, Error> {
    let mut file = NewFile::create(path)?;
    file.write_all(contents.as_ref())
        .map_err(|source| failed(path, source))?;
    Ok(file)
}

/// Move files that belong together to their places: none before all are on the disk, and no other
/// process that does so in these folders comes between.
///
/// # Errors
/// When one cannot be written to its end; the files are as they were.
pub fn finish_together(mut files: Vec<NewFile>) -> Result<(), Error> {
    for new in &mut files {
        let flushed = new.flush();
        let synced = flushed.and_then(|()| new.open()?.get_ref().as_file().sync_all());
        synced.map_err(|source| failed(&new.name, source))?;
    }
    let places: Vec<PathBuf> = files.iter().map(|file| file.place.clone()).collect();
    let mut unfinished = unfinished();
    let locked = lock_folders(&places);
    let put = files
        .iter_mut()
        .try_for_each(|file| file.put(&mut unfinished));
    // Files that are dropped take the lock themselves.
    drop(unfinished);
    sync_folders(&locked);
    put
}

/// [`sesc_model::files::write_all_if_changed`], which [`abandon`] waits for.
///
/// # Errors
/// When a folder or file cannot be written; the files are as they were.
pub fn write_all_if_changed(files: &[(PathBuf, String)]) -> Result<Vec<bool>, Error> {
    let _undisturbed = unfinished();
    files::write_all_if_changed(files)
}

/// Remove every file that is not in its place yet and end the process: no file is begun or renamed
/// any more.
pub fn abandon(exit_code: i32) -> ! {
    let unfinished = unfinished();
    for path in unfinished.iter() {
        // What is left can no longer be reported.
        let _ = fs::remove_file(path);
    }
    std::process::exit(exit_code)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<_> = entries.map(name).collect();
        names.sort();
        let name = |name: std::ffi::OsString| name.into_string().unwrap();
        names.into_iter().map(name).collect()
    }

    #[test]
    fn a_file_appears_when_it_is_finished_and_leaves_nothing_when_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write(&path, "old").unwrap();
        let mut file = NewFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        drop(file);
        assert_eq!(names(folder.path()), ["a.txt"]);
        for text in ["new", "newer, and longer", ""] {
            write(&path, text).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            write_unsynced(&path, text.repeat(2)).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text.repeat(2));
        }
        let error = write(folder.path(), "text").unwrap_err();
        assert!(format!("{error:?}").contains("no regular file"));
        assert!(write(&folder.path().join("none/a.txt"), "text").is_err());
        assert_eq!(names(folder.path()), ["a.txt"]);
        // A folder came in its place meanwhile: the pair stays out, and nothing is left.
        let pair = ["b.txt", "c.txt"].map(|name| folder.path().join(name));
        let begun = pair.each_ref().map(|path| begun(path, "text").unwrap());
        fs::create_dir_all(pair[0].join("inner")).unwrap();
        assert!(finish_together(begun.into()).is_err());
        assert_eq!(names(folder.path()), ["a.txt", "b.txt"]);
        assert!(
            unfinished()
                .iter()
                .all(|path| !path.starts_with(folder.path()))
        );
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_permissions_are_kept_or_those_of_any_new_file() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};

        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
        fs::write(at("any"), "").unwrap();
        write(&at("new"), "").unwrap();
        assert_eq!(mode("new"), mode("any"));
        for kept in [0o600, 0o640, 0o666, 0o755] {
            fs::set_permissions(at("any"), fs::Permissions::from_mode(kept)).unwrap();
            write(&at("any"), "text").unwrap();
            assert_eq!(mode("any"), kept);
        }
        symlink("any", at("link")).unwrap();
        write(&at("link"), "through").unwrap();
        assert!(at("link").is_symlink());
        assert_eq!(fs::read_to_string(at("any")).unwrap(), "through");
        fs::set_permissions(at("any"), fs::Permissions::from_mode(0o444)).unwrap();
        let error = write(&at("link"), "newer").unwrap_err();
        assert!(
            format!("{error:?}").contains("write-protected"),
            "{error:?}"
        );
        assert_eq!(names(folder.path()), ["any", "link", "new"]);
    }
}
