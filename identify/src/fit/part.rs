//! Factor files: what one log, or one machine, contributes to a fit.
//!
//! `sesc fit --partial` writes one; `sesc fit a.part b.part` combines them and
//! gives the answer that all logs together would give. A file carries the robot
//! it is about, so that nothing else is needed.
//!
//! ```text
//! gzip of {"format":"sesc factor 5", robot, unit, options, logs, folds: upper triangles row by row …}
//! ```
//!
//! Parts of other options are not of
//! one fit: a fit of all their logs has one of each. Units of joints and feet on the floor belong
//! to each log, and sums know nothing of CAD's tolerances.

use std::io::Read as _;
use std::iter;
use std::path::Path;

use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use serde::{Deserialize, Serialize};
use sesc_model::tree::is_support;
use sesc_model::{Model, Snapping, files};

use super::gather::{Gathered, LogUsed};
use super::robust::Loss;
use crate::health::Finding;
use crate::logs::Stays;
use crate::logs::names::short;
use crate::observations::motion_use::MotionModel;
use crate::robot::Robot;
use crate::{Error, Message, Setting, message};

/// First words of every file of this kind, with the version of its layout.
pub(super) const FORMAT: &str = "sesc factor 5";
/// A part is at most so many times larger unpacked, beyond a mebibyte.
const PACKED: u64 = 64;

/// A contribution to a fit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Part {
    /// `sesc factor 5`.
    pub(super) format: String,
    /// Hash of the robot.
    pub hash: String,
    /// Name of the URDF file, for messages.
    pub urdf_file: String,
    /// Its text.
    pub urdf: String,
    /// The support whose parameters the factors are about.
    pub support: String,
    /// All links that postures stood on.
    pub supports: Vec<String>,
    /// Whether decimals of right angles were made exact.
    pub snapped: bool,
    /// The robot of its type that the logs are of, such as its serial number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The options that shaped the sums.
    pub options: PartOptions,
    /// The sums.
    pub(crate) gathered: Gathered,
}

impl Part {
    /// The robot that the logs are of.
    pub(crate) fn robot(&self) -> Result<Robot, Error> {
        Robot::parse(&self.urdf, &self.urdf_file)
    }

    /// How its right angles were read.
    pub(crate) fn snapping(&self) -> Snapping {
        match self.snapped {
            true => Snapping::default(),
            false => Snapping::Off,
        }
    }

    /// Postures that were gathered.
    pub fn postures(&self) -> u64 {
        self.gathered.repeats.postures
    }

    /// The logs that were read.
    pub fn logs(&self) -> &[LogUsed] {
        &self.gathered.logs
    }

    /// What is wrong with the logs.
    pub fn health(&self) -> &[Finding] {
        &self.gathered.health
    }

    /// Why the logs cannot be used, if they cannot.
    pub fn unusable(&self) -> Option<&Finding> {
        self.health().iter().find(|f| f.kind.makes_unusable())
    }

    /// Read and check a file.
    ///
    /// # Errors
    /// When it cannot be read, is no factor file, or is damaged.
    pub fn read(path: &Path) -> Result<Part, Error> {
        let file = path.display().to_string();
        let bytes = files::read_bytes(path, files::PART)
            .map_err(|source| Error::read(file.clone(), source))?;
        Part::from_bytes(&bytes, &file)
    }

    /// Check what [`to_bytes`](Self::to_bytes) gave; `name` stands for a file in messages.
    ///
    /// # Errors
    /// When it is no part, or is damaged.
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Part, Error> {
        let bad = |message: String| Error::log(name, None, message);
        let part = read(bytes).map_err(bad)?;
        if part.gathered.folds.len() < 2 {
            return Err(bad("it has no folds; gather the log again".into()));
        }
        if let Some(reason) = part.gathered.invalid_reason() {
            return Err(bad(format!("{reason}; gather the log again")));
        }
        let params = part.gathered.params();
        let folds = part.gathered.folds.iter();
        let mut factors = folds.flat_map(|fold| iter::once(&fold.weighted).chain(&fold.plain));
        if factors.any(|factor| factor.params() != params) {
            return Err(bad(
                "its folds do not belong together; gather the log again".into(),
            ));
        }
        Ok(part)
    }

    /// The bytes of a file of it.
    ///
    /// # Errors
    /// When it cannot be written down.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::default());
        serde_json::to_writer(&mut packed, self).map_err(Error::serialise)?;
        packed.finish().map_err(Error::serialise)
    }

    /// Whether the sums are about this robot, read from the part's own text, on its support.
    pub(crate) fn check_robot(&self, robot: &Robot, model: &Model) -> Result<(), Error> {
        let unknown = |link: &&String| !is_support(link, robot.description.link_names());
        let (own, params) = (self.gathered.params(), model.base.params.len());
        let reason = if robot.description.hash != self.hash {
            "the URDF in a factor file is not the one that it was made with".to_string()
        } else if let Some(link) = self.supports.iter().find(unknown) {
            let link = short(link);
            format!("a factor file stood on `{link}`, which the robot does not have")
        } else if own != params {
            format!("a factor file has sums of {own} parameters, and its robot has {params}")
        } else {
            return Ok(());
        };
        let message = format!("{reason}; gather the log again");
        Err(Error::log(&*self.urdf_file, None, message))
    }

    /// Write to `path`, whole or not at all.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        Ok(crate::files::write(path, self.to_bytes()?)?)
    }

    /// Rewrite the sums for the parameters of `support`.
    ///
    /// # Errors
    /// When the robot has no such link.
    pub fn stand_on(&mut self, support: &str) -> Result<(), Error> {
        if self.support == support {
            return Ok(());
        }
        let (robot, snapping) = (self.robot()?, self.snapping());
        let here = robot.model(&self.support, snapping, None)?;
        self.check_robot(&robot, &here)?;
        let there = robot.model(support, snapping, None)?;
        self.gathered.shift(&here.params_from(&there));
        self.support = support.to_string();
        Ok(())
    }

    /// Add another part.
    ///
    /// # Errors
    /// When it is about another robot, unit or reading of right angles, was gathered with other
    /// options, or has a log that is here already.
    pub fn merge(&mut self, mut other: Part, name: &str) -> Result<(), Error> {
        self.check_alike(&other, name)?;
        other.stand_on(&self.support)?;
        let known = &self.supports;
        other.supports.retain(|support| !known.contains(support));
        self.supports.append(&mut other.supports);
        let bad = |message: Message| Error::log(name, None, message);
        self.gathered.merge(other.gathered).map_err(bad)?;
        self.unit = self.unit.take().or(other.unit);
        Ok(())
    }

    /// Add another part, unless all of its logs are here; where all logs of this one are in the
    /// other, that takes its place.
    ///
    /// # Errors
    /// Those of [`merge`](Self::merge): also of parts that have some logs in common and others
    /// of their own, since sums of one log cannot be taken out of a part.
    pub fn merge_new(&mut self, mut other: Part, name: &str) -> Result<(), Error> {
        let holds = |all: &Part, some: &Part| {
            let known = |hash: &str| all.logs().iter().any(|log| log.hash == hash);
            some.logs().iter().all(|log| known(&log.hash))
        };
        self.check_alike(&other, name)?;
        if holds(self, &other) {
            return Ok(());
        }
        if holds(&other, self) {
            other.stand_on(&self.support)?;
            other.unit = other.unit.or(self.unit.take());
            *self = other;
            return Ok(());
        }
        self.merge(other, name)
    }

    /// Say of which robot of its type the logs are.
    ///
    /// # Errors
    /// When they are of another one, or the name is empty.
    pub fn claim(&mut self, unit: &str) -> Result<(), Error> {
        if unit.trim().is_empty() {
            let message = message![Setting::Unit, " is empty: give a name, or leave it out"];
            return Err(Error::request(message));
        }
        if let Some(own) = self.unit.as_ref().filter(|own| *own != unit) {
            return Err(Error::request(message![
                format!("the parts are of unit `{}`, not of ", short(own)),
                Setting::Unit,
                format!(" `{}`", short(unit))
            ]));
        }
        self.unit = Some(unit.to_string());
        Ok(())
    }

    /// Whether both are about one robot, and were gathered alike.
    fn check_alike(&self, other: &Part, name: &str) -> Result<(), Error> {
        let units = self.unit.as_ref().zip(other.unit.as_ref());
        let difference = if self.hash != other.hash {
            let (file, hash) = (&other.urdf_file, &other.hash);
            message![format!(
                "about another robot ({file}, hash {hash}) than the first part ({}, hash {})",
                self.urdf_file, self.hash
            )]
        } else if let Some((own, its)) = units.filter(|(own, its)| own != its) {
            message![format!(
                "of unit `{}`, and the first part is of unit `{}`; fit each robot by itself",
                short(its),
                short(own)
            )]
        } else if self.snapped != other.snapped {
            message![
                "one part was gathered with ",
                Setting::Snapping,
                ", one without"
            ]
        } else {
            match self.options.difference(&other.options) {
                Some(difference) => difference,
                None => return Ok(()),
            }
        };
        Err(Error::log(name, None, difference))
    }
}

/// The options of a fit that shaped the sums of a part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PartOptions {
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
    /// What becomes of rows in which the robot holds still.
    pub stays: Stays,
    /// The loss that trusts outliers less, where one was asked for.
    pub robust: Option<Loss>,
}

impl PartOptions {
    /// The first one that differs, as a sentence with the remedy.
    fn difference(&self, other: &PartOptions) -> Option<Message> {
        let mut pairs = self.named().into_iter().zip(other.named());
        let ((setting, own), (_, its)) = pairs.find(|(own, its)| own.1 != its.1)?;
        let alike = format!(" {its}, the first part with {own}; gather both alike");
        Some(message!["gathered with ", setting, alike])
    }

    fn named(&self) -> [(Setting, String); 3] {
        let stays = match self.stays {
            Stays::Pooled => "none".to_string(),
            Stays::Apart => "rows apart".to_string(),
            Stays::Moving => "0 s".to_string(),
            Stays::Alone(seconds) => format!("{seconds} s"),
        };
        let robust = self.robust.map_or("none".to_string(), name);
        [
            (Setting::Motion, name(self.motion)),
            (Setting::Settle, stays),
            (Setting::Robust, robust),
        ]
    }
}

/// The name of an option in files.
fn name(option: impl Serialize) -> String {
    let written = serde_json::to_string(&option).unwrap_or_default();
    written.trim_matches('"').to_string()
}

#[derive(Deserialize)]
struct Kind {
    format: String,
}

/// A part from its bytes.
fn read(bytes: &[u8]) -> Result<Part, String> {
    let most = (1 << 20) + PACKED * bytes.len() as u64;
    let mut text = Vec::new();
    let mut unpacked = GzDecoder::new(bytes).take(most + 1);
    if let Err(error) = unpacked.read_to_end(&mut text) {
        return Err(match text.is_empty() {
            true => format!("no factor file of a fit that only gathers: {error}"),
            false => damaged(error),
        });
    }
    if text.len() as u64 > most {
        return Err(damaged("it is too long"));
    }
    let kind: Kind = serde_json::from_slice(&text).map_err(damaged)?;
    if kind.format != FORMAT {
        return Err(format!(
            "it is `{}`, and this version of sesc reads `{FORMAT}`; take the version that wrote \
             it, or gather the log again",
            short(&kind.format)
        ));
    }
    serde_json::from_slice(&text).map_err(damaged)
}

fn damaged(reason: impl std::fmt::Display) -> String {
    format!("a damaged factor file: {reason}; gather the log again")
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::sync::Arc;

    use serde_json::Value;

    use super::*;
    use crate::fit::{Request, gather};
    use crate::logs::Table;
    use crate::robot::ROD;

    /// Twenty postures of a pole of 2 kg.
    fn monday() -> Part {
        let hip: Vec<f64> = (0..20).map(|k| 0.6 * (0.7 * f64::from(k)).sin()).collect();
        let cop = |rate: f64| -> Vec<f64> { hip.iter().map(|q| rate * q.sin()).collect() };
        let log = Table::new("monday")
            .numbers("cop_x", cop(0.11))
            .numbers("cop_y", cop(0.001))
            .numbers("hip", hip.clone());
        let request = Request {
            robot: Some(Arc::new(Robot::parse(ROD, "rod.urdf").unwrap())),
            logs: vec![log.into()],
            support: Some("foot".into()),
            noise: Some(1e-4),
            ..Request::default()
        };
        gather(&request, &mut ()).unwrap()
    }

    fn unpacked(bytes: &[u8]) -> Value {
        serde_json::from_reader(GzDecoder::new(bytes)).unwrap()
    }

    fn packed(text: &str) -> Vec<u8> {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(text.as_bytes()).unwrap();
        packed.finish().unwrap()
    }

    #[test]
    fn a_part_is_read_back_to_the_bit() {
        let part = monday();
        let again = Part::from_bytes(&part.to_bytes().unwrap(), "monday.part").unwrap();
        assert_eq!(again.gathered.folds, part.gathered.folds);
        assert_eq!((again.postures(), again.support.as_str()), (20, "foot"));
        assert_eq!(again.options, part.options);
        assert_eq!(again.urdf, part.urdf);
    }

    #[test]
    fn parts_of_other_formats_are_refused() {
        let mut part = unpacked(&monday().to_bytes().unwrap());
        for format in ["sesc factor 1", "sesc factor 4", "sesc factor 6"] {
            part["format"] = format.into();
            let said = read(&packed(&part.to_string())).unwrap_err();
            assert!(said.contains(&format!("it is `{format}`")), "{said}");
            assert!(said.contains("gather the log again"), "{said}");
        }
        for other in ["", "pose,hip\n"] {
            let said = read(other.as_bytes()).unwrap_err();
            assert!(said.contains("no factor file"), "{said}");
        }
    }

    #[test]
    fn damaged_parts_are_refused() {
        let bytes = monday().to_bytes().unwrap();
        for cut in [1, 8, 100, bytes.len() / 2] {
            let said = read(&bytes[..bytes.len() - cut]).unwrap_err();
            assert!(said.contains("damaged"), "{cut}: {said}");
        }
        let whole = unpacked(&bytes);
        let with_triangle = |numbers: Value| {
            let mut part = whole.clone();
            part["gathered"]["folds"][0]["weighted"]["triangle"] = numbers;
            packed(&part.to_string())
        };
        let said = read(&with_triangle(vec![1.0, 2.0].into())).unwrap_err();
        assert!(said.contains("no triangle"), "{said}");
        let mut large = whole["gathered"]["folds"][0]["weighted"]["triangle"].clone();
        large[0] = 1e90.into();
        let said = Part::from_bytes(&with_triangle(large), "odd.part").unwrap_err();
        assert!(said.to_string().contains("`triangle`"), "{said}");
        let said = read(&packed(&" ".repeat(1 << 24))).unwrap_err();
        assert!(said.contains("too long"), "{said}");
    }
}
