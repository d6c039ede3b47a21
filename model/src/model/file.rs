//! Model files: identified parameters, with where they came from.
//!
//! ```text
//! format = 1               # of the file; 1 where nothing is said
//! robot = "op2"            # hash and support say which robot they belong to
//! hash = "5be7…"
//! support = "r_sole"
//! [[parameters]]
//! name = "r_knee_link.x"
//! value = 0.0123           # m
//! std = 0.0004             # m, optional
//! source = "data"          # or "prior"
//! [[effects]]
//! effect = "joint_offset"
//! target = "l_knee"
//! parameters.offset_rad = { value = 0.031, std = 0.001 }
//! [[effects]]              # one that is made of a site and a function
//! effect = "cable_pull"
//! target = "r_knee"
//! site = "joint"
//! function = "stiffness * max(q - start, 0.0)"
//! range.q = [-0.4, 1.5]    # outside of it the function stays as it is at its ends, optional
//! units.start = "rad"
//! parameters.stiffness = { value = 0.052, std = 0.002 }
//! parameters.start = { value = 0.48, std = 0.01 }
//! [information]            # optional: what a recursive fit goes on from
//! factor = [[812.3, 4.1, …], …, [20.5]]    # rows from their diagonal on, see `Information`
//! ```
//!
//! Effects act stage by stage, whatever their order in the file; those of one
//! stage (two of wiring, two ways of the sensor's axes, two faults of one cell) in
//! the file's order.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Information;
use crate::effects::{Site, Unit};
use crate::error::Problem;
use crate::text::{shortened, visible};
use crate::urdf::limits;
use crate::{Error, files};

/// The newest format that is read. It grows where a reader of before would misunderstand a
/// file, which then says its format.
const NEWEST: u32 = 1;

/// Parameters of a file that keeps how well they are known together, at most: 600 joints.
pub(super) const INFORMED: usize = 1203;

/// No quantity of an effect is larger, in its unit.
const MOST: f64 = 1e9;

/// One base parameter as identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name: `r_knee_link.x` ([`crate::base::BaseParam::name`]).
    pub name: String,
    /// Its value, m; a mass fraction for `.s` of a prismatic joint.
    pub value: f64,
    /// Standard deviation, in the unit of the value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
    /// Where it came from: `data`, `prior`, `cad` or another word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
}

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "schema",
    derive(schemars::JsonSchema),
    schemars(rename = "LogUsed")
)]
pub struct DataUsed {
    /// Name of the log.
    pub file: String,
    /// Hash of its content.
    pub hash: String,
    /// Rows.
    pub rows: u64,
    /// Least and largest `t`, s; none where the log has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times: Option<[f64; 2]>,
}

/// How the motion of the joints counted in readings of a CoP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MotionCounted {
    /// They are the ZMP.
    Zmp,
    /// They are those of standing postures, though joints moved.
    Static,
}

/// A number with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its standard deviation, in the same unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
}

/// One effect of a model file.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectRecord {
    /// Its name: `joint_offset` ([`crate::effects::Catalog`]).
    pub effect: String,
    /// Joint, link, cell (`fsr_1`), `all`; `-` for the whole robot.
    #[serde(default = "whole")]
    pub target: String,
    /// Of an effect that is made of a site and a function: where it adds something,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<Site>,
    /// and what, as a formula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub function: Option<String>,
    /// Where a load is in the frame of its link, m; at the link's CoM without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
    /// What it is, in words, of `{target}`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sentence: Option<String>,
    /// By variable of the function, the ends outside of which it stays as it is there.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub range: BTreeMap<String, [f64; 2]>,
    /// Mean of each column of the log that the function has.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<String, f64>,
    /// Units of the function's parameters that have one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub units: BTreeMap<String, String>,
    /// Values by name with unit: `offset_rad`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, Quantity>,
}

fn whole() -> String {
    "-".to_string()
}

/// What `model.toml` holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelFile {
    /// Name of the robot.
    pub robot: String,
    /// Hash of its URDF (FNV-1a of its content); the file is refused for another one.
    pub hash: String,
    /// Link that stands on the ground; the file is refused for another one.
    pub support: String,
    /// Noise of a reading on one axis, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_floor: Option<f64>,
    /// How motion counted in the readings that the parameters are from; none where none did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionCounted>,
    /// All base parameters, in their order.
    pub parameters: Vec<Parameter>,
    /// What the parameters were identified from.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub data: Vec<DataUsed>,
    /// Places of the foot cells, m, support frame; effects of cells need them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<[f64; 2]>,
    /// What the robot does that its URDF does not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectRecord>,
    /// How well the parameters are known together, as the fit left them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub information: Option<Information>,
    /// Where it was read from, for messages.
    #[serde(skip)]
    pub file: String,
}

impl ModelFile {
    /// Take `information` over: deviations that the file has become those of it, none where
    /// it has none. Of more than `INFORMED` parameters it is not kept: the file would be
    /// longer than one that is read.
    pub fn inform(&mut self, information: Information) {
        for (parameter, std) in self.parameters.iter_mut().zip(information.deviations()) {
            parameter.std = parameter.std.and(std);
        }
        let fits = self.parameters.len() <= INFORMED;
        self.information = fits.then_some(information);
    }

    /// Read and parse `path`.
    ///
    /// # Errors
    /// When it cannot be read, is no model file, or holds values that are not finite.
    pub fn read(path: &Path) -> Result<ModelFile, Error> {
        let file = path.display().to_string();
        let text = files::read_text(path, files::MODEL).map_err(|source| Problem::Read {
            file: file.clone(),
            source,
        })?;
        ModelFile::parse(&text, &file)
    }

    /// Parse the text of a model file; `file` names it in messages.
    pub fn parse(text: &str, file: &str) -> Result<ModelFile, Error> {
        let bad = |fault: files::TomlFault| Problem::ModelFile {
            file: file.to_string(),
            line: fault.line,
            reason: fault.reason,
        };
        let mut model: ModelFile = files::parse_toml(text, NEWEST).map_err(bad)?;
        model.file = file.to_string();
        match model.invalid_reason() {
            Some(reason) => Err(Error::model_file(file, reason)),
            None => Ok(model),
        }
    }

    /// The first value that no robot has: not finite, or beyond every size.
    pub fn invalid_reason(&self) -> Option<String> {
        let check = |what: &str, x: f64, most: f64| match x.is_finite() && x.abs() <= most {
            true => None,
            false if x.is_finite() => Some(format!("{what} is {x:?}, more than any robot has")),
            false => Some(format!("{what} is not finite; give a number")),
        };
        let metres = limits::OFFSET_M;
        let parameters = self.parameters.iter().find_map(|parameter| {
            let what = format!("parameter `{}`", shortened(&visible(&parameter.name), 64));
            let std = parameter.std.unwrap_or(0.0);
            check(&what, parameter.value, metres)
                .or_else(|| check(&format!("the std of {what}"), std, f64::MAX))
        });
        let effects = self.effects.iter().find_map(|effect| {
            effect.parameters.iter().find_map(|(name, quantity)| {
                let most = match Unit::of(name) {
                    Unit::Radian => limits::TURNS_RAD,
                    _ => MOST,
                };
                let own = |text: &str| shortened(&visible(text), 64);
                let what = format!("effect `{}`: `{}`", own(&effect.effect), own(name));
                let std = quantity.std.unwrap_or(0.0);
                check(&what, quantity.value, most)
                    .or_else(|| check(&format!("the std of {what}"), std, f64::MAX))
            })
        });
        let cells = self.cells.iter().flatten();
        let count = self.parameters.len();
        let information = self.information.as_ref();
        parameters
            .or(effects)
            .or_else(|| check("noise_floor", self.noise_floor.unwrap_or(0.0), metres))
            .or_else(|| {
                cells
                    .copied()
                    .find_map(|x| check("a place of a cell", x, metres))
            })
            .or_else(|| information.and_then(|found| found.invalid_reason(count)))
    }

    /// The text of the file.
    ///
    /// # Errors
    /// When it holds what TOML cannot.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|error| Error::model_file(&self.file, error.to_string()))
    }

    /// Values in the order of the base parameters (a model that takes the file has made sure
    /// of it).
    pub fn values(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.value).collect()
    }

    /// The distinct sources of the parameters.
    pub fn source(&self) -> String {
        let mut sources: Vec<&str> = self
            .parameters
            .iter()
            .filter_map(|p| p.source.as_deref())
            .collect();
        sources.sort_unstable();
        sources.dedup();
        if sources.is_empty() {
            "not given".to_string()
        } else {
            sources.join(", ")
        }
    }

    /// Whether the file was made for the robot of this `hash`, read from `urdf`.
    ///
    /// # Errors
    /// When it was made for another one.
    pub fn check_robot(&self, hash: &str, urdf: &str) -> Result<(), Error> {
        if self.hash == hash {
            return Ok(());
        }
        let reason = format!(
            "made for robot hash {}, but {urdf} has {hash}; identify again or use the URDF it was \
             made with",
            self.hash
        );
        Err(Error::model_file(&self.file, reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OLD: &str = "robot = \"r\"\nhash = \"h\"\nsupport = \"foot\"\nparameters = []\n";

    #[test]
    fn a_file_that_says_no_format_has_the_first_and_is_written_so() {
        let file = ModelFile::parse(OLD, "model.toml").unwrap();
        let first = ModelFile::parse(&format!("format = 1\n{OLD}"), "model.toml").unwrap();
        assert_eq!(file, first);
        assert!(!first.to_toml().unwrap().contains("format"));
    }
}
