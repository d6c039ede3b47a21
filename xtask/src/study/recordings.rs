//! Rows in time with noise that lasts, nothing hidden: the intervals of `fit` that hold the
//! truth, and the diagnoses that say something.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::Verdict;
use sesc_model::Snapping;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Failure, Plan, diagnosed, fitted, intervals, log, robot};

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
    /// Its name in tables.
    fn name(&self) -> String {
        let motion = match self.motion {
            Motion::Sines(seconds) => format!("sines {seconds:.0} s"),
            Motion::Stays {
                postures,
                visits,
                hold,
            } => format!("{postures} stays of {hold} s, {visits} visits"),
        };
        let mut name = format!(
            "{:?}, {motion}, {} Hz, {}",
            self.platform, self.rate, self.noise.kind
        );
        if self.noise.visit_std > 0.0 {
            name += &format!(", visits differ by {} mm", 1e3 * self.noise.visit_std);
        }
        name += if self.timed { "" } else { ", no t" };
        name + if self.stated {
            ""
        } else {
            ", noise not stated"
        }
    }

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

/// The kinds of log that are counted.
fn kinds() -> Vec<Kept> {
    let noise = |kind, visit_std| Noise {
        visit_std,
        ..Noise::new(kind, 2e-3)
    };
    let mut all = Vec::new();
    for platform in [Platform::Op2, Platform::Skew] {
        for rate in [100.0, 10.0] {
            for kind in [
                Kind::White,
                Kind::Ar1(0.1),
                Kind::Ar1(0.5),
                Kind::Ar1(1.0),
                Kind::Smooth(0.1),
                Kind::Sway(0.3),
            ] {
                all.extend([true, false].map(|stated| Kept {
                    platform,
                    motion: Motion::Sines(120.0),
                    noise: noise(kind, 0.0),
                    rate,
                    timed: true,
                    stated,
                }));
            }
        }
    }
    for kind in [Kind::White, Kind::Ar1(0.3)] {
        for visit_std in [0.0, 2e-3] {
            all.extend([true, false].map(|timed| Kept {
                platform: Platform::Op2,
                motion: Motion::Stays {
                    postures: 60,
                    visits: 2,
                    hold: 1.0,
                },
                noise: noise(kind, visit_std),
                rate: 20.0,
                timed,
                stated: false,
            }));
        }
    }
    all
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = kinds().into_iter().enumerate().flat_map(|(k, kind)| {
        asked.seeds().map(move |seed| Case {
            rows: vec![(k, kind.name())],
            ask: Box::new(move || {
                let stage = Stage::new(kind.platform);
                let said = kind.ask(&stage, &kind.record(&stage, seed), true)?;
                let (rows, worth) = said.samples;
                Ok(Answer {
                    cells: vec![
                        Cell::Median(rows as f64),
                        Cell::Median(worth as f64),
                        Cell::Share(said.intervals.0, said.intervals.1),
                        Cell::Median(said.noise),
                        Cell::is(said.verdict != Some(Verdict::None)),
                    ],
                    note: None,
                })
            }),
        })
    });
    Plan {
        about: "Rows in time of virtual robots on which nothing is hidden, with noise of 2 mm per axis \
                that lasts: the 95 % intervals of `fit --prior free` that hold the truth, and the \
                verdicts of `diagnose --prior tight`.",
        columns: &[
            "rows",
            "worth",
            "intervals hold",
            "noise over truth",
            "a verdict but none",
        ],
        cases: cases.collect(),
    }
}
