//! Which logs a fleet has, and which robot and day each belongs to.
//!
//! A log is named by a pattern (`logs/robot=*/day=*/*.parquet`), a folder, a list or a
//! manifest. Its robot and day are, the first that says so: columns of the manifest; folders
//! such as `robot=17`; the name of the file, `<robot>_<day>`, or all of it where one of the
//! two is missing.
//!
//! * A **list** ends in `.txt` or `.list` and has a path a line, `#` before remarks.
//! * A **manifest** is a CSV file with a column `path` and any of the keys, `urdf`, `support`.
//! * A URDF of a robot's own is named by the manifest, or is a file `robot.urdf` beside its
//!   logs or in one of the folders `name=value` above.
//!
//! Paths in a list or manifest are relative to it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sesc_model::files;

use crate::Error;

/// Endings of logs that are looked for in folders.
const ENDINGS: [&str; 4] = [".csv", ".csv.gz", ".parquet", ".mcap"];
/// Largest list or manifest, MiB.
const LIST: u64 = 1024;
/// The column of a manifest that makes it one.
const PATH: &str = "path";

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
        let known = |key: &String| said.get(key).or(folders.get(key)).cloned();
        let mut keys: Vec<Option<String>> = by.iter().map(known).collect();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = name.split('.').next().unwrap_or_default();
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

/// All logs that `data` names. The last of `by` is the day, those before it the robot.
///
/// # Errors
/// A pattern or file that names nothing, and lists that cannot be read.
pub fn inputs(data: &[String], by: &[String]) -> Result<Vec<Input>, Error> {
    if by.is_empty() || by.iter().any(|key| key.trim().is_empty()) {
        return Err(Error::request("no key to group logs by; give robot,day"));
    }
    let mut found = Vec::new();
    for item in data {
        let path = Path::new(item);
        let end = |end: &str| item.ends_with(end);
        if is_manifest(path) {
            manifest(path, by, &mut found)?;
        } else if (end(".txt") || end(".list")) && path.is_file() {
            list(path, by, &mut found)?;
        } else {
            for path in expanded(item)? {
                found.push(Input::new(path, &BTreeMap::new(), by));
            }
        }
    }
    found.sort();
    found.dedup();
    Ok(found)
}

/// The files of a pattern, a folder, or a file.
fn expanded(item: &str) -> Result<Vec<PathBuf>, Error> {
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
    files.retain(|path| path.is_file() && !is_aside(path));
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

fn below(folder: &Path, logs: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let is_log = |name: &str| ENDINGS.iter().any(|end| name.ends_with(end));
        if path.is_dir() {
            below(&path, logs)?;
        } else if path
            .file_name()
            .and_then(|name| name.to_str())
            .is_some_and(is_log)
        {
            logs.push(path);
        }
    }
    Ok(())
}

/// The keys of folders `name=value`, the innermost of each name.
fn partitions(path: &Path) -> BTreeMap<String, String> {
    let folders = path.parent().into_iter().flat_map(Path::components);
    let folders = folders.filter_map(|part| part.as_os_str().to_str()?.split_once('='));
    folders
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect()
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

fn read(path: &Path) -> Result<String, Error> {
    files::read_text(path, LIST).map_err(|error| Error::read(path.display().to_string(), error))
}

/// A path relative to a folder, or an address such as `s3://bucket/log.csv`.
fn place(folder: &Path, text: &str) -> PathBuf {
    match is_address(text) {
        true => PathBuf::from(text),
        false => folder.join(text),
    }
}

/// Whether a path is an address of an object store, such as `s3://bucket/log.csv`, which a
/// [`Disk`](super::Disk) of the caller's own reads.
pub fn is_address(path: &str) -> bool {
    let scheme = path.split_once("://").map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| !scheme.is_empty() && !scheme.contains(['/', '\\']))
}

fn list(path: &Path, by: &[String], found: &mut Vec<Input>) -> Result<(), Error> {
    let beside = path.parent().unwrap_or(Path::new("."));
    let text = read(path)?;
    let lines = text.lines().map(str::trim);
    for line in lines.filter(|line| !line.is_empty() && !line.starts_with('#')) {
        found.push(Input::new(place(beside, line), &BTreeMap::new(), by));
    }
    Ok(())
}

/// Whether a CSV file is a manifest: a log has no column `path`.
fn is_manifest(path: &Path) -> bool {
    use std::io::{BufRead as _, Read as _};
    if path.extension().is_none_or(|end| end != "csv") {
        return false;
    }
    let Ok(file) = std::fs::File::open(path) else {
        return false;
    };
    let mut header = Vec::new();
    let read = std::io::BufReader::new(file.take(1 << 16)).read_until(b'\n', &mut header);
    let header = String::from_utf8_lossy(&header);
    read.is_ok()
        && header
            .split(',')
            .any(|name| name.trim().trim_matches('"') == PATH)
}

fn manifest(path: &Path, by: &[String], found: &mut Vec<Input>) -> Result<(), Error> {
    let file = path.display().to_string();
    let beside = path.parent().unwrap_or(Path::new("."));
    let bad = |error: csv::Error| {
        let line = error.position().map(csv::Position::line);
        Error::log(
            file.clone(),
            line,
            "is no manifest: a row has more or fewer fields than the header",
        )
    };
    let text = read(path)?;
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(bad)?.clone();
    for record in reader.records() {
        let record = record.map_err(bad)?;
        let fields = header.iter().zip(&record);
        let mut said: BTreeMap<String, String> = fields
            .map(|(key, value)| (key.to_string(), value.to_string()))
            .collect();
        let log = place(beside, &said.remove(PATH).unwrap_or_default());
        if let Some(urdf) = said.get_mut("urdf").filter(|urdf| !urdf.is_empty()) {
            *urdf = place(beside, urdf).display().to_string();
        }
        found.push(Input::new(log, &said, by));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by(keys: &[&str]) -> Vec<String> {
        keys.iter().map(|key| key.to_string()).collect()
    }

    fn keys(path: &str, by: &[String]) -> (String, String) {
        let input = Input::new(PathBuf::from(path), &BTreeMap::new(), by);
        (input.robot, input.day)
    }

    #[test]
    fn keys_come_from_folders_and_names() {
        let both = by(&["robot", "day"]);
        for (path, robot, day) in [
            ("logs/robot=17/day=2031-05-01/a.parquet", "17", "2031-05-01"),
            ("logs/robot=17/2031-05-01.csv", "17", "2031-05-01"),
            ("logs/g1_17_2031-05-01.csv.gz", "g1_17", "2031-05-01"),
            ("logs/17.csv", "17", ""),
        ] {
            assert_eq!(keys(path, &both), (robot.into(), day.into()), "{path}");
        }
        assert_eq!(
            keys("logs/17_a.csv", &by(&["robot"])),
            ("17_a".into(), String::new())
        );
        let three = by(&["site", "robot", "day"]);
        let found = keys("site=s/robot=r/day=d/log.csv", &three);
        assert_eq!(found, ("s/r".into(), "d".into()));
    }

    #[test]
    fn patterns_folders_lists_and_manifests_name_the_same_logs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for day in ["1", "2"] {
            let own = at(&format!("logs/robot=a/day={day}"));
            std::fs::create_dir_all(&own).unwrap();
            std::fs::write(own.join("log.csv"), "x").unwrap();
            std::fs::write(own.join("log.csv.toml"), "").unwrap();
        }
        std::fs::write(at("logs/robot=a/day=2/robot.urdf"), "<robot/>").unwrap();
        let lines = "# logs\nlogs/robot=a/day=1/log.csv\nlogs/robot=a/day=2/log.csv\n";
        std::fs::write(at("list.txt"), lines).unwrap();
        let manifest = "path,robot,day\nlogs/robot=a/day=1/log.csv,a,1\n\
                        logs/robot=a/day=2/log.csv,a,2\n";
        std::fs::write(at("manifest.csv"), manifest).unwrap();
        let both = by(&["robot", "day"]);
        let of = |name: &str| inputs(&[at(name).display().to_string()], &both).unwrap();
        let expected = of("logs/robot=*/day=*/*");
        assert_eq!(expected.len(), 2);
        assert_eq!(expected[0].urdf, None);
        assert_eq!(expected[1].urdf, Some(at("logs/robot=a/day=2/robot.urdf")));
        for name in ["logs", "logs/**/*.csv", "list.txt", "manifest.csv"] {
            assert_eq!(of(name), expected, "{name}");
        }
    }

    #[test]
    fn a_pattern_that_names_nothing_is_an_error() {
        let said = inputs(&["/nowhere/*.csv".into()], &by(&["robot"])).unwrap_err();
        assert!(
            said.to_string().contains("no file has such a name"),
            "{said}"
        );
    }
}
