//! Files that appear whole or not at all, where their names lead; and texts that others wrote.
//!
//! ```text
//! folders locked ─▶ what differs is written beside its place ─▶ on the disk ─▶ renamed
//! ```
//!
//! Files that belong together take their places while their folders are locked, so that of two
//! processes that write the same pair one has both. What is read may have been given through a
//! link, a relative path or a descriptor (`/dev/stdin`); what is written goes where its name
//! leads. Both are compared as the system resolves them.

mod parse;
mod read;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use crate::Error;
use crate::error::Problem;
pub use crate::stamp::Stamp;
pub use parse::{MARKS, TomlFault, parse_toml};
pub use read::{
    MODEL, PART, SETTINGS, SIDECAR, check_regular, named_in, read_bytes, read_found,
    read_found_text, read_text,
};

/// Write files that belong together, in folders that are made for them: none takes its place
/// before all are on the disk, and what would not change is not touched. Returns which of them
/// changed.
///
/// # Errors
/// When a folder or file cannot be written; the files are as they were.
pub fn write_all_if_changed(files: &[(PathBuf, String)]) -> Result<Vec<bool>, Error> {
    let mut places = Vec::with_capacity(files.len());
    for (path, _) in files {
        let place = to_write(path)?;
        fs::create_dir_all(folder_of(&place)).map_err(|source| failed(path, source))?;
        places.push(place);
    }
    let locked = lock_folders(&places);
    let mut changed = Vec::with_capacity(files.len());
    let mut begun = Vec::new();
    for ((path, text), place) in files.iter().zip(&places) {
        let same = fs::read(place).is_ok_and(|old| old == text.as_bytes());
        changed.push(!same);
        if !same {
            let file = Beside::new(place, text).map_err(|source| failed(path, source))?;
            begun.push((path, file, place));
        }
    }
    for (path, file, place) in begun {
        let renamed = fs::rename(&file.0, place);
        renamed.map_err(|source| failed(path, source))?;
    }
    sync_folders(&locked);
    Ok(changed)
}

/// A file beside its place; removed when dropped, unless it was renamed.
struct Beside(PathBuf);

impl Beside {
    /// A file with this text on the disk, with the permissions of what is at `place`.
    fn new(place: &Path, text: &str) -> io::Result<Beside> {
        let (folder, own) = (folder_of(place), std::process::id());
        let mut names = (0u64..).map(|k| folder.join(format!(".sesc-{own}-{k}.part")));
        let (path, mut file) = loop {
            // An endless range.
            let path = names.next().unwrap_or_default();
            match File::create_new(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                made => break (path, made?),
            }
        };
        let beside = Beside(path);
        if let Ok(old) = fs::metadata(place) {
            file.set_permissions(old.permissions())?;
        }
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        Ok(beside)
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // After the rename there is none, and the folders are locked.
        let _ = fs::remove_file(&self.0);
    }
}

/// The folders of files, which no other process holds while they are held; those that cannot be
/// locked (some network drives) are left out.
pub fn lock_folders(files: &[PathBuf]) -> Vec<File> {
    // In one order everywhere, and each once.
    let folders: BTreeSet<&Path> = files.iter().map(|file| folder_of(file)).collect();
    let held = folders.iter().filter_map(|folder| File::open(folder).ok());
    held.inspect(|folder| drop(folder.lock())).collect()
}

/// Bring the names in folders to the disk, where a folder can be asked for it.
pub fn sync_folders(folders: &[File]) {
    folders.iter().for_each(|folder| drop(folder.sync_all()));
}

/// The folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// An error about writing `path`.
pub fn failed(path: &Path, source: io::Error) -> Error {
    let file = path.display().to_string();
    Problem::Write { file, source }.into()
}

/// What a command reads and writes: no file may be both, and none meant for two outputs.
///
/// ```
/// use sesc_model::files::Access;
///
/// let access = Access::default().reads(["robot.urdf"]).writes(["./robot.urdf"]);
/// # let folder = std::env::temp_dir().join("sesc_access");
/// # std::fs::create_dir_all(&folder).unwrap();
/// # let urdf = folder.join("robot.urdf");
/// # std::fs::write(&urdf, "").unwrap();
/// # let other = folder.join("../sesc_access/robot.urdf");
/// # let access = Access::default().reads([&urdf]).writes([&other]);
/// let clash = access.check().unwrap_err();
/// assert!(clash.contains("robot.urdf is read here"));
/// ```
#[derive(Debug, Default)]
pub struct Access {
    read: Vec<PathBuf>,
    /// With what each is read as.
    reserved: Vec<(PathBuf, &'static str)>,
    written: Vec<PathBuf>,
}

impl Access {
    /// Files that are read; `-` is standard input.
    #[must_use]
    pub fn reads<P: Into<PathBuf>>(mut self, paths: impl IntoIterator<Item = P>) -> Access {
        self.read.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Files that are read if they are there, and would be the next time: nothing may be
    /// put in their places. `role` is what they are read as: "the sidecar of a log".
    #[must_use]
    pub fn reserves<P: Into<PathBuf>>(
        mut self,
        paths: impl IntoIterator<Item = P>,
        role: &'static str,
    ) -> Access {
        let paths = paths.into_iter().map(|path| (path.into(), role));
        self.reserved.extend(paths);
        self
    }

    /// Files that are written.
    #[must_use]
    pub fn writes<P: Into<PathBuf>>(mut self, paths: impl IntoIterator<Item = P>) -> Access {
        self.written.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Files that are written.
    pub fn written(&self) -> &[PathBuf] {
        &self.written
    }

    /// Whether no output takes the place of an input or of another output.
    ///
    /// # Errors
    /// The first that does, in a sentence with the remedy.
    pub fn check(&self) -> Result<(), String> {
        let input = |path: &PathBuf| match path.as_os_str() == "-" {
            true => resolved(Path::new("/dev/stdin")),
            false => resolved(path),
        };
        let read = self.read.iter().map(input);
        let read: BTreeSet<PathBuf> = read.filter(|path| path.exists()).collect();
        let reserved = self.reserved.iter();
        let reserved: BTreeMap<_, _> = reserved.map(|(p, role)| (resolved(p), role)).collect();
        let mut taken = BTreeSet::new();
        for path in &self.written {
            let place = resolved(path);
            let name = path.display();
            if read.contains(&place) {
                return Err(format!("{name} is read here; give the output another name"));
            }
            if let Some(role) = reserved.get(&place) {
                return Err(format!(
                    "{name} is read here as {role}; give the output another name"
                ));
            }
            if !taken.insert(place) {
                return Err(format!(
                    "{name} is meant for two outputs; give each a name of its own"
                ));
            }
        }
        Ok(())
    }
}

/// Where a file is, or would be: as the system resolves it.
fn resolved(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| {
        let folder = folder_of(path);
        let name = path.file_name().unwrap_or_default();
        match fs::canonicalize(folder) {
            Ok(folder) => folder.join(name),
            // A folder that is yet to be made; the root is its own parent.
            Err(_) if folder != path && folder != Path::new(".") => resolved(folder).join(name),
            Err(_) => path.to_path_buf(),
        }
    })
}

/// Where a file that is written as `path` goes.
///
/// # Errors
/// What is no regular file cannot be replaced by one, and what is write-protected is meant
/// to stay.
pub fn to_write(path: &Path) -> Result<PathBuf, Error> {
    let refused = |reason: &str| Err(failed(path, io::Error::other(reason)));
    if is_stream(path) {
        return refused(
            "it is a stream of a process or a device; give the name of a file to write",
        );
    }
    // Renaming would replace a link or a device itself, not what it stands for.
    let place = resolved(path);
    match fs::metadata(&place) {
        Ok(about) if !about.is_file() => {
            refused("it is no regular file; give the name of a file to write")
        }
        Ok(about) if about.permissions().readonly() => {
            refused("it is write-protected; give another name, or allow writing")
        }
        _ => Ok(place),
    }
}

/// Links that are followed, at most; as many as Linux follows.
const LINKS: usize = 40;

/// Whether `path` stands for a descriptor of a process or a device: `/dev/stdout` leads to
/// the file that a shell appends to, and a rename would take that file away.
fn is_stream(path: &Path) -> bool {
    let mut here = path.to_path_buf();
    for _ in 0..LINKS {
        let Ok(folder) = fs::canonicalize(folder_of(&here)) else {
            return false;
        };
        let in_memory = Path::new("/dev/shm");
        if folder.starts_with("/proc")
            || folder.starts_with("/dev") && !folder.starts_with(in_memory)
        {
            return true;
        }
        match fs::read_link(&here) {
            Ok(target) => here = folder.join(target),
            Err(_) => return false,
        }
    }
    false
}

#[cfg(test)]
mod tests;
