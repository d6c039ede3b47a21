//! Which logs belong together: those of one robot, day and URDF.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use sesc_model::text::visible;

use super::input::Input;

/// Logs of one robot on one day, with one URDF.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Group {
    /// The robot.
    pub robot: String,
    /// The day; empty where logs are grouped by robot alone.
    pub day: String,
    /// The URDF, where it is not the fleet's.
    pub urdf: Option<PathBuf>,
    /// The logs, sorted; a path that was given twice is here once.
    pub logs: Vec<PathBuf>,
    /// Link on the ground, where the manifest says it.
    pub support: Option<String>,
}

/// The groups of all inputs, sorted by robot, day and URDF. What a terminal would obey in the
/// name of a folder is spelled out (`\u{1b}`), for the name goes into tables and pages.
///
/// ```
/// use sesc_identify::fleet::{groups, inputs};
///
/// # let folder = std::env::temp_dir().join(format!("sesc-groups-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).unwrap();
/// for name in ["r17_monday.csv", "r17_tuesday.csv", "r18_monday.csv"] {
///     std::fs::write(folder.join(name), "cop_x,cop_y,hip\n").unwrap();
/// }
/// let data = [folder.join("*.csv").display().to_string()];
/// let found = groups(&inputs(&data, &["robot".into(), "day".into()])?);
/// assert_eq!((found[1].robot.as_str(), found[1].day.as_str()), ("r17", "tuesday"));
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), sesc_identify::Error>(())
/// ```
pub fn groups(inputs: &[Input]) -> Vec<Group> {
    let mut found: BTreeMap<_, Vec<PathBuf>> = BTreeMap::new();
    for input in inputs {
        let Input {
            path,
            robot,
            day,
            urdf,
            support,
        } = input.clone();
        let key = (visible(&robot), visible(&day), urdf, support);
        found.entry(key).or_default().push(path);
    }
    let group = |((robot, day, urdf, support), mut logs): (_, Vec<PathBuf>)| {
        logs.sort();
        logs.dedup();
        Group {
            robot,
            day,
            urdf,
            logs,
            support,
        }
    };
    found.into_iter().map(group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_folders_tell_a_terminal_nothing() {
        let input = |robot: &str, day: &str| Input {
            path: PathBuf::from(format!("{robot}/{day}.csv")),
            robot: robot.to_string(),
            day: day.to_string(),
            urdf: None,
            support: None,
        };
        let found = groups(&[input("r\u{1b}]0;owned\u{7}", "mon\nday"), input("r17", "")]);
        let names: Vec<_> = found.iter().map(|g| (&*g.robot, &*g.day)).collect();
        assert_eq!(
            names,
            [("r17", ""), ("r\\u{1b}]0;owned\\u{7}", "mon\\u{a}day")]
        );
        assert_eq!(
            found[1].logs,
            [input("r\u{1b}]0;owned\u{7}", "mon\nday").path]
        );
    }
}
