//! Factor files: what one log, or one machine, contributes to a fit.
//!
//! `sesc fit --partial` writes one; `sesc fit a.part b.part` combines them and
//! gives the answer that all logs together would give. A file carries the robot
//! it is about, so that nothing else is needed.

use std::path::Path;

use serde::{Deserialize, Serialize};

use sesc_model::tree::is_support;
use sesc_model::{Model, Snapping, files};

use super::gather::{Gathered, LogUsed};
use crate::health::Finding;
use crate::logs::names::short;
use crate::robot::Robot;
use crate::{Error, Message, Setting, message};

mod layout;
mod options;

pub use options::PartOptions;

/// A contribution to a fit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Part {
    /// `sesc factor 4`.
    format: String,
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
    /// The options that shaped the sums; parts of formats before 4 do not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub options: Option<PartOptions>,
    /// The sums.
    pub(crate) gathered: Gathered,
}

/// The robot of a part, and where it stood.
#[derive(Debug, Clone)]
pub struct About {
    /// Hash of the robot's description, in hexadecimal.
    pub hash: String,
    /// File of the description.
    pub urdf_file: String,
    /// Text of the description.
    pub urdf: String,
    /// The support whose parameters the factors are about.
    pub support: String,
    /// All links that postures stood on.
    pub supports: Vec<String>,
    /// Whether decimals of right angles were made exact.
    pub snapped: bool,
    /// The robot of its type that the logs are of.
    pub unit: Option<String>,
    /// The options that shaped the sums.
    pub options: PartOptions,
}

impl Part {
    /// The part of a robot's `gathered` logs.
    pub(crate) fn new(about: About, gathered: Gathered) -> Part {
        Part {
            format: layout::FORMAT.to_string(),
            hash: about.hash,
            urdf_file: about.urdf_file,
            urdf: about.urdf,
            support: about.support,
            supports: about.supports,
            snapped: about.snapped,
            unit: about.unit,
            options: Some(about.options),
            gathered,
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
        self.gathered.unusable()
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
        let part = layout::read(bytes).map_err(bad)?;
        if part.gathered.folds.len() < 2 {
            return Err(bad("it has no folds; gather the log again".into()));
        }
        if let Some(reason) = part.gathered.invalid_reason() {
            return Err(bad(format!("{reason}; gather the log again")));
        }
        let params = part.gathered.params();
        let agree = |fold: &super::gather::Fold| {
            fold.weighted.params() == params
                && fold
                    .plain
                    .as_ref()
                    .is_none_or(|plain| plain.params() == params)
        };
        if !part.gathered.folds.iter().all(agree) {
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
        layout::written(self).map_err(Error::serialise)
    }

    /// Whether the sums are about this robot, read from the part's own text, on its support.
    pub(crate) fn check_robot(&self, robot: &Robot, model: &Model) -> Result<(), Error> {
        let bad = |reason: String| {
            let message = format!("{reason}; gather the log again");
            Err(Error::log(self.urdf_file.clone(), None, message))
        };
        if robot.description.hash != self.hash {
            return bad("the URDF in a factor file is not the one that it was made with".into());
        }
        let unknown = |link: &&String| !is_support(link, robot.description.link_names());
        if let Some(link) = self.supports.iter().find(unknown) {
            let link = short(link);
            return bad(format!(
                "a factor file stood on `{link}`, which the robot does not have"
            ));
        }
        let (own, params) = (self.gathered.params(), model.base.params.len());
        if own != params {
            return bad(format!(
                "a factor file has sums of {own} parameters, and its robot has {params}"
            ));
        }
        Ok(())
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
        let robot = Robot::parse(&self.urdf, &self.urdf_file)?;
        let snapping = match self.snapped {
            true => Snapping::default(),
            false => Snapping::Off,
        };
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
        for support in other.supports {
            if !self.supports.contains(&support) {
                self.supports.push(support);
            }
        }
        let bad = |message: Message| Error::log(name, None, message);
        self.gathered.merge(other.gathered).map_err(bad)?;
        self.unit = self.unit.take().or(other.unit);
        self.options = self.options.or(other.options);
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
        match &self.unit {
            Some(own) if own != unit => Err(Error::request(message![
                format!("the parts are of unit `{}`, not of ", short(own)),
                Setting::Unit,
                format!(" `{}`", short(unit))
            ])),
            _ => {
                self.unit = Some(unit.to_string());
                Ok(())
            }
        }
    }

    /// Whether both are about one robot, and were gathered alike.
    fn check_alike(&self, other: &Part, name: &str) -> Result<(), Error> {
        let bad = |message: Message| Error::log(name, None, message);
        if self.hash != other.hash {
            return Err(bad(format!(
                "about another robot ({}, hash {}) than the first part ({}, hash {})",
                other.urdf_file, other.hash, self.urdf_file, self.hash
            )
            .into()));
        }
        if let (Some(own), Some(its)) = (&self.unit, &other.unit)
            && own != its
        {
            return Err(bad(format!(
                "of unit `{}`, and the first part is of unit `{}`; fit each robot by itself",
                short(its),
                short(own)
            )
            .into()));
        }
        if self.snapped != other.snapped {
            return Err(bad(message![
                "one part was gathered with ",
                Setting::Snapping,
                ", one without"
            ]));
        }
        let options = self.options.as_ref().zip(other.options.as_ref());
        match options.and_then(|(own, its)| own.difference(its)) {
            Some(difference) => Err(bad(difference)),
            None => Ok(()),
        }
    }
}
