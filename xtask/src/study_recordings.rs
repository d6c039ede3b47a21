//! The study of recordings: rows in time with noise that lasts, nothing hidden; counted are
//! the intervals of `fit` that hold the truth and the diagnoses that say something.
//!
//! The logs are drawn from seeds: the same command counts the same logs again.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Verdict, diagnose};
use sesc_identify::fit::{self, fit};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

/// How many logs.
#[derive(Args)]
pub struct StudyRecordings {
    /// Number of logs of each kind
    #[arg(long, default_value_t = 20)]
    logs: u64,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fits alone, which are quick
    #[arg(long)]
    fits: bool,
    /// Only kinds of log whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Where the table goes, instead of docs/dev/study/recordings.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A kind of log.
pub struct Case {
    /// The robot.
    pub platform: Platform,
    /// How it moves.
    pub motion: Motion,
    /// What noise is like.
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
    /// Parameters, and those whose 95 % interval holds the truth.
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

/// ± this many deviations hold 95 %.
const OF_95: f64 = 1.959_964;

impl Case {
    /// Its name in tables.
    pub fn name(&self) -> String {
        let motion = match self.motion {
            Motion::Sines(seconds) => format!("sines {seconds:.0} s"),
            Motion::Stays {
                postures,
                visits,
                hold,
            } => format!("{postures} stays of {hold} s, {visits} visits"),
        };
        let noise = match self.noise.kind {
            Kind::White => "white".to_string(),
            Kind::Ar1(tau) => format!("AR(1) {tau} s"),
            Kind::Smooth(tau) => format!("AR(2) {tau} s"),
            Kind::Sway(tau) => format!("sway {tau} s under white"),
        };
        let visits = match self.noise.visit_std > 0.0 {
            true => format!(", visits differ by {} mm", 1e3 * self.noise.visit_std),
            false => String::new(),
        };
        let timed = if self.timed { "" } else { ", no t" };
        let stated = if self.stated {
            ""
        } else {
            ", noise not stated"
        };
        format!(
            "{:?}, {motion}, {} Hz, {noise}{visits}{timed}{stated}",
            self.platform, self.rate
        )
    }

    /// The robot's recording of a seed.
    pub fn record(&self, stage: &Stage, seed: u64) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let world = stage.world();
        Recording::take(
            stage,
            &world,
            self.motion,
            self.noise,
            self.rate,
            &mut random,
        )
    }

    /// Ask about a recording.
    ///
    /// # Errors
    /// Of the robot or the log.
    pub fn ask(
        &self,
        stage: &Stage,
        recording: &Recording,
        diagnosed: bool,
    ) -> Result<Said, Box<dyn Error>> {
        let robot = Arc::new(Robot::read(&stage.urdf)?);
        let model = robot.model(stage.support, Snapping::default(), None)?;
        let log = || {
            let columns = recording.columns(self.timed).into_iter();
            columns.fold(Table::new("recording"), |table, (name, values)| {
                table.numbers(&name, values)
            })
        };
        let rms = self.noise.std[0].hypot(self.noise.std[1]) / std::f64::consts::SQRT_2;
        let stated = self.stated.then_some(rms);
        let mut request = fit::Request::default();
        request.robot = Some(Arc::clone(&robot));
        request.logs = vec![log().into()];
        request.support = Some(stage.support.into());
        request.prior = "free".into();
        request.noise = stated;
        let found = fit(&request, &mut ())?.identification;
        let truth = model.cad_params();
        let known = found.parameters.iter().zip(&truth);
        let known: Vec<bool> = known
            .filter_map(|(p, truth)| Some((p.value - truth).abs() <= OF_95 * p.std?))
            .collect();
        let diagnosis = match diagnosed {
            true => {
                let mut request = diagnose::Request::new(robot, log());
                request.support = Some(stage.support.into());
                request.noise = stated;
                request.prior = "tight".into();
                Some(diagnose(&request, &mut ())?.diagnosis)
            }
            false => None,
        };
        Ok(Said {
            intervals: (known.len(), known.iter().filter(|holds| **holds).count()),
            samples: (found.samples.rows, found.samples.independent),
            noise: found.noise_floor / rms,
            verdict: diagnosis.as_ref().map(|d| d.verdict),
            diagnosed_noise: diagnosis.as_ref().map(|d| d.noise / rms),
        })
    }
}

/// The kinds of log that are counted.
pub fn cases() -> Vec<Case> {
    let noise = |kind| Noise {
        kind,
        std: [2e-3; 2],
        visit_std: 0.0,
    };
    let mut cases = Vec::new();
    let kinds = [
        Kind::White,
        Kind::Ar1(0.1),
        Kind::Ar1(0.5),
        Kind::Ar1(1.0),
        Kind::Smooth(0.1),
        Kind::Sway(0.3),
    ];
    for platform in [Platform::Op2, Platform::Skew] {
        for rate in [100.0, 10.0] {
            for kind in kinds {
                for stated in [true, false] {
                    cases.push(Case {
                        platform,
                        motion: Motion::Sines(120.0),
                        noise: noise(kind),
                        rate,
                        timed: true,
                        stated,
                    });
                }
            }
        }
    }
    for (kind, visit_std) in [
        (Kind::White, 0.0),
        (Kind::White, 2e-3),
        (Kind::Ar1(0.3), 0.0),
        (Kind::Ar1(0.3), 2e-3),
    ] {
        for timed in [true, false] {
            cases.push(Case {
                platform: Platform::Op2,
                motion: Motion::Stays {
                    postures: 60,
                    visits: 2,
                    hold: 1.0,
                },
                noise: Noise {
                    visit_std,
                    ..noise(kind)
                },
                rate: 20.0,
                timed,
                stated: false,
            });
        }
    }
    cases
}

impl StudyRecordings {
    /// Draws, fits and diagnoses every log; writes the table.
    ///
    /// # Errors
    /// A log that cannot be fitted; a file that cannot be written.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let mut text = format!(
            "# Recordings\n\n\
             Rows in time of virtual robots on which nothing is hidden, with noise of 2 mm per \
             axis that lasts. Counted are the 95 % intervals of `fit --prior free` that hold the \
             truth, and the verdicts of `diagnose --prior tight`. `cargo xtask \
             study-recordings --logs {} --seed {}{}{}` counts the same {0} logs of each kind \
             again.\n\n\
             | log | rows | worth | intervals hold | noise over truth | a verdict but none |\n\
             |---|---|---|---|---|---|\n",
            self.logs,
            self.seed,
            if self.fits { " --fits" } else { "" },
            match &self.only {
                Some(only) => format!(" --only \"{only}\""),
                None => String::new(),
            }
        );
        for case in cases() {
            let name = case.name();
            if self.only.as_ref().is_some_and(|only| !name.contains(only)) {
                continue;
            }
            let stage = Stage::new(case.platform);
            let mut said = Vec::new();
            for seed in self.seed..self.seed + self.logs {
                let recording = case.record(&stage, seed);
                said.push(case.ask(&stage, &recording, !self.fits)?);
            }
            let line = row(&name, &said);
            eprintln!("{line}");
            let _ = writeln!(text, "{line}");
        }
        let own = root.join("docs/dev/study/recordings.txt");
        fs::write(self.out.as_ref().unwrap_or(&own), text)?;
        Ok(())
    }
}

fn row(name: &str, said: &[Said]) -> String {
    let all: usize = said.iter().map(|s| s.intervals.0).sum();
    let hold: usize = said.iter().map(|s| s.intervals.1).sum();
    let median = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let asked = said.iter().filter_map(|s| s.verdict);
    let alarms = asked
        .clone()
        .filter(|verdict| *verdict != Verdict::None)
        .count();
    format!(
        "| {name} | {:.0} | {:.0} | {:.1} % | {:.2} | {alarms} of {} |",
        median(said.iter().map(|s| s.samples.0 as f64).collect()),
        median(said.iter().map(|s| s.samples.1 as f64).collect()),
        100.0 * hold as f64 / all.max(1) as f64,
        median(said.iter().map(|s| s.noise).collect()),
        asked.count()
    )
}
