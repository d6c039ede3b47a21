//! How a log is to be read: what the caller says, and what its sidecar does, `<log file name>.toml`
//! beside it, all of whose keys are optional.
//!
//! A key of a sidecar with a value of the wrong type is an error; an unknown key is a warning, since
//! it may be a note of the user's or a misspelling.

use std::collections::BTreeMap;
use std::io::ErrorKind::{NotADirectory, NotFound};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use sesc_model::files::{self, TomlFault};
use sesc_model::spelling::nearest;
use sesc_model::urdf::suggestion;

use super::block::Soles;
use super::names::short;
use crate::{Error, Message};

/// How a log is to be read.
///
/// ```
/// use sesc_identify::logs::{Angles, Options};
///
/// let mut options = Options::default();
/// options.angles = Some(Angles::Deg);
/// ```
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Options {
    /// Unit of the revolute joints; the sidecar's, else radians, unless given.
    pub angles: Option<Angles>,
    /// Whether the log must have readings.
    pub readings: Readings,
    /// The robot's links; a support that is none of them is an error. Not
    /// checked if empty.
    pub links: Vec<String>,
    /// Link on the ground in rows that do not say; the sidecar's unless given.
    pub support: Option<String>,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// Take angles and CoP of any size: which unit they are in is the question.
    pub any_unit: bool,
    /// Where the robot's soles are: with it an MCAP recording of two loaded contacts is one of
    /// both feet, and a wrench in another frame of the support's body is moved to the sole.
    #[doc(hidden)]
    pub soles: Option<Arc<dyn Soles>>,
    /// Whether both feet stand, where the caller says it; one does with `Some(false)`, whatever is
    /// loaded.
    #[doc(hidden)]
    pub both_feet: Option<bool>,
}

/// Whether readings are wanted from a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Readings {
    /// Not looked at, however wrong they are.
    Ignored,
    /// Read where the log has them.
    #[default]
    Optional,
    /// A log without them is an error.
    Required,
}

/// What becomes of rows in which a robot holds still, in a log that has times.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Stays {
    /// They are readings of one posture where the log has no `pose`; other rows are postures
    /// of their own.
    #[default]
    Pooled,
    /// They are rows like others.
    Apart,
    /// They are rows like others, of a robot that moves: every reading of an MCAP recording is a
    /// row, with the joints between its messages.
    Moving,
    /// They alone are read, from stays of at least so many seconds; of an MCAP recording, too.
    Alone(f64),
}

impl Stays {
    /// What `--settle` asks for: stays of at least so many seconds alone, all rows by 0.
    ///
    /// # Errors
    /// What is no length of a stay.
    ///
    /// # Examples
    /// ```
    /// # use sesc_identify::logs::Stays;
    /// assert_eq!(Stays::settled(0.5), Ok(Stays::Alone(0.5)));
    /// assert_eq!(Stays::settled(0.0), Ok(Stays::Moving));
    /// assert!(Stays::settled(-1.0).unwrap_err().starts_with("give 0.01 to 3600 seconds"));
    /// ```
    pub fn settled(seconds: f64) -> Result<Stays, String> {
        // No robot settles sooner, and nobody waits longer, s.
        let [least, longest] = [0.01, 3600.0];
        match seconds {
            0.0 => Ok(Stays::Moving),
            _ if (least..=longest).contains(&seconds) => Ok(Stays::Alone(seconds)),
            _ => Err(format!(
                "give {least} to {longest} seconds of holding still, or 0 for all rows"
            )),
        }
    }
}

/// When a robot that is being recorded holds still: every joint is slower than `speed`, rad/s or
/// m/s, for at least `duration`, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StillnessLimits {
    pub speed: f64,
    pub duration: f64,
}

impl StillnessLimits {
    /// Stretches of at least so many seconds.
    pub(super) fn lasting(duration: f64) -> StillnessLimits {
        StillnessLimits {
            speed: 0.02,
            duration,
        }
    }

    /// What is said of a log in which nothing is held.
    pub(super) fn nothing(self) -> String {
        format!(
            "no posture is held: no stretch of {} s in which every joint stays below {} rad/s",
            self.duration, self.speed
        )
    }
}

/// The keys that a sidecar may have, each with what it says: for readers, messages and
/// documentation.
#[doc(hidden)]
#[rustfmt::skip]
pub const KEYS: [(&str, &str); 13] = [
    ("robot", "a name, for reports"),
    ("support", "link on the ground; `foot@40mm` is the sole 40 mm below the frame of `foot`"),
    ("angles", "unit of revolute joints, `rad` or `deg`; `rad` unless given"),
    ("readings_per_pose", "readings of each posture: a row is the mean of so many"),
    ("cells", "places of the foot cells `fsr_1`, `fsr_2`, …: x and y of each in the support frame, m"),
    ("gravity", "gravity in the support frame, m/s²; straight down unless given"),
    ("both_feet", "whether both soles are flat on one floor in every row"),
    ("other_foot", "link of the other sole, or `foot@40mm`, where its name does not tell; it means \
        `both_feet`, too"),
    ("topic", "topic of the CoP in a recording that has several"),
    ("joints_topic", "topic of the joints in a recording that has several with the same joints"),
    ("experiment", "the experiment that a diagnosis asked for"),
    ("columns", "columns of other names: the name in the log, then ours"),
    ("sensors", "sensors of which the log has wrenches: the `frame` of each, or its `pose` in the \
        support frame, and its `topic` in a recording"),
];

/// What the sidecar of a log that this library writes may say.
const WRITTEN: [&str; 5] = ["robot", "support", "both_feet", "other_foot", "experiment"];
/// Unknown keys that are named, at most.
const WARNED: usize = 12;

/// No foot is so large: cells further out were hardly given in metres, m.
const FOOT: f64 = 2.0;

/// What a log's sidecar may say.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sidecar {
    /// A name, for reports.
    pub robot: Option<String>,
    /// The link that stands on the ground.
    pub support: Option<String>,
    /// `rad` (default) or `deg`, of the revolute joints.
    pub angles: Option<Angles>,
    /// Readings taken at each pose: averaged into its one row, or its rows.
    pub readings_per_pose: Option<u64>,
    /// Places of the foot cells, m, support frame.
    pub cells: Option<Vec<[f64; 2]>>,
    /// Gravity in the support frame, m/s².
    pub gravity: Option<[f64; 3]>,
    /// Whether the soles of both feet are flat on one floor in every row. The CoP is then that
    /// of both together, in the support frame.
    pub both_feet: Option<bool>,
    /// The link that is the other sole; it says that both feet are on the floor, too.
    pub other_foot: Option<String>,
    /// Topic of the CoP in a recording that has several.
    pub topic: Option<String>,
    /// Topic of the joints in a recording that has several with the same joints.
    pub joints_topic: Option<String>,
    /// What `sesc diagnose --next` asked for, where the log is of such an experiment.
    pub experiment: Option<String>,
    /// What columns of the log mean that have other names: name in the log, our name.
    pub columns: Option<BTreeMap<String, String>>,
    /// Sensors of which the log has wrenches, by what their columns begin with.
    pub sensors: Option<BTreeMap<String, Sensor>>,
}

/// Where a sensor is that measures a wrench about the origin of its frame: `l_fx`, `l_fy`, `l_fz` (N)
/// and `l_mx`, `l_my`, `l_mz` (N m) of the sensor `l`, as the ground acts on the robot.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// The link whose frame it has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Of one on the floor, in the support frame: x, y, z, m, roll, pitch and yaw, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 6]>,
    /// Its topic in a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
}

/// A remedy for angles of the wrong unit, around the name of the setting.
pub(super) const IN_DEGREES: &str = "if the log is in degrees, give ";
pub(super) const OR_SIDECAR: &str = " or put `angles = \"deg\"` in its sidecar";

/// Unit of the revolute joints' columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Angles {
    /// Radians.
    Rad,
    /// Degrees.
    Deg,
}

impl Sidecar {
    /// Where the sidecar of `log` is written: `log.csv.toml` for `log.csv`.
    pub fn path(log: &Path) -> PathBuf {
        let mut name = log.file_name().unwrap_or_default().to_os_string();
        name.push(".toml");
        log.with_file_name(name)
    }

    /// Where sidecars of `log` are looked for: the older name is `log.toml` for `log.csv`,
    /// `log.csv.gz` and `log.parquet` alike.
    pub fn paths(log: &Path) -> [PathBuf; 2] {
        let packed = log.extension().is_some_and(|end| end == "gz");
        let bare = if packed {
            log.with_extension("")
        } else {
            log.into()
        };
        [Sidecar::path(log), bare.with_extension("toml")]
    }

    /// The sidecar that `log` has, and where it would be if it has none.
    pub fn of_log(log: &Path) -> PathBuf {
        let [path, older] = Sidecar::paths(log);
        match !path.exists() && older.exists() {
            true => older,
            false => path,
        }
    }

    /// Read the sidecar of `log`, and what is odd about it; a log without one
    /// has an empty one.
    pub fn of(log: &Path) -> Result<(Sidecar, Vec<Message>), Error> {
        if log.extension().is_some_and(|end| end == "toml") {
            let file = log.display();
            return Err(Error::request(format!(
                "{file} ends like a sidecar; give the log itself"
            )));
        }
        let path = Sidecar::of_log(log);
        let file = path.display().to_string();
        match files::read_found_text(&path, files::SIDECAR) {
            Ok(text) => Sidecar::parse(&text, &file)
                .map_err(|fault| Error::log(file, fault.line, fault.reason)),
            // `/dev/stdin` has no neighbours either.
            Err(error) if matches!(error.kind(), NotFound | NotADirectory) => {
                Ok(Default::default())
            }
            Err(source) => Err(Error::read(file, source)),
        }
    }

    /// Whether this may be the text of a sidecar that came with a log of
    /// [`PostureWriter`](super::PostureWriter): it says nothing that only who recorded a log
    /// knows, such as places of cells.
    pub fn is_of_a_written_log(text: &str) -> bool {
        let table = text.parse::<toml::Table>();
        table.is_ok_and(|table| table.keys().all(|key| WRITTEN.contains(&key.as_str())))
    }

    pub(crate) fn parse(text: &str, file: &str) -> Result<(Sidecar, Vec<Message>), TomlFault> {
        let keys: BTreeMap<String, IgnoredAny> = files::parse_toml(text, 1)?;
        let known = KEYS.map(|(key, _)| key);
        let is_unknown = |key: &&String| !known.contains(&key.as_str());
        let unknown: Vec<&String> = keys.keys().filter(is_unknown).collect();
        let named = unknown.iter().take(WARNED).map(|key| {
            let meant = match nearest(key, "", known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("known are {}", known.join(", ")),
            };
            format!("{file}: unknown key `{}`; {meant}", short(key))
        });
        let mut warnings: Vec<Message> = named.map(Message::from).collect();
        if unknown.len() > WARNED {
            let more = unknown.len() - WARNED;
            warnings.push(format!("{file}: {more} more unknown keys").into());
        }
        let sidecar: Sidecar = files::parse_toml(text, 1)?;
        sidecar.check()?;
        Ok((sidecar, warnings))
    }

    /// The names of a log's columns, with ours for those that have others. The error names
    /// a column that the log does not have.
    pub(super) fn renamed(&self, header: &[String]) -> Result<Vec<String>, String> {
        let Some(columns) = &self.columns else {
            return Ok(header.to_vec());
        };
        if let Some(missing) = columns.keys().find(|name| !header.contains(name)) {
            let near = suggestion(missing, header.iter().map(String::as_str));
            return Err(format!(
                "column `{missing}` is to be read under another name, but the log has none{near}"
            ));
        }
        let ours = |name: &String| columns.get(name).unwrap_or(name).clone();
        Ok(header.iter().map(ours).collect())
    }

    pub(super) fn check(&self) -> Result<(), String> {
        if let Some(gravity) = self.gravity {
            check_gravity(gravity)?;
        }
        if self.both_feet == Some(false) && self.other_foot.is_some() {
            let said = "both_feet is false and other_foot names a second sole; leave one out";
            return Err(said.into());
        }
        if self.readings_per_pose == Some(0) {
            return Err("readings_per_pose is 0; give how many were taken, 1 or more".into());
        }
        for (name, sensor) in self.sensors.iter().flatten() {
            let is_finite = |pose: &[f64; 6]| pose.iter().all(|x| x.is_finite());
            if sensor.frame.is_some() == sensor.pose.is_some_and(|pose| is_finite(&pose)) {
                return Err(format!(
                    "sensor `{}`: give either `frame = \"…\"`, the link about whose origin its \
                     moments are, or `pose = [x, y, z, roll, pitch, yaw]` in the support frame (m, \
                     rad)",
                    short(name)
                ));
            }
        }
        for (k, [x, y]) in self.cells.iter().flatten().enumerate() {
            if !(x.abs() <= FOOT && y.abs() <= FOOT) {
                return Err(format!(
                    "cell {} at [{x:?}, {y:?}] is more than {FOOT} m from the sole's origin; \
                     give metres",
                    k + 1
                ));
            }
        }
        if self.cells.as_deref().is_some_and(is_line) {
            let said =
                "the cells lie on one line, which cannot tell the CoP; give each its own place";
            return Err(said.into());
        }
        Ok(())
    }
}

/// Gravity must pull onto the sole, or nothing stands on it.
pub(super) fn check_gravity([x, y, z]: [f64; 3]) -> Result<(), String> {
    // By the largest entry, so that no square overflows.
    let largest = [x, y, z].iter().fold(0.0, |most: f64, g| most.max(g.abs()));
    let [a, b, c] = [x, y, z].map(|g| (g / largest).powi(2));
    let pulls = z < 0.0 && -z / largest >= 0.017 * (a + b + c).sqrt();
    if pulls && (0.01..=1e6).contains(&largest) && [x, y, z].iter().all(|g| g.is_finite()) {
        return Ok(());
    }
    Err(format!(
        "gravity [{x:?}, {y:?}, {z:?}] does not pull onto the sole; its z must be negative, m/s², \
         and not small beside the others"
    ))
}

/// Whether all places are on one line: no area is spanned by any three.
fn is_line(cells: &[[f64; 2]]) -> bool {
    let Some([ax, ay]) = cells.first() else {
        return true;
    };
    let far = |[x, y]: &[f64; 2]| (x - ax).hypot(y - ay);
    let Some([bx, by]) = cells.iter().max_by(|a, b| far(a).total_cmp(&far(b))) else {
        return true;
    };
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx.hypot(dy);
    let off = |[x, y]: &[f64; 2]| ((x - ax) * dy - (y - ay) * dx).abs();
    // A micrometre aside is none.
    cells.iter().all(|cell| off(cell) <= 1e-6 * length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_log_has_its_sidecar_beside_it() {
        for (log, sidecar, older) in [
            ("a/log.csv", "a/log.csv.toml", "a/log.toml"),
            ("a/log.csv.gz", "a/log.csv.gz.toml", "a/log.toml"),
            ("log.v2.parquet", "log.v2.parquet.toml", "log.v2.toml"),
            ("log", "log.toml", "log.toml"),
        ] {
            let paths = Sidecar::paths(Path::new(log));
            assert_eq!(paths, [PathBuf::from(sidecar), PathBuf::from(older)]);
        }
    }

    /// The older name is read where there is no other.
    #[test]
    fn a_sidecar_of_the_older_name_is_read_too() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("log.csv");
        let robot = || Sidecar::of(&log).unwrap().0.robot;
        assert_eq!(robot(), None);
        std::fs::write(folder.path().join("log.toml"), "robot = 'older'").unwrap();
        assert_eq!(robot().as_deref(), Some("older"));
        std::fs::write(folder.path().join("log.csv.toml"), "robot = 'newer'").unwrap();
        assert_eq!(robot().as_deref(), Some("newer"));
    }

    #[test]
    fn unknown_keys_are_warned_of_and_wrong_types_refused() {
        let (sidecar, warnings) =
            Sidecar::parse("format = 1\nsuport = 'a'\nrobot = 'b'\nnotes = 1", "s.toml").unwrap();
        assert_eq!(sidecar.robot.as_deref(), Some("b"));
        // A sidecar of the first format may say so.
        let said: Vec<String> = warnings.iter().map(Message::to_string).collect();
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said.iter().any(|said| said.contains("mean `support`")));
        let known = |said: &String| said.contains("`notes`; known are");
        assert!(said.iter().any(known), "{said:?}");
        for (text, word) in [
            ("support = 3", "support"),
            ("readings_per_pose = -1", "readings_per_pose"),
            ("readings_per_pose = 0", "1 or more"),
            ("angles = 'turns'", "angles"),
            ("cells = [[1.0], [0.0, 1.0]]", "cells"),
            ("cells = [[41.0, 25.0]]", "metres"),
            ("cells = [[0, 0], [0.1, 0], [0.2, 0]]", "one line"),
            ("both_feet = 'yes'", "both_feet"),
            ("both_feet = false\nother_foot = 'l_sole'", "leave one out"),
            ("gravity = [0.0, 0.0, 9.8]", "negative"),
            ("gravity = [nan, 0.0, -9.8]", "negative"),
            ("robot = ", "TOML"),
            ("format = 9\nsupport = 3", "format 9"),
            ("cells = [[1e300, 0.0], [0.0, 0.0]]", "1e300"),
        ] {
            let message = Sidecar::parse(text, "s.toml").unwrap_err().reason;
            assert!(message.contains(word), "{text}: {message}");
        }
    }

    #[test]
    fn of_many_unknown_keys_a_dozen_are_named() {
        let keys: String = (0..10_000).map(|k| format!("note_{k} = 1\n")).collect();
        let (_, warnings) = Sidecar::parse(&keys, "s.toml").unwrap();
        assert_eq!(warnings.len(), WARNED + 1);
        let last = warnings[WARNED].to_string();
        assert!(last.contains("9988 more unknown keys"), "{last}");
    }

    #[test]
    fn gravity_pulls_onto_the_sole() {
        for [x, y, z] in [[0.0, 0.0, -9.80665], [0.0, 0.0, -1.0], [1.0, 1.0, -9.7]] {
            assert_eq!(check_gravity([x, y, z]), Ok(()));
        }
        let least = f64::MIN_POSITIVE;
        for z in [
            9.8,
            0.0,
            -least,
            -1e-300,
            -1e-3,
            -1e7,
            f64::NEG_INFINITY,
            f64::NAN,
        ] {
            assert!(check_gravity([0.0, 0.0, z]).is_err(), "{z:?}");
        }
    }
}
