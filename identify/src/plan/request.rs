//! What is asked of a plan.

use std::path::PathBuf;
use std::sync::Arc;

use sesc_model::Model;

use super::balance::Region;
use super::limits::Limits;
use crate::feet::Feet;
use crate::fit::prior::{Prior, Tolerances};
use crate::logs::LogSource;
use crate::robot::Robot;
use crate::{Error, Setting, message};

/// |CoP| in the seed paper's postures of the OP2, m.
pub const COP_BOX: f64 = 0.023;

/// What is asked for.
#[derive(Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot, whose shapes must not collide.
    pub robot: Arc<Robot>,
    /// The robot on its support, with the parameters to balance with.
    pub model: Arc<Model>,
    /// Number of postures.
    pub poses: usize,
    /// Candidates to choose from; a default by the number of postures and parameters.
    pub candidates: Option<usize>,
    /// Where the CoP may be.
    pub region: Region,
    /// Safety margin of the CoP in standard deviations of its prediction.
    pub sigmas: f64,
    /// Joint limits.
    pub limits: Limits,
    /// What the later fit will know beforehand.
    pub prior: Prior,
    /// Standard deviation of a reading as it enters the fit, m.
    pub noise: f64,
    /// Least height of everything but the support body, m.
    pub clearance: f64,
    /// Seed of the candidates.
    pub seed: u64,
    /// Which feet are on the floor: the support alone, unless it says both.
    pub feet: Feet,
    /// Postures that are reached once more, as rows of the file; unless given, as many as tell
    /// what visits differ by are named, where no log knows it.
    pub revisits: Option<usize>,
    /// A log of this robot: its noise and what its visits differ by are those to come.
    pub log: Option<LogSource>,
    /// Where meshes may be.
    pub folder: Option<PathBuf>,
}

impl Request {
    /// A request for `poses` postures within the URDF's limits, with the CoP in `region`.
    pub fn new(
        robot: impl Into<Arc<Robot>>,
        model: impl Into<Arc<Model>>,
        poses: usize,
        region: Region,
    ) -> Request {
        let model = model.into();
        Request {
            robot: robot.into(),
            poses,
            candidates: None,
            region,
            sigmas: 2.0,
            limits: Limits::of_urdf(&model.tree.dofs),
            prior: Prior::Cad(Tolerances::usual()),
            noise: 0.0005,
            clearance: 0.005,
            seed: 1,
            feet: Feet::default(),
            revisits: None,
            log: None,
            folder: None,
            model,
        }
    }

    /// Whether the numbers make sense.
    pub(super) fn check(&self) -> Result<(), Error> {
        let wrong = |setting: Setting, value: f64, remedy: &str| {
            Error::request(message![setting, format!(" {value}: {remedy}")])
        };
        if !(self.noise.is_finite() && self.noise > 0.0) {
            let remedy = "give a number above zero";
            return Err(wrong(Setting::Noise, self.noise, remedy));
        }
        let numbers = [
            (Setting::Margin, self.region.margin),
            (Setting::Sigmas, self.sigmas),
            (Setting::Clearance, self.clearance),
        ];
        for (setting, value) in numbers {
            if !(value.is_finite() && value >= 0.0) {
                return Err(wrong(setting, value, "give a number, zero or more"));
            }
        }
        let ranges = self.limits.ranges.iter();
        let ranges = ranges.filter(|(lower, upper)| lower <= upper);
        if ranges.count() != self.model.dof() {
            let remedy = ": give each joint a lower limit that is not above its upper one";
            return Err(Error::request(message![Setting::Limits, remedy]));
        }
        match self.candidates {
            Some(candidates) if candidates < self.poses => Err(Error::request(message![
                Setting::Candidates,
                format!(" {candidates} for "),
                Setting::Poses,
                format!(
                    " {}: give at least as many, twenty times as many choose well",
                    self.poses
                )
            ])),
            _ if self.poses == 0 => {
                let remedy = " 0: give one or more";
                Err(Error::request(message![Setting::Poses, remedy]))
            }
            _ => Ok(()),
        }
    }

    /// Candidates to look for: twenty per posture unless told, within what is quickly
    /// worked on.
    pub(super) fn wanted(&self) -> usize {
        let params = self.model.base.params.len();
        let quick = 2_000_000_000 / (params * params).max(1);
        let usual = (20 * self.poses).clamp(2_000, 20_000);
        self.candidates
            .unwrap_or(usual.min(quick).max(2 * self.poses))
    }
}
