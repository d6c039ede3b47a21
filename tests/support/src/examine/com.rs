//! The CoM of the diagnosed model against the true one, where an effect of the body is hidden.
//!
//! ```text
//! error = √(mean over postures of ‖CoM_model(q) − CoM_robot(q)‖²)
//! ratio = error of the diagnosed model / error of CAD's
//! ```
//!
//! The robot is the virtual one, which bends its own body; `q` is what its encoders read
//! in balanced postures that the log does not have. CAD's error is also how far the
//! effect moves the CoM. The model goes through the text of its file.

use std::path::Path;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Request, Verdict};
use sesc_model::ModelFile;

use super::{Failure, com_error, reread, robot};
use crate::hidden::hide_all;
use crate::judge::{Answer, truth};
use crate::trial::Trial;

/// What a corrected model may keep of CAD's CoM error.
pub const GOAL: f64 = 0.25;
/// An effect that moves the CoM by less is not counted, m.
pub const MOVED_M: f64 = 1e-3;
/// Postures that judge.
const JUDGED: usize = 200;

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// The log: its seed, its robot and what is hidden, with sizes.
    pub log: String,
    /// What the diagnosis comes to, and its explanation.
    pub said: String,
    /// Whether a named explanation, or the first of a class, is what was hidden.
    pub named: bool,
    /// Whether what was hidden is reported, or of the class reported.
    pub listed: bool,
    /// CoM error of CAD's model, m.
    pub before_m: f64,
    /// CoM error of the diagnosed model, m.
    pub after_m: f64,
}

impl Corrected {
    /// Error of the diagnosed model over CAD's.
    pub fn ratio(&self) -> f64 {
        self.after_m / self.before_m
    }
}

/// Diagnoses the log of `trial`, written to `folder`, and judges the CoM of the model
/// that comes of it.
///
/// # Errors
/// Where the log cannot be diagnosed, or its model not be read.
pub fn examine(trial: &Trial, folder: &Path) -> Result<Corrected, Failure> {
    let stage = &trial.stage;
    let log = trial.log.write(folder, &format!("trial_{}", trial.seed));
    let report = diagnose::diagnose(&Request::new(robot(stage)?, log.as_path()), &mut ())?;
    let file = reread(&report.model_file)?;
    let mut random = ChaCha8Rng::seed_from_u64(!trial.seed);
    let q = stage.balanced(JUDGED, &mut random);
    let world = hide_all(stage.world(), &trial.hidden)?;
    let error = |file: Option<&ModelFile>| com_error(stage, &world, file, &q, 0..3);
    let answer = Answer::read(&serde_json::to_value(&report.diagnosis)?)?;
    let hidden = truth(&trial.hidden);
    let explained = matches!(report.diagnosis.verdict, Verdict::Named | Verdict::Class);
    let steps: Vec<&str> = answer.steps.iter().map(String::as_str).collect();
    Ok(Corrected {
        log: format!("seed {} {:?} {}", trial.seed, stage.platform, trial.sizes()),
        said: format!("{}: {}", answer.verdict, steps.join(" + ")),
        named: explained && answer.is(&hidden),
        listed: explained && answer.lists(&hidden),
        before_m: error(None)?,
        after_m: error(Some(&file))?,
    })
}
