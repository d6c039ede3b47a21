//! A log as columns of numbers, drawn from a seed, before a device breaks it.

use std::f64::consts::TAU;
use std::path::Path;

use rand::seq::IndexedRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_test_support::log::READINGS;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};
use sesc_test_support::survey;
use sesc_test_support::trial::{Choice, Question, Trial};

use crate::study::Failure;

/// How a log was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RecordingKind {
    /// One row a posture, or every reading of it.
    Standing,
    /// Rows in time of a robot that moves slowly.
    Moving,
}

/// A log, and what it is of.
pub(super) struct Sheet {
    pub stage: Stage,
    pub columns: Vec<(String, Vec<f64>)>,
    /// True joint positions row by row; of repeated readings those of the posture.
    pub postures: Vec<Vec<f64>>,
    pub joints: Vec<String>,
    /// Deviation of a row of the CoP on one axis, m.
    pub row_std: f64,
    /// Deviation of a posture's mean, m.
    pub noise: f64,
    pub cells: bool,
    readings_per_pose: Option<u64>,
    /// For a reader.
    pub about: String,
}

/// Rates of recordings, Hz.
const RATES: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

impl Sheet {
    /// The log of a trial of the study of hidden effects.
    pub fn of_trial(trial: &Trial, folder: &Path) -> Result<Sheet, Failure> {
        let path = trial.log.write(folder, "standing");
        let text = std::fs::read_to_string(path)?;
        let mut lines = text.lines().map(|line| line.split(','));
        let header = lines.next().ok_or("no header")?;
        let mut columns: Vec<(String, Vec<f64>)> =
            header.map(|name| (name.to_string(), Vec::new())).collect();
        for line in lines {
            for (column, cell) in columns.iter_mut().zip(line) {
                column.1.push(cell.parse()?);
            }
        }
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        let repeated = rows != trial.log.postures.len();
        let mut random = ChaCha8Rng::seed_from_u64(trial.seed ^ 0x5eed);
        let noise = trial.stage.reading_std() / if repeated { 20.0 } else { 100.0_f64 }.sqrt();
        let mut sheet = Sheet {
            stage: trial.stage.clone(),
            cells: columns.iter().any(|(name, _)| name == "fsr_1"),
            columns,
            postures: trial.log.postures.clone(),
            joints: trial.log.joints.clone(),
            row_std: if repeated {
                trial.stage.reading_std()
            } else {
                noise
            },
            noise,
            readings_per_pose: Some(if repeated { 20 } else { READINGS as u64 }),
            about: format!("{:?}, {rows} rows", trial.postures),
        };
        // Many labs state no deviation.
        if random.random_bool(0.3) {
            sheet.columns.retain(|(name, _)| !name.ends_with("_std"));
            sheet.about += ", noise not stated";
        }
        Ok(sheet)
    }

    /// A log on which nothing is hidden.
    pub fn draw(
        source: RecordingKind,
        platform: Platform,
        seed: u64,
        folder: &Path,
    ) -> Result<Sheet, Failure> {
        match source {
            RecordingKind::Standing => {
                let choice = Choice {
                    platforms: vec![platform],
                    ..survey::everything()
                };
                Sheet::of_trial(&Trial::draw(Question::Nothing, &choice, seed), folder)
            }
            RecordingKind::Moving => Ok(Sheet::moving(platform, 0.0, seed)),
        }
    }

    /// A minute or so of slow sines at some rate, with white or lasting noise, angles as they
    /// are or in ticks; a share of the joints is `held`.
    pub fn moving(platform: Platform, held: f64, seed: u64) -> Sheet {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut stage = Stage::new(platform);
        if held > 0.0 {
            stage = stage.holding(held, random);
        }
        let rate = *RATES.choose(random).unwrap_or(&10.0);
        let seconds = 30.0 + 60.0 * random.random::<f64>();
        let seconds = seconds.min(6000.0 / rate);
        let std = stage.size * 1e-3 * (0.3 + 1.2 * random.random::<f64>());
        let kind = if random.random_bool(0.5) {
            Kind::White
        } else {
            Kind::Ar1(0.1 * 10f64.powf(random.random::<f64>()))
        };
        let noise = Noise {
            kind,
            std: [std; 2],
            visit_std: 0.0,
        };
        let tick = if random.random_bool(0.5) {
            TAU / 4096.0
        } else {
            0.0
        };
        let swing = Swing {
            tick,
            jitter: if random.random_bool(0.3) { 0.4 } else { 0.0 },
            ..Swing::new(
                0.1 + 0.3 * random.random::<f64>(),
                0.08 + 0.12 * random.random::<f64>(),
                seconds,
            )
        };
        let (recording, how) = match random.random_bool(0.5) {
            true => (
                swing.record(&stage, stage.world(), noise, rate, random),
                format!("{:.2} Hz", swing.hertz),
            ),
            false => {
                let motion = Motion::Sines(seconds);
                let world = stage.world();
                let mut own = Recording::take(&stage, &world, motion, noise, rate, random);
                for q in own.q.iter_mut().flatten().filter(|_| tick > 0.0) {
                    *q = (*q / tick).round() * tick;
                }
                (own, "slow sines".to_string())
            }
        };
        let mut columns = recording.columns(true);
        let stated = random.random_bool(0.5);
        if stated {
            for name in ["cop_x_std", "cop_y_std"] {
                columns.push((name.to_string(), vec![std; recording.t.len()]));
            }
        }
        Sheet {
            about: format!(
                "{seconds:.0} s at {rate} Hz, {how}, {kind:?} {:.2} mm{}{}",
                1e3 * std,
                if stated { " stated" } else { "" },
                if tick > 0.0 { ", ticks" } else { "" }
            ),
            stage,
            columns,
            joints: recording.joints,
            postures: recording.q,
            row_std: std,
            noise: std,
            cells: false,
            readings_per_pose: None,
        }
    }

    /// Deviation of a single reading, as a user would give it, m.
    pub fn reading_std(&self) -> f64 {
        match self.readings_per_pose {
            Some(_) => self.stage.reading_std(),
            None => self.row_std,
        }
    }

    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    pub fn column(&mut self, name: &str) -> Option<&mut Vec<f64>> {
        let mut columns = self.columns.iter_mut();
        columns
            .find(|(own, _)| own == name)
            .map(|(_, values)| values)
    }

    /// Rows in this order; some may come twice.
    pub fn reorder(&mut self, order: &[usize]) {
        for (_, values) in &mut self.columns {
            *values = order.iter().map(|&k| values[k]).collect();
        }
    }

    /// The log, in memory.
    pub fn log(&self) -> LogSource {
        let mut table = Table::new("log");
        for (name, values) in &self.columns {
            table = match name.as_str() {
                "pose" => {
                    table.integers(name, values.iter().map(|x| *x as i64).collect::<Vec<_>>())
                }
                _ => table.numbers(name, values.clone()),
            };
        }
        LogSource::from(table).with_sidecar(Sidecar {
            readings_per_pose: self.readings_per_pose,
            cells: self.cells.then(|| self.stage.cells().to_vec()),
            ..Sidecar::default()
        })
    }
}
