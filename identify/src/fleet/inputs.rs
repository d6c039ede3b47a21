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
use std::path::Path;

use super::input::Input;
use super::manifest::{is_manifest, list, manifest};
use super::named_files::expanded;
use crate::Error;

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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

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
        // As spreadsheets write it.
        let sheet = "\u{feff}\"Path\";Robot;DAY;note\r\nlogs/robot=a/day=1/log.csv;a;1;x\r\n\
                     logs/robot=a/day=2/log.csv;;2;\r\n";
        std::fs::write(at("sheet.csv"), sheet).unwrap();
        for name in [
            "logs",
            "logs/**/*.csv",
            "list.txt",
            "manifest.csv",
            "sheet.csv",
        ] {
            assert_eq!(of(name), expected, "{name}");
        }
        std::fs::write(at("gap.csv"), "robot,path\na,x.csv\nb,\n").unwrap();
        let said = inputs(&[at("gap.csv").display().to_string()], &both).unwrap_err();
        assert!(
            said.to_string()
                .ends_with("gap.csv:3: this row of the manifest has no path"),
            "{said}"
        );
    }

    /// Systems keep notes in such files and folders, unless they are asked for.
    #[test]
    fn files_and_folders_with_a_dot_in_front_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name).display().to_string();
        std::fs::create_dir_all(at(".trash")).unwrap();
        for name in ["a_1.csv", "._a_1.csv", ".trash/a_2.csv"] {
            std::fs::write(at(name), "x").unwrap();
        }
        let names = |item: &str| -> Vec<String> {
            let found = inputs(&[item.to_string()], &by(&["robot", "day"])).unwrap();
            let names = found.iter().map(|input| input.path.file_name().unwrap());
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
        std::fs::create_dir_all(odd(b"in\xff")).unwrap();
        for name in [
            &b"a_1.csv"[..],
            b"b\xff_1.csv",
            b"b\xff_1.csv.toml",
            b"in\xff/c_1.csv",
        ] {
            std::fs::write(odd(name), "x").unwrap();
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
    fn a_pattern_that_names_nothing_is_an_error() {
        let said = inputs(&["/nowhere/*.csv".into()], &by(&["robot"])).unwrap_err();
        assert!(
            said.to_string().contains("no file has such a name"),
            "{said}"
        );
    }
}
