//! A log with its robot and day, from what a manifest says of it, from its folders and its name.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Endings of logs that are looked for in folders, and that are no part of a robot's name or day.
pub(super) const ENDINGS: [&str; 4] = [".csv.gz", ".csv", ".parquet", ".mcap"];

/// A log with what it belongs to.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub struct Input {
    /// The log.
    pub path: PathBuf,
    /// Its robot.
    pub robot: String,
    /// Its day.
    pub day: String,
    /// The URDF, where it is not the fleet's.
    pub urdf: Option<PathBuf>,
    /// Link on the ground, where the manifest says it.
    pub support: Option<String>,
}

impl Input {
    /// A log with its keys from what is said of it (keys, `urdf`, `support`), from its folders
    /// and its name.
    pub fn new(path: PathBuf, said: &BTreeMap<String, String>, by: &[String]) -> Input {
        let folders = partitions(&path);
        // An empty cell of a manifest says nothing.
        let told = |key: &String| said.get(key).filter(|text| !text.is_empty());
        let known = |key: &String| told(key).or(folders.get(key)).cloned();
        let mut keys: Vec<Option<String>> = by.iter().map(known).collect();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = stem(&name);
        let missing = keys.iter().filter(|key| key.is_none()).count();
        // A name of more parts than keys has them in the first.
        let mut parts: Vec<&str> = match missing {
            0 => Vec::new(),
            count => stem.rsplitn(count, '_').collect(),
        };
        for key in keys.iter_mut().filter(|key| key.is_none()) {
            *key = Some(parts.pop().unwrap_or_default().to_string());
        }
        let mut keys: Vec<String> = keys.into_iter().flatten().collect();
        let day = match keys.len() {
            0 | 1 => String::new(),
            _ => keys.pop().unwrap_or_default(),
        };
        let own = |key: &str| said.get(key).filter(|text| !text.is_empty());
        Input {
            robot: keys.join("/"),
            day,
            urdf: own("urdf")
                .map(PathBuf::from)
                .or_else(|| urdf_beside(&path)),
            support: own("support").cloned(),
            path,
        }
    }
}

/// The name of a log without its ending: what else has dots belongs to its robot and day.
fn stem(name: &str) -> &str {
    let without = |end: &&str| name.strip_suffix(*end);
    ENDINGS.iter().find_map(without).unwrap_or(name)
}

/// Whether a name ends as those of logs do.
pub(super) fn is_log(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes();
    ENDINGS.iter().any(|end| name.ends_with(end.as_bytes()))
}

/// The keys of folders `name=value`, the innermost of each name.
fn partitions(path: &Path) -> BTreeMap<String, String> {
    let folders = path.parent().into_iter().flat_map(Path::components);
    let folders = folders.filter_map(|part| part.as_os_str().to_str()?.split_once('='));
    folders
        .map(|(key, value)| (unescaped(key), unescaped(value)))
        .collect()
}

/// A text with `%C3` for its byte, as Spark and Hive write names of folders; what comes to no
/// text is as it was.
fn unescaped(text: &str) -> String {
    let (bytes, mut out) = (text.as_bytes(), Vec::new());
    let digit = |at: usize| char::from(*bytes.get(at)?).to_digit(16);
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let pair = (*byte == b'%').then(|| Some((digit(at + 1)?, digit(at + 2)?)));
        let own = pair.flatten().map(|(high, low)| (16 * high + low) as u8);
        out.push(own.unwrap_or(*byte));
        at += if own.is_some() { 3 } else { 1 };
    }
    String::from_utf8(out).unwrap_or_else(|_| text.to_string())
}

/// `robot.urdf` beside a log, or in a folder above as long as folders are `name=value`.
fn urdf_beside(path: &Path) -> Option<PathBuf> {
    let mut folder = path.parent()?;
    loop {
        let urdf = folder.join("robot.urdf");
        if urdf.is_file() {
            return Some(urdf);
        }
        let name = folder.file_name()?.to_str()?;
        folder = folder.parent().filter(|_| name.contains('='))?;
        if !folder.file_name()?.to_str()?.contains('=') {
            return None;
        }
    }
}

/// Whether a path is an address of an object store, such as `s3://bucket/log.csv`, which a
/// [`Disk`](super::Disk) of the caller's own reads.
pub fn is_address(path: &str) -> bool {
    let scheme = path.split_once("://").map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| !scheme.is_empty() && !scheme.contains(['/', '\\']))
}
