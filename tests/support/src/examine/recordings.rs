//! Rows in time with noise that lasts, nothing hidden: the intervals of `fit` that hold the
//! truth, and the verdict of `diagnose`.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::Verdict;
use sesc_model::Snapping;

use super::{Failure, diagnosed, fitted, intervals, log, robot};
use crate::recording::{Motion, Noise, Recording};
use crate::stage::{Platform, Stage};

/// A kind of log.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// The robot.
    pub platform: Platform,
    /// How it moves.
    pub motion: Motion,
    /// The noise of its readings.
    pub noise: Noise,
    /// Hz
    pub rate: f64,
    /// Whether the log has a column `t`.
    pub timed: bool,
    /// Whether the noise is stated truthfully.
    pub stated: bool,
}

/// What was said of one log.
#[derive(Debug, Clone)]
pub struct Said {
    /// Parameters whose 95 % interval holds the truth, of all that have one.
    pub intervals: (usize, usize),
    /// Rows, and what they are worth according to `fit`.
    pub samples: (usize, usize),
    /// Noise of a reading on one axis over the true one.
    pub noise: f64,
    /// Verdict of the diagnosis, where it was asked for.
    pub verdict: Option<Verdict>,
    /// Noise of x and y that the diagnosis took, over the true one.
    pub diagnosed_noise: Option<f64>,
}

impl Kept {
    /// The robot's recording of a seed.
    pub fn record(&self, stage: &Stage, seed: u64) -> Recording {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let world = stage.world();
        Recording::take(stage, &world, self.motion, self.noise, self.rate, random)
    }

    /// Ask about a recording.
    ///
    /// # Errors
    /// Of the robot or the log.
    pub fn ask(
        &self,
        stage: &Stage,
        recording: &Recording,
        diagnose: bool,
    ) -> Result<Said, Failure> {
        let (robot, on) = (robot(stage)?, stage.support);
        let model = robot.model(on, Snapping::default(), None)?;
        let rms = self.noise.std[0].hypot(self.noise.std[1]) / std::f64::consts::SQRT_2;
        let stated = self.stated.then_some(rms);
        let log = log(recording, self.timed);
        let found = fitted(&robot, on, log.clone(), stated, "free")?;
        let diagnosis = diagnose.then(|| diagnosed(&robot, on, log, stated));
        let diagnosis = diagnosis.transpose()?;
        Ok(Said {
            intervals: intervals(&found, &model.cad_params()),
            samples: (found.samples.rows, found.samples.independent),
            noise: found.noise_floor / rms,
            verdict: diagnosis.as_ref().map(|d| d.verdict),
            diagnosed_noise: diagnosis.as_ref().map(|d| d.noise / rms),
        })
    }
}
