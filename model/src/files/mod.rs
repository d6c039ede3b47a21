//! Files that appear whole or not at all, also when the process is killed.
//!
//! ```text
//! main thread     lock, create, note, unlock … lock, rename, forget, unlock
//! signal thread                              lock, remove what is noted, exit
//! killed                                     the next process sweeps what nobody holds
//! ```
//!
//! A file is written beside its place, brought to the disk, and renamed. Files that belong
//! together take their places while their folders are locked, so that of two processes
//! that write the same pair one has both.

mod parse;
mod places;
mod read;
mod sweep;

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::Error;
use crate::error::Problem;
pub use crate::stamp::Stamp;
pub use parse::{MARKS, TomlFault, parse_toml};
pub use places::Access;
pub use read::{MODEL, PART, SETTINGS, SIDECAR, read_bytes, read_text};

/// Temporary files of this process, and the folders that it swept.
struct Noted {
    temporary: Vec<PathBuf>,
    made: u64,
    swept: BTreeSet<PathBuf>,
}

impl Noted {
    /// Remove what killed processes left in a folder, once.
    fn sweep(&mut self, folder: &Path) {
        if self.swept.insert(folder.to_path_buf()) {
            sweep::sweep(folder);
        }
    }
}

/// The temporary files of this process. A signal ends all of its threads at once, and names of
/// temporary files are unlike within it, since they have its id. A list that front ends
/// hold would have to go through every function that writes a file, and two of them would sweep
/// and rename between each other. Nobody is interrupted while holding the lock.
static NOTED: Mutex<Noted> = Mutex::new(Noted {
    temporary: Vec::new(),
    made: 0,
    swept: BTreeSet::new(),
});

fn noted() -> MutexGuard<'static, Noted> {
    // A list of paths is whole whatever its last holder died of.
    NOTED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file under construction: written beside its place, renamed at the end,
/// removed if dropped before.
pub struct NewFile {
    /// Its name as the user gave it.
    name: PathBuf,
    /// Where it really goes.
    place: PathBuf,
    temporary: PathBuf,
    file: BufWriter<File>,
}

impl NewFile {
    /// Start a file that will become `path`, with the permissions of the file that is there,
    /// else of any new file.
    ///
    /// # Errors
    /// When `path` is a folder, a device or write-protected, or its folder takes no file.
    pub fn create(path: &Path) -> Result<NewFile, Error> {
        let place = places::to_write(path)?;
        let old = fs::metadata(&place).ok().map(|about| about.permissions());
        let folder = folder_of(&place);
        let mut noted = noted();
        noted.sweep(folder);
        let (temporary, file) = loop {
            noted.made += 1;
            let temporary = folder.join(sweep::name(noted.made));
            match File::create_new(&temporary) {
                // Of another process that has this number, in a container of its own.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(failed(path, error)),
                // A sweep may have come between.
                Ok(file) if !sweep::hold(&file, &temporary) => {}
                Ok(file) => break (temporary, file),
            }
        };
        noted.temporary.push(temporary.clone());
        drop(noted);
        let new = NewFile {
            name: path.to_path_buf(),
            place,
            temporary,
            file: BufWriter::new(file),
        };
        if let Some(old) = old {
            let kept = new.file.get_ref().set_permissions(old);
            kept.map_err(|source| failed(path, source))?;
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

    /// Flush everything to the disk before the file gets its final name.
    fn complete(&mut self) -> Result<(), Error> {
        let flushed = self.file.flush();
        let synced = flushed.and_then(|()| self.file.get_ref().sync_all());
        synced.map_err(|source| failed(&self.name, source))
    }

    fn put(&self, noted: &mut Noted) -> Result<(), Error> {
        fs::rename(&self.temporary, &self.place).map_err(|source| failed(&self.name, source))?;
        noted.temporary.retain(|other| *other != self.temporary);
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        let mut noted = noted();
        let own = |other: &PathBuf| *other == self.temporary;
        if let Some(at) = noted.temporary.iter().position(own) {
            noted.temporary.swap_remove(at);
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
pub fn write_unsynced(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Error> {
    let mut file = begun(path, contents)?;
    let flushed = file.flush();
    flushed.map_err(|source| failed(path, source))?;
    let mut noted = noted();
    let put = file.put(&mut noted);
    // A file that is dropped takes the lock itself.
    drop(noted);
    put
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

/// Move files that belong together to their places: none before all are on the disk, and
/// no other process that does so in these folders comes between.
///
/// # Errors
/// When one cannot be written to its end; the files are as they were.
pub fn finish_together(files: Vec<NewFile>) -> Result<(), Error> {
    let folders: Vec<PathBuf> = files
        .iter()
        .map(|file| folder_of(&file.place).to_path_buf())
        .collect();
    put_together(files, &lock(folders))
}

/// Does what [`finish_together`] does, in folders that are locked.
fn put_together(mut files: Vec<NewFile>, locked: &[File]) -> Result<(), Error> {
    files.iter_mut().try_for_each(NewFile::complete)?;
    let mut noted = noted();
    let put = files.iter().try_for_each(|file| file.put(&mut noted));
    // Files that are dropped take the lock themselves.
    drop(noted);
    // The names, too, where a folder can be asked for it.
    locked.iter().for_each(|folder| drop(folder.sync_all()));
    put
}

/// Write files that belong together, in folders that are made for them: none takes its
/// place before all are on the disk, and what would not change is not touched. Returns
/// which of them changed.
///
/// # Errors
/// When a folder or file cannot be written; the files are as they were.
pub fn write_all_if_changed(files: &[(PathBuf, String)]) -> Result<Vec<bool>, Error> {
    let mut places = Vec::with_capacity(files.len());
    for (path, _) in files {
        let place = places::to_write(path)?;
        fs::create_dir_all(folder_of(&place)).map_err(|source| failed(path, source))?;
        // Also where no file will change.
        noted().sweep(folder_of(&place));
        places.push(place);
    }
    let locked = lock(places.iter().map(|place| folder_of(place).to_path_buf()));
    let same =
        |place: &PathBuf, text: &str| fs::read(place).is_ok_and(|old| old == text.as_bytes());
    let mut changed = Vec::with_capacity(files.len());
    let mut new = Vec::new();
    for ((path, text), place) in files.iter().zip(&places) {
        changed.push(!same(place, text));
        if changed.last() == Some(&true) {
            new.push(begun(path, text)?);
        }
    }
    put_together(new, &locked)?;
    Ok(changed)
}

/// Remove what killed processes left in a folder and in the folders in it, so many deep: for
/// folders of which a run may find every file as it should be, and so write none.
pub fn sweep_below(folder: &Path, deep: u32) {
    noted().sweep(folder);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let folders = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    for inner in folders.filter(|_| deep > 0) {
        sweep_below(&inner.path(), deep - 1);
    }
}

/// Folders that no other process holds while they are held; those that cannot be locked
/// (some network drives) are left out.
fn lock(folders: impl IntoIterator<Item = PathBuf>) -> Vec<File> {
    // In one order everywhere, and each once.
    let folders: BTreeSet<PathBuf> = folders.into_iter().collect();
    let held = folders.iter().filter_map(|folder| File::open(folder).ok());
    held.inspect(|folder| drop(folder.lock())).collect()
}

/// The folder of a file.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Remove every file that is not in its place yet and end the process: no file is begun
/// or renamed any more.
pub fn abandon(exit_code: i32) -> ! {
    let noted = noted();
    for path in &noted.temporary {
        let _ = fs::remove_file(path);
    }
    std::process::exit(exit_code)
}

/// An error about writing `path`.
pub fn failed(path: &Path, source: io::Error) -> Error {
    let file = path.display().to_string();
    Problem::Write { file, source }.into()
}

#[cfg(test)]
mod tests;
