//! A posture log: what is measured, and its files.
//!
//! One row a posture, averaged over 100 readings; or every reading. Angles as
//! they are, or in encoder ticks of 2π/4096.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use rand_chacha::ChaCha8Rng;
use sesc_reference::{Track, World};

use crate::poses::Poses;
use crate::recording::normal;
use crate::stage::Stage;

/// Readings that a posture's mean is made of.
pub const READINGS: usize = 100;

/// How a log is written down.
#[derive(Debug, Clone, Copy, Default)]
pub struct Style {
    /// The cells' loads in place of the CoP.
    pub cells: bool,
    /// Angles rounded to encoder ticks.
    pub ticks: bool,
    /// Every reading a row, few of them.
    pub repeats: bool,
}

/// A log in memory: what its files say.
#[derive(Debug, Clone)]
pub struct Log {
    /// Number of every posture.
    pub numbers: Vec<f64>,
    /// Time of every posture, s.
    pub times: Option<Vec<f64>>,
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Encoder readings of each posture, rad.
    pub postures: Vec<Vec<f64>>,
    /// Mean readings, m.
    pub cop: Vec<[f64; 2]>,
    /// Standard deviation of every mean reading in x and y, m.
    pub sigma: Vec<[f64; 2]>,
    rows: Vec<String>,
    /// The file of the postures put aside; empty but for its header of a motion.
    aside: String,
    sidecar: String,
}

impl Log {
    /// Reads a robot along a track, with noise; what moves shows it in the CoP.
    pub fn take(
        stage: &Stage,
        world: &World,
        poses: &Poses,
        style: Style,
        random: &mut ChaCha8Rng,
    ) -> Log {
        let weight_n = world.nominal_weight();
        let moving = poses.times.is_some().then(|| world.clone().unsettled());
        let world = moving.as_ref().unwrap_or(world);
        let readings = if style.repeats { 20 } else { READINGS };
        let mut log = Log {
            joints: stage.joint_names(),
            postures: poses.track.postures().to_vec(),
            cop: Vec::new(),
            sigma: Vec::new(),
            rows: Vec::new(),
            sidecar: sidecar(stage, readings),
            numbers: poses.numbers.clone(),
            times: poses.times.clone(),
            aside: String::new(),
        };
        let _ = writeln!(log.aside, "pose,{}", log.joints.join(","));
        for (number, q) in &poses.aside {
            let q: Vec<String> = q.iter().map(|q| format!("{q:.7}")).collect();
            let _ = writeln!(log.aside, "{number},{}", q.join(","));
        }
        for q in log.postures.iter_mut().flatten() {
            if style.ticks {
                *q = (*q * 4096.0 / TAU).round() * TAU / 4096.0;
            }
            *q = (*q * 1e6).round() / 1e6;
        }
        log.rows.push(log.header(style));
        for (i, reading) in world.readings(&poses.track).into_iter().enumerate() {
            let (truth, std) = if style.cells {
                (reading.cells_n, stage.cell_std(weight_n))
            } else {
                (reading.cop.to_vec(), stage.reading_std())
            };
            log.add(i, stage, &truth, std, (style, readings), random);
        }
        log
    }

    fn header(&self, style: Style) -> String {
        let mut header = "pose".to_owned();
        if self.times.is_some() {
            header += ",t";
        }
        for joint in &self.joints {
            let _ = write!(header, ",{joint}");
        }
        let columns = if style.cells {
            vec!["fsr_1", "fsr_2", "fsr_3", "fsr_4"]
        } else {
            vec!["cop_x", "cop_y"]
        };
        for column in &columns {
            let _ = write!(header, ",{column}");
        }
        if !style.repeats {
            for column in &columns {
                let _ = write!(header, ",{column}_std");
            }
        }
        header
    }

    /// One posture: its row, or its rows.
    fn add(
        &mut self,
        i: usize,
        stage: &Stage,
        truth: &[f64],
        std: f64,
        (style, readings): (Style, usize),
        random: &mut ChaCha8Rng,
    ) {
        let mut normal = || normal(random);
        let mut start = format!("{}", self.numbers[i]);
        if let Some(times) = &self.times {
            let _ = write!(start, ",{:.3}", times[i]);
        }
        for q in &self.postures[i] {
            let _ = write!(start, ",{q:.6}");
        }
        let mut mean = vec![0.0; truth.len()];
        if style.repeats {
            for _ in 0..readings {
                let mut row = start.clone();
                for (truth, mean) in truth.iter().zip(&mut mean) {
                    let value = truth + std * normal();
                    *mean += value / readings as f64;
                    let _ = write!(row, ",{value:.7}");
                }
                self.rows.push(row);
            }
        } else {
            let mut row = start;
            for (truth, mean) in truth.iter().zip(&mut mean) {
                *mean = truth + std * normal() / (readings as f64).sqrt();
                let _ = write!(row, ",{mean:.7}");
            }
            for _ in truth {
                // A sample's standard deviation scatters by 1/√(2n).
                let seen = std * (1.0 + normal() / (2.0 * readings as f64).sqrt());
                let _ = write!(row, ",{seen:.7}");
            }
            self.rows.push(row);
        }
        let std = std / (readings as f64).sqrt();
        if !style.cells {
            self.cop.push([mean[0], mean[1]]);
            self.sigma.push([std; 2]);
            return;
        }
        // What a cell's noise does to Σ f p / Σ f: its distance from the CoP.
        let (total, cells) = (mean.iter().sum::<f64>(), stage.cells());
        let cop = [0, 1].map(|axis| {
            let moments = mean.iter().zip(&cells).map(|(f, cell)| f * cell[axis]);
            moments.sum::<f64>() / total
        });
        self.cop.push(cop);
        self.sigma.push([0, 1].map(|axis| {
            let levers = cells.iter().map(|cell| (cell[axis] - cop[axis]).powi(2));
            std * levers.sum::<f64>().sqrt() / total.abs()
        }));
    }

    /// The track as the log has it.
    pub fn track(&self) -> Track {
        let track = match &self.times {
            Some(times) => Track::sampled(times.clone(), self.postures.clone()),
            None => Track::still(self.postures.clone()),
        };
        track.numbered(self.numbers.clone())
    }

    /// Writes `<stem>.csv`, `<stem>.toml` and, of the postures put aside,
    /// `<stem>_aside.csv`; gives the first.
    pub fn write(&self, folder: &Path, stem: &str) -> PathBuf {
        let write = |name: String, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).expect("the folder takes files");
            path
        };
        write(format!("{stem}.toml"), &self.sidecar);
        write(format!("{stem}_aside.csv"), &self.aside);
        write(format!("{stem}.csv"), &(self.rows.join("\n") + "\n"))
    }
}

fn sidecar(stage: &Stage, readings: usize) -> String {
    format!(
        "robot = \"{}\"\nsupport = \"{}\"\nreadings_per_pose = {readings}\ncells = {:?}\n",
        stage.robot.name(),
        stage.support,
        stage.cells()
    )
}
