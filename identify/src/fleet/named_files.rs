//! The files of a pattern or a folder.
//!
//! Files and folders whose names begin with a dot are left out, unless a pattern says the dot:
//! systems keep notes of their own in such, `._r1.csv` beside `r1.csv`. A name that is no UTF-8
//! has `\u{fffd}` where it is none; no file has that name, and its row says so.

use std::ffi::OsStr;
use std::fs::{self, DirEntry};
use std::io;
use std::path::{Component, Path, PathBuf};

use super::input::{ENDINGS, is_log};
use crate::Error;

/// The files of a pattern, a folder, or a file.
///
/// # Errors
/// A pattern or a folder that has no log.
pub(super) fn expanded(item: &str) -> Result<Vec<PathBuf>, Error> {
    let path = Path::new(item);
    if path.is_dir() {
        let mut logs = Vec::new();
        below(path, &mut logs).map_err(|error| Error::read(item, error))?;
        return match logs.is_empty() {
            true => Err(Error::request(format!(
                "{item}: no log in this folder; logs end in {}",
                ENDINGS.join(", ")
            ))),
            false => Ok(logs),
        };
    }
    let is_pattern = item.contains(['*', '?', '[']) && !path.exists();
    if !is_pattern {
        // What cannot be read is the error of its row.
        return Ok(vec![path.to_path_buf()]);
    }
    let wrong = |error: &dyn std::fmt::Display| Error::request(format!("{item}: {error}"));
    let found = glob::glob(item).map_err(|error| wrong(&error))?;
    let files: Result<Vec<PathBuf>, _> = found.collect();
    let mut files = files.map_err(|error| wrong(&error))?;
    let is_shown = shown(path);
    let is_meant = |path: &Path| path.is_file() && !is_aside(path) && is_shown(path);
    files.retain(|path| path.to_str().is_some() && is_meant(path));
    for path in unspellable(path) {
        let seen = spelled(&path);
        if path.is_file() && !is_aside(&seen) && is_shown(&seen) {
            files.push(seen);
        }
    }
    match files.is_empty() {
        true => Err(Error::request(format!(
            "{item}: no file has such a name; quote the pattern, so that the shell leaves it alone"
        ))),
        false => Ok(files),
    }
}

/// Sidecars and URDFs, which a pattern such as `**/*` would take for logs.
fn is_aside(path: &Path) -> bool {
    let end = path.extension().and_then(|end| end.to_str());
    matches!(end, Some("toml" | "urdf" | "xacro"))
}

fn has_dot(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
}

/// A path in UTF-8.
fn spelled(path: &Path) -> PathBuf {
    PathBuf::from(path.to_string_lossy().into_owned())
}

fn below(folder: &Path, logs: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (name, path) = (entry.file_name(), entry.path());
        if has_dot(&name) {
            continue;
        }
        if path.is_dir() {
            below(&path, logs)?;
        } else if is_log(&name) {
            logs.push(spelled(&path));
        }
    }
    Ok(())
}

/// Whether a pattern means a file: names that begin with a dot are those of a pattern that has
/// the dot.
fn shown(pattern: &Path) -> impl Fn(&Path) -> bool + use<> {
    let hidden = |path: &Path| {
        let names = path.components().filter(|part| match part {
            Component::Normal(name) => has_dot(name),
            _ => false,
        });
        names.count()
    };
    let said = hidden(pattern);
    move |path| hidden(path) <= said
}

/// Files and folders' files that a pattern means and whose names are no UTF-8, which the walk of
/// patterns passes over.
fn unspellable(pattern: &Path) -> Vec<PathBuf> {
    let parts: Vec<&OsStr> = pattern.components().map(Component::as_os_str).collect();
    let is_plain = |part: &&&OsStr| !part.to_string_lossy().contains(['*', '?', '[']);
    let plain = parts.iter().take_while(is_plain).count();
    let mut root: PathBuf = parts[..plain].iter().collect();
    if plain == 0 {
        root.push(".");
    }
    let rest: Option<Vec<&str>> = parts[plain..].iter().map(|part| part.to_str()).collect();
    let mut found = Vec::new();
    walk(&root, &rest.unwrap_or_default(), false, &mut found);
    if plain == 0 {
        let bare = |path: PathBuf| {
            path.strip_prefix(".")
                .map(Path::to_path_buf)
                .unwrap_or(path)
        };
        found = found.into_iter().map(bare).collect();
    }
    found
}

/// Entries below a folder that the rest of a pattern means; `odd` where a folder above has a name
/// that is no UTF-8. What cannot be read is left out.
fn walk(folder: &Path, rest: &[&str], odd: bool, found: &mut Vec<PathBuf>) {
    let Some((first, after)) = rest.split_first() else {
        return;
    };
    let is_deep = *first == "**";
    if is_deep {
        walk(folder, after, odd, found);
    }
    let Ok(pattern) = glob::Pattern::new(first) else {
        return;
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if !is_deep && !pattern.matches(&name.to_string_lossy()) {
            continue;
        }
        let odd = odd || name.to_str().is_none();
        if !is_deep && after.is_empty() {
            found.extend(odd.then(|| entry.path()));
        } else if is_folder(&entry, is_deep) {
            let rest = if is_deep { rest } else { after };
            walk(&entry.path(), rest, odd, found);
        }
    }
}

/// Whether an entry is a folder; a link to one is none where a walk of links might have no end.
fn is_folder(entry: &DirEntry, is_deep: bool) -> bool {
    match entry.file_type() {
        Ok(kind) if kind.is_symlink() => !is_deep && entry.path().is_dir(),
        Ok(kind) => kind.is_dir(),
        Err(_) => false,
    }
}
