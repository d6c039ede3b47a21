//! Which logs a fleet has, and which robot, day and URDF each belongs to.
//!
//! A log is named by a pattern (`logs/robot=*/day=*/*.parquet`), a folder, a list or a
//! manifest. Its robot and day are, the first that says so: columns of the manifest; folders
//! such as `robot=17`; the name of the file, `<robot>_<day>`, or all of it where one of the
//! two is missing. The key `week` is the ISO week of the day.
//!
//! * A **list** ends in `.txt` or `.list` and has a path a line, `#` before remarks.
//! * A **manifest** is a CSV file with a column `path` and any of the keys, `urdf`, `support`; a
//!   byte order mark, `;` or tabs between fields and names in capitals are fine.
//! * A URDF of a robot's own is named by the manifest, or is a file `robot.urdf` beside its
//!   logs or in one of the folders `name=value` above.
//!
//! Paths in a list or manifest are relative to it. Files and folders whose names begin with a dot
//! are left out, unless a pattern says the dot: systems keep notes of their own in such,
//! `._r1.csv` beside `r1.csv`. A name that is no UTF-8 has `\u{fffd}` where it is none; no file
//! has that name, and its row says so.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader, Read as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fs, io};

use glob::Pattern;
use serde::{Deserialize, Serialize};
use sesc_model::files;
use sesc_model::text::visible;

use crate::Error;
use crate::logs::delimiter;

/// Endings of logs that are looked for in folders, and that are no part of a robot's name or day.
const ENDINGS: [&str; 4] = [".csv.gz", ".csv", ".parquet", ".mcap"];
/// Endings of sidecars and URDFs, which a pattern such as `**/*` would take for logs.
const ASIDE: [&str; 3] = [".toml", ".urdf", ".xacro"];
/// The key that is made of the day, and the day.
const WEEK: &str = "week";
const DAY: &str = "day";

/// Logs of one robot on one day, with one URDF.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Group {
    /// The logs, sorted; a path that was given twice is here once.
    pub logs: Vec<PathBuf>,
    /// The robot.
    pub robot: String,
    /// The day; empty where logs are grouped by robot alone.
    pub day: String,
    /// The URDF, where it is not the fleet's.
    pub urdf: Option<PathBuf>,
    /// Link on the ground, where the manifest says it.
    pub support: Option<String>,
}

impl Group {
    /// The group of one log, by what is said of it (keys, `urdf`, `support`), by its folders and
    /// its name. The last of `by` is the day, those before it the robot; `week` is the ISO week
    /// of `day`, `2031-W18`, where nothing says it.
    ///
    /// # Errors
    /// Where a week is asked for and the day is no date, and of an address such as `s3://…`.
    pub fn of_log(
        path: PathBuf,
        said: &BTreeMap<String, String>,
        by: &[String],
    ) -> Result<Group, Error> {
        check_is_here(&path)?;
        let folders = partitions(&path);
        // An empty cell of a manifest says nothing.
        let told = |key: &str| said.get(key).filter(|text| !text.is_empty()).cloned();
        let known = |key: &str| told(key).or_else(|| folders.get(key).cloned());
        let is_of_day = |key: &str| key == WEEK && known(WEEK).is_none();
        let value = |key: &String| known(if is_of_day(key) { DAY } else { key });
        let values: Vec<Option<String>> = by.iter().map(value).collect();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let without = |end: &&str| name.strip_suffix(*end);
        let stem = ENDINGS.iter().find_map(without).unwrap_or(&name);
        let missing = values.iter().filter(|value| value.is_none()).count();
        // A name of more parts than keys has them in the first.
        let mut parts: Vec<&str> = stem.rsplitn(missing, '_').collect();
        let mut keys = Vec::new();
        for (key, value) in by.iter().zip(values) {
            let mut text = value.unwrap_or_else(|| parts.pop().unwrap_or_default().to_string());
            if is_of_day(key) {
                text = iso_week(&text).ok_or_else(|| {
                    Error::request(format!(
                        "`{key}` is the ISO week of a day, and the day of {} is `{}`; give dates \
                         such as 2031-05-01",
                        visible(&path.display().to_string()),
                        visible(&text)
                    ))
                })?;
            }
            keys.push(text);
        }
        let day = (keys.len() > 1).then(|| keys.pop()).flatten();
        let urdf = told("urdf").map(PathBuf::from);
        Ok(Group {
            robot: keys.join("/"),
            day: day.unwrap_or_default(),
            urdf: urdf.or_else(|| urdf_beside(&path)),
            support: told("support"),
            logs: vec![path],
        })
    }
}

/// The keys of folders `name=value`, the innermost of each name.
fn partitions(path: &Path) -> BTreeMap<String, String> {
    let folders = path.parent().into_iter().flat_map(Path::components);
    let folders = folders.filter_map(|part| part.as_os_str().to_str()?.split_once('='));
    let plain = |(key, value)| (unescaped(key), unescaped(value));
    folders.map(plain).collect()
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
    let is_key = |folder: &&Path| {
        let name = folder.file_name().and_then(OsStr::to_str);
        name.is_some_and(|name| name.contains('='))
    };
    let beside = path.parent()?;
    let above = beside.ancestors().take_while(is_key).skip(1);
    let folders = std::iter::once(beside).chain(above);
    let mut urdfs = folders.map(|folder| folder.join("robot.urdf"));
    urdfs.find(|urdf| urdf.is_file())
}

/// `2031-W18` of a date: `2031-05-01`, `20310501`, also with a time of the day behind it.
fn iso_week(day: &str) -> Option<String> {
    let date = match day.split_once([' ', 'T']) {
        Some((date, time)) if time.starts_with(|c: char| c.is_ascii_digit()) => date,
        _ => day,
    };
    let digits = match date.split('-').map(str::len).collect::<Vec<_>>()[..] {
        [4, 2, 2] => date.replace('-', ""),
        _ => date.to_string(),
    };
    if digits.len() != 8 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let number = |of: Range<usize>| digits[of].parse::<usize>().ok();
    let year = number(0..4).filter(|year| *year > 0)?;
    let (month, day) = (number(4..6)?, number(6..8)?);
    // Days from Monday, 0001-01-01, to the first of a year.
    let before = |year: usize| {
        let years = year - 1;
        365 * years + years / 4 - years / 100 + years / 400
    };
    let february = before(year + 1) - before(year) - 337;
    let months = [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    let length = *months.get(month.checked_sub(1)?)?;
    if day == 0 || day > length {
        return None;
    }
    let days = before(year) + months[..month - 1].iter().sum::<usize>() + day - 1;
    // A week belongs to the year of its Thursday.
    let thursday = days - days % 7 + 3;
    let of = (year.max(2) - 1..=year + 1).rfind(|year| before(*year) <= thursday)?;
    let week = (thursday - before(of)) / 7 + 1;
    Some(format!("{of:04}-W{week:02}"))
}

/// Only files of this machine are read.
fn check_is_here(path: &Path) -> Result<(), Error> {
    let path = path.to_string_lossy();
    if !path.contains("://") {
        return Ok(());
    }
    Err(Error::request(format!(
        "{path}: a fleet reads the files of this machine; mount the store, or copy its logs"
    )))
}

/// All logs that `data` names, each a group of its own. The last of `by` is the day, those before
/// it the robot.
///
/// # Errors
/// A pattern or file that names nothing, lists that cannot be read, addresses of object stores,
/// and days without a week where that is asked for.
pub fn inputs(data: &[String], by: &[String]) -> Result<Vec<Group>, Error> {
    if by.is_empty() || by.iter().any(|key| key.trim().is_empty()) {
        return Err(Error::request("no key to group logs by; give robot,day"));
    }
    let mut found = Vec::new();
    for item in data {
        let path = Path::new(item);
        let is_list = item.ends_with(".txt") || item.ends_with(".list");
        check_is_here(path)?;
        let paths: Vec<PathBuf> = if is_list && path.is_file() {
            let text = read_list(path)?;
            let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
            let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
            lines.map(|line| beside(path, line)).collect()
        } else if manifest(path, by, &mut found)? {
            continue;
        } else {
            expanded(item)?
        };
        for path in paths {
            found.push(Group::of_log(path, &BTreeMap::new(), by)?);
        }
    }
    found.sort();
    found.dedup();
    Ok(found)
}

fn read_list(path: &Path) -> Result<String, Error> {
    files::read_text(path, 1024).map_err(|error| Error::read(path.display().to_string(), error))
}

/// A path that a list or manifest names.
fn beside(list: &Path, text: &str) -> PathBuf {
    list.parent().unwrap_or(Path::new(".")).join(text)
}

/// Take over the logs of a manifest; whether the file is one: a log has no column `path`.
fn manifest(path: &Path, by: &[String], found: &mut Vec<Group>) -> Result<bool, Error> {
    // Opening a pipe would block.
    if path.extension().is_none_or(|end| end != "csv") || !path.is_file() {
        return Ok(false);
    }
    let known = ["path", "urdf", "support", DAY, WEEK];
    let known: Vec<&str> = by.iter().map(String::as_str).chain(known).collect();
    let ours = |name: &str| {
        let exact = known.iter().find(|own| **own == name);
        exact.or_else(|| known.iter().find(|own| own.eq_ignore_ascii_case(name)))
    };
    let mut head = Vec::new();
    let read = fs::File::open(path)
        .and_then(|file| BufReader::new(file.take(1 << 16)).read_until(b'\n', &mut head));
    let (Ok(_), Ok(between)) = (read, delimiter(&head, 0)) else {
        return Ok(false);
    };
    let mut table = csv::ReaderBuilder::new();
    table.trim(csv::Trim::All).delimiter(between);
    let names = table.from_reader(&head[..]).headers().cloned();
    let names: Vec<_> = names.iter().flatten().map(ours).collect();
    if !names.contains(&Some(&"path")) {
        return Ok(false);
    }
    let bad = |line: Option<&csv::Position>, what: &str| {
        let file = path.display().to_string();
        Error::log(file, line.map(csv::Position::line), what)
    };
    let text = read_list(path)?;
    for record in table.from_reader(text.as_bytes()).records() {
        let record = record.map_err(|error| {
            let what = "is no manifest: a row has more or fewer fields than the header";
            bad(error.position(), what)
        })?;
        let fields = names.iter().zip(&record);
        let known =
            fields.filter_map(|(name, text)| Some(((*name)?.to_string(), text.to_string())));
        let mut said: BTreeMap<String, String> = known.collect();
        let log = said.remove("path").filter(|log| !log.is_empty());
        let nothing = "this row of the manifest has no path";
        let log = log.ok_or_else(|| bad(record.position(), nothing))?;
        if let Some(urdf) = said.get_mut("urdf").filter(|urdf| !urdf.is_empty()) {
            *urdf = beside(path, urdf).display().to_string();
        }
        found.push(Group::of_log(beside(path, &log), &said, by)?);
    }
    Ok(true)
}

/// The files of a pattern, a folder, or a file.
fn expanded(item: &str) -> Result<Vec<PathBuf>, Error> {
    let path = Path::new(item);
    let is_folder = path.is_dir();
    let is_plain = |part: &&str| !part.contains(['*', '?', '[']);
    if !is_folder && (is_plain(&item) || path.exists()) {
        // What cannot be read is the error of its row.
        return Ok(vec![path.to_path_buf()]);
    }
    let wrong = |what: &str| Error::request(format!("{item}: {what}"));
    let parts = path.iter().filter_map(OsStr::to_str);
    let mut folder = path.to_path_buf();
    let mut below = vec!["**", "*"];
    let mut nothing = format!("no log in this folder; logs end in {}", ENDINGS.join(", "));
    if !is_folder {
        folder = parts.clone().take_while(is_plain).collect();
        below = parts.skip_while(is_plain).collect();
        nothing = "no file has such a name; quote the pattern, so that the shell leaves it alone"
            .to_string();
    }
    let below: Result<Vec<Pattern>, _> = below.into_iter().map(Pattern::new).collect();
    let below = below.map_err(|error| wrong(&error.to_string()))?;
    let mut found = Vec::new();
    walk(&folder, &below, &mut found).map_err(|error| Error::read(item, error))?;
    found.retain(|path| {
        let name = path.to_string_lossy();
        let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
        (is_folder && ends(&ENDINGS)) || (!is_folder && !ends(&ASIDE))
    });
    if found.is_empty() {
        return Err(wrong(&nothing));
    }
    Ok(found)
}

/// Files below a folder, if it is one, that the rest of a pattern means. `**` is any number of
/// folders, of which links are none, for a walk of links might have no end.
fn walk(folder: &Path, rest: &[Pattern], found: &mut Vec<PathBuf>) -> io::Result<()> {
    // An empty path is the folder that the program runs in.
    let opened = Path::new(".").join(folder);
    let Some((first, after)) = rest.split_first().filter(|_| opened.is_dir()) else {
        return Ok(());
    };
    let is_deep = first.as_str() == "**";
    if is_deep {
        walk(folder, after, found)?;
    }
    for entry in fs::read_dir(opened)? {
        let entry = entry?;
        let path = folder.join(entry.file_name());
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_hidden = name.starts_with('.') && !first.as_str().starts_with('.');
        if is_hidden || !is_deep && !first.matches(&name) {
            continue;
        }
        if !is_deep && after.is_empty() {
            // A pipe or a device becomes a row that says so.
            if !path.is_dir() {
                found.push(PathBuf::from(path.to_string_lossy().into_owned()));
            }
        } else if !(is_deep && entry.file_type()?.is_symlink()) {
            walk(&path, if is_deep { rest } else { after }, found)?;
        }
    }
    Ok(())
}

/// The groups of all inputs, sorted by robot, day and URDF. What a terminal would obey in the
/// name of a folder is spelled out (`\u{1b}`), for the name goes into tables and pages.
///
/// ```
/// use sesc_identify::fleet::{groups, inputs};
///
/// # let folder = std::env::temp_dir().join(format!("sesc-groups-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).unwrap();
/// for name in ["r17_2031-05-01.csv", "r17_2031-05-05.csv", "r18_2031-05-01.csv"] {
///     std::fs::write(folder.join(name), "cop_x,cop_y,hip\n").unwrap();
/// }
/// let data = [folder.join("*.csv").display().to_string()];
/// let days = groups(&inputs(&data, &["robot".into(), "day".into()])?);
/// assert_eq!((days[1].robot.as_str(), days[1].day.as_str()), ("r17", "2031-05-05"));
/// let weeks = groups(&inputs(&data, &["robot".into(), "week".into()])?);
/// assert_eq!((weeks[1].robot.as_str(), weeks[1].day.as_str()), ("r17", "2031-W19"));
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), sesc_identify::Error>(())
/// ```
pub fn groups(inputs: &[Group]) -> Vec<Group> {
    let mut found: BTreeMap<Group, Vec<PathBuf>> = BTreeMap::new();
    for input in inputs {
        let group = Group {
            logs: Vec::new(),
            robot: visible(&input.robot),
            day: visible(&input.day),
            ..input.clone()
        };
        found.entry(group).or_default().extend(input.logs.clone());
    }
    let with_logs = |(group, mut logs): (Group, Vec<PathBuf>)| {
        logs.sort();
        logs.dedup();
        Group { logs, ..group }
    };
    found.into_iter().map(with_logs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::says;

    fn by(keys: &[&str]) -> Vec<String> {
        keys.iter().map(|key| key.to_string()).collect()
    }

    fn keys(path: &str, by: &[String]) -> (String, String) {
        let input = Group::of_log(PathBuf::from(path), &BTreeMap::new(), by).unwrap();
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
            // Dots of names are no endings.
            ("v1.2-r7_2031-05-01.csv", "v1.2-r7", "2031-05-01"),
            ("r9_01.05.2031.csv.gz", "r9", "01.05.2031"),
            ("r9_01.06.2031.mcap", "r9", "01.06.2031"),
            ("v1.2.parquet", "v1.2", ""),
            // As Spark writes names of folders.
            (
                "robot=%C3%A9a/day=2031-05-01%2000%3A00/log.csv",
                "éa",
                "2031-05-01 00:00",
            ),
            ("robot=100%/day=%zz%ff/log.csv", "100%", "%zz%ff"),
        ] {
            assert_eq!(keys(path, &both), (robot.into(), day.into()), "{path}");
        }
        let one = keys("logs/17_a.csv", &by(&["robot"]));
        assert_eq!(one, ("17_a".into(), String::new()));
        let three = by(&["site", "robot", "day"]);
        let found = keys("site=s/robot=r/day=d/log.csv", &three);
        assert_eq!(found, ("s/r".into(), "d".into()));
    }

    #[test]
    fn a_week_is_that_of_the_day_whatever_says_it() {
        let weeks = by(&["robot", "week"]);
        for (path, week) in [
            ("robot=17/day=2031-05-01/log.csv", "2031-W18"),
            ("17_2031-05-05.csv", "2031-W19"),
            ("17_20310504 23:59.csv", "2031-W18"),
            // What folders say of weeks is theirs.
            ("robot=17/week=spring/day=1/log.csv", "spring"),
        ] {
            assert_eq!(keys(path, &weeks), ("17".into(), week.into()), "{path}");
        }
        let said = [("day".to_string(), "2031-05-01".to_string())].into();
        let input = Group::of_log("17.csv".into(), &said, &weeks).unwrap();
        assert_eq!((&*input.robot, &*input.day), ("17", "2031-W18"));
        for name in ["17_monday", "17", "17_2031-02-29", "17_12", "17_ä031-5-1"] {
            let path = format!("{name}.csv").into();
            let said = Group::of_log(path, &BTreeMap::new(), &weeks).unwrap_err();
            says(said, &["2031-05-01"]);
        }
    }

    /// From tables of ISO 8601: years of 53 weeks, and days of another year's week.
    #[test]
    fn weeks_are_those_of_iso_8601() {
        for (day, week) in [
            ("2005-01-01", "2004-W53"),
            ("2005-01-02", "2004-W53"),
            ("2005-12-31", "2005-W52"),
            ("2006-01-01", "2005-W52"),
            ("2007-01-01", "2007-W01"),
            ("2008-12-29", "2009-W01"),
            ("2009-12-31", "2009-W53"),
            ("2010-01-03", "2009-W53"),
            ("2020-02-29T12:00Z", "2020-W09"),
        ] {
            assert_eq!(iso_week(day).as_deref(), Some(week), "{day}");
        }
    }

    #[test]
    fn patterns_folders_lists_and_manifests_name_the_same_logs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for day in ["1", "2"] {
            let own = at(&format!("logs/robot=a/day={day}"));
            fs::create_dir_all(&own).unwrap();
            fs::write(own.join("log.csv"), "x").unwrap();
            fs::write(own.join("log.csv.toml"), "").unwrap();
        }
        fs::write(at("logs/robot=a/day=2/robot.urdf"), "<robot/>").unwrap();
        let lines = "# logs\nlogs/robot=a/day=1/log.csv\nlogs/robot=a/day=2/log.csv\n";
        fs::write(at("list.txt"), lines).unwrap();
        let manifest = "path,robot,day\nlogs/robot=a/day=1/log.csv,a,1\n\
                        logs/robot=a/day=2/log.csv,a,2\n";
        fs::write(at("manifest.csv"), manifest).unwrap();
        let both = by(&["robot", "day"]);
        let of = |name: &str| inputs(&[at(name).display().to_string()], &both).unwrap();
        let expected = of("logs/robot=*/day=*/*");
        assert_eq!(expected.len(), 2);
        assert_eq!(expected[0].urdf, None);
        assert_eq!(expected[1].urdf, Some(at("logs/robot=a/day=2/robot.urdf")));
        // As spreadsheets write it.
        let sheet = "\u{feff}\"Path\";Robot;DAY;note\r\nlogs/robot=a/day=1/log.csv;a;1;x\r\n\
                     logs/robot=a/day=2/log.csv;;2;\r\n";
        fs::write(at("sheet.csv"), sheet).unwrap();
        let files = ["list.txt", "manifest.csv", "sheet.csv"];
        for name in ["logs", "logs/**/*.csv"].into_iter().chain(files) {
            assert_eq!(of(name), expected, "{name}");
        }
        fs::write(at("gap.csv"), "robot,path\na,x.csv\nb,\n").unwrap();
        let gap = inputs(&[at("gap.csv").display().to_string()], &both);
        let words = "gap.csv:3: this row of the manifest has no path";
        says(gap.unwrap_err(), &[words]);
    }

    /// Systems keep notes in such files and folders, unless they are asked for.
    #[test]
    fn files_and_folders_with_a_dot_in_front_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        fs::create_dir_all(at(".trash")).unwrap();
        for name in ["a_1.csv", "._a_1.csv", ".trash/a_2.csv"] {
            fs::write(at(name), "x").unwrap();
        }
        let names = |item: &str| -> Vec<String> {
            let found = inputs(&[item.to_string()], &by(&["robot", "day"])).unwrap();
            let names = found.iter().map(|input| input.logs[0].file_name().unwrap());
            names
                .map(|name| name.to_string_lossy().into_owned())
                .collect()
        };
        for item in [at(""), at("*.csv"), at("**/*.csv")] {
            assert_eq!(names(&item), ["a_1.csv"], "{item}");
        }
        assert_eq!(names(&at(".*.csv")), ["._a_1.csv"]);
        assert_eq!(names(&at(".trash/*")), ["a_2.csv"]);
    }

    /// Their rows will say what is wrong with them.
    #[cfg(target_os = "linux")]
    #[test]
    fn names_that_are_no_utf8_are_not_passed_over() {
        use std::ffi::OsStr;
        use std::os::unix::ffi::OsStrExt as _;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let odd = |name: &[u8]| folder.path().join(OsStr::from_bytes(name));
        fs::create_dir_all(odd(b"in\xff")).unwrap();
        for name in [
            &b"a_1.csv"[..],
            b"b\xff_1.csv",
            b"b\xff_1.csv.toml",
            b"in\xff/c_1.csv",
        ] {
            fs::write(odd(name), "x").unwrap();
        }
        let robots = |item: &str| -> Vec<String> {
            let found = inputs(&[item.to_string()], &by(&["robot", "day"])).unwrap();
            found.into_iter().map(|input| input.robot).collect()
        };
        assert_eq!(robots(&at("")), ["a", "b\u{fffd}", "c"]);
        assert_eq!(robots(&at("**/*.csv")), ["a", "b\u{fffd}", "c"]);
        assert_eq!(robots(&at("*.csv")), ["a", "b\u{fffd}"]);
        assert_eq!(robots(&at("in*/c*")), ["c"]);
    }

    #[test]
    fn what_names_nothing_is_an_error() {
        for (item, words) in [
            ("/nowhere/*.csv", "no file has such a name"),
            ("/tmp/**x/*.csv", "recursive wildcards"),
            ("s3://bucket/*.csv", "mount the store"),
        ] {
            says(
                inputs(&[item.into()], &by(&["robot"])).unwrap_err(),
                &[words],
            );
        }
    }

    #[test]
    fn names_of_folders_tell_a_terminal_nothing() {
        let input = |robot: &str, day: &str| Group {
            logs: vec![PathBuf::from(format!("{robot}/{day}.csv"))],
            robot: robot.to_string(),
            day: day.to_string(),
            urdf: None,
            support: None,
        };
        let found = groups(&[input("r\u{1b}]0;owned\u{7}", "mon\nday"), input("r17", "")]);
        let names: Vec<_> = found.iter().map(|g| (&*g.robot, &*g.day)).collect();
        let spelled = ("r\\u{1b}]0;owned\\u{7}", "mon\\u{a}day");
        assert_eq!(names, [("r17", ""), spelled]);
        let logs = input("r\u{1b}]0;owned\u{7}", "mon\nday").logs;
        assert_eq!(found[1].logs, logs);
    }
}
