//! Where files really are: links followed, folders spelled one way.
//!
//! What is read may have been given through a link, a relative path or a descriptor
//! (`/dev/stdin`); what is written goes where its name leads. Both are compared as the
//! system resolves them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::{failed, folder_of};
use crate::Error;

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
pub(super) fn resolved(path: &Path) -> PathBuf {
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
pub(super) fn to_write(path: &Path) -> Result<PathBuf, Error> {
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
