//! Recordings: rows in time, with noise that lasts.
//!
//! ```text
//! AR(1)   e_k = ρ e_{k−1} + √(1 − ρ²) w_k        ρ = exp(−Δt/τ)
//! smooth  AR(1) driven by AR(1): what a filter of second order leaves
//! sway    AR(1) under as much white noise of the sensor
//! ```

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_identify::logs::Table;
use sesc_reference::{Track, World};

use crate::command::Sheet;
use crate::stage::Stage;

/// What noise is like, beside its size; time constants in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Independent from row to row.
    White,
    /// First order, of this correlation time.
    Ar1(f64),
    /// Second order, smooth, of this correlation time.
    Smooth(f64),
    /// Second order with sway, of this correlation time.
    Sway(f64),
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::White => write!(f, "white"),
            Kind::Ar1(tau) => write!(f, "AR(1) {tau} s"),
            Kind::Smooth(tau) => write!(f, "AR(2) {tau} s"),
            Kind::Sway(tau) => write!(f, "sway {tau} s under white"),
        }
    }
}

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Slow sines of every joint, for so many seconds.
    Sines(f64),
    /// Stays of `hold` seconds in postures drawn over the sole, each reached `visits`
    /// times in turn; between them a second that is not recorded.
    Stays {
        /// Number of postures.
        postures: usize,
        /// Visits of each.
        visits: usize,
        /// Length of a stay, s.
        hold: f64,
    },
}

/// Noise of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Its correlation.
    pub kind: Kind,
    /// Noise of x and y, m.
    pub std: [f64; 2],
    /// What a visit of a posture differs by, m.
    pub visit_std: f64,
}

impl Noise {
    /// Of both axes alike, in postures that are visited exactly.
    pub fn new(kind: Kind, std: f64) -> Noise {
        Noise {
            kind,
            std: [std; 2],
            visit_std: 0.0,
        }
    }
}

/// Rows in time.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// Time of every row, s.
    pub t: Vec<f64>,
    /// Number of the stay that each row belongs to, where rows are of stays.
    pub pose: Option<Vec<f64>>,
    /// Encoder readings of every row, rad or m.
    pub q: Vec<Vec<f64>>,
    /// CoP of every row, m.
    pub cop: Vec<[f64; 2]>,
}

impl Recording {
    /// Record `world` at `rate` Hz.
    pub fn take(
        stage: &Stage,
        world: &World,
        motion: Motion,
        noise: Noise,
        rate: f64,
        random: &mut ChaCha8Rng,
    ) -> Recording {
        let mut recording = Recording {
            joints: stage.joint_names(),
            ..Recording::default()
        };
        let mut shift = Vec::new();
        // Of a robot that moves; one that stands is read posture by posture.
        let mut moved = None;
        match motion {
            Motion::Sines(seconds) => {
                let at = stage.motion(random);
                let count = (seconds * rate) as usize;
                recording.t = (0..count).map(|k| k as f64 / rate).collect();
                let track = Track::moving(recording.t.clone(), at);
                recording.q = track.postures().to_vec();
                let readings = world.clone().unsettled().readings(&track);
                shift = vec![[0.0; 2]; count];
                moved = Some(readings);
            }
            Motion::Stays {
                postures,
                visits,
                hold,
            } => {
                let all = stage.balanced(postures, random);
                let mut pose = Vec::new();
                for visit in 0..visits {
                    for (number, q) in all.iter().enumerate() {
                        let start = (visit * postures + number) as f64 * (hold + 1.0);
                        let own = [(); 2].map(|()| noise.visit_std * normal(random));
                        for k in 0..((hold * rate) as usize).max(1) {
                            recording.t.push(start + k as f64 / rate);
                            recording.q.push(q.clone());
                            pose.push(number as f64);
                            shift.push(own);
                        }
                    }
                }
                recording.pose = Some(pose);
            }
        }
        let noises = noise
            .std
            .map(|std| draw(noise.kind, std, &recording.t, random));
        let mut at: Option<(&Vec<f64>, [f64; 2])> = None;
        let mut readings = Vec::with_capacity(recording.t.len());
        for (k, q) in recording.q.iter().enumerate() {
            let cop = match (&moved, at) {
                (Some(moved), _) => moved[k].cop,
                (None, Some((before, cop))) if before == q => cop,
                (None, _) => world.cop(q),
            };
            at = Some((q, cop));
            readings.push([0, 1].map(|axis| cop[axis] + shift[k][axis] + noises[axis][k]));
        }
        recording.cop = readings;
        recording
    }

    /// Readings of `world` in postures `q`, one after the other, with white noise of `std` m.
    pub fn still(
        stage: &Stage,
        world: &World,
        q: Vec<Vec<f64>>,
        std: f64,
        random: &mut ChaCha8Rng,
    ) -> Recording {
        let cop = q
            .iter()
            .map(|q| world.cop(q).map(|x| x + std * normal(random)));
        Recording {
            joints: stage.joint_names(),
            cop: cop.collect(),
            q,
            ..Recording::default()
        }
    }

    /// One in so many rows.
    pub fn every(&self, nth: usize) -> Recording {
        let pose = self.pose.as_ref().map(|pose| pose.iter());
        Recording {
            joints: self.joints.clone(),
            t: self.t.iter().step_by(nth).copied().collect(),
            pose: pose.map(|pose| pose.step_by(nth).copied().collect()),
            q: self.q.iter().step_by(nth).cloned().collect(),
            cop: self.cop.iter().step_by(nth).copied().collect(),
        }
    }

    /// The same as a log in memory; without times unless they are wanted.
    pub fn table(&self, timed: bool) -> Table {
        table(self.columns(timed))
    }

    /// The same as a CSV table.
    pub fn sheet(&self, timed: bool) -> Sheet {
        let columns = self.columns(timed);
        let row = |k: usize| {
            columns
                .iter()
                .map(|(_, values)| values[k].to_string())
                .collect()
        };
        Sheet {
            names: columns.iter().map(|(name, _)| name.clone()).collect(),
            rows: (0..self.q.len()).map(row).collect(),
        }
    }

    /// The same as its text.
    pub fn csv(&self, timed: bool) -> String {
        self.sheet(timed).to_string()
    }

    /// Where a joint stands in the rows.
    pub fn joint(&self, name: &str) -> usize {
        let joint = self.joints.iter().position(|own| own == name);
        joint.expect("a joint of the robot")
    }

    /// The encoder of a joint says all the time what it says first.
    pub fn stick(&mut self, joint: &str) {
        let joint = self.joint(joint);
        let at = self.q[0][joint];
        self.q.iter_mut().for_each(|q| q[joint] = at);
    }

    /// Columns by name.
    pub fn columns(&self, timed: bool) -> Vec<(String, Vec<f64>)> {
        let mut columns = Vec::new();
        if timed {
            columns.push(("t".to_string(), self.t.clone()));
        }
        if let Some(pose) = &self.pose {
            columns.push(("pose".to_string(), pose.clone()));
        }
        for (axis, name) in ["cop_x", "cop_y"].into_iter().enumerate() {
            let values = self.cop.iter().map(|cop| cop[axis]).collect();
            columns.push((name.to_string(), values));
        }
        for (j, joint) in self.joints.iter().enumerate() {
            columns.push((joint.clone(), self.q.iter().map(|q| q[j]).collect()));
        }
        columns
    }
}

/// A log in memory of these columns.
pub fn table(columns: Vec<(String, Vec<f64>)>) -> Table {
    let add = |table: Table, (name, values): (String, Vec<f64>)| table.numbers(&name, values);
    columns.into_iter().fold(Table::new("log"), add)
}

/// A normal number of deviation 1.
pub fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Noise at times `t`.
pub fn draw(kind: Kind, std: f64, t: &[f64], random: &mut ChaCha8Rng) -> Vec<f64> {
    let step = |k: usize| {
        k.checked_sub(1)
            .map_or(f64::INFINITY, |before| t[k] - t[before])
    };
    let white = |n: usize, random: &mut ChaCha8Rng| -> Vec<f64> {
        (0..n).map(|_| normal(random)).collect()
    };
    let ar1 = |tau: f64, drive: &[f64]| -> Vec<f64> {
        let mut e = 0.0;
        let all = drive.iter().enumerate().map(|(k, w)| {
            let rho = (-step(k) / tau).exp();
            e = rho * e + (1.0 - rho * rho).sqrt() * w;
            e
        });
        all.collect()
    };
    let n = t.len();
    let unit = match kind {
        Kind::White => white(n, random),
        Kind::Ar1(tau) => ar1(tau, &white(n, random)),
        Kind::Smooth(tau) => {
            // Driven by a process of unit variance the second has (1 + ρ²)/(1 − ρ²) of it.
            let rho = (-step(1) / tau).exp();
            let size = ((1.0 - rho * rho) / (1.0 + rho * rho)).sqrt();
            let twice = ar1(tau, &ar1(tau, &white(n, random)));
            twice.into_iter().map(|e| size * e).collect()
        }
        Kind::Sway(tau) => {
            let slow = ar1(tau, &white(n, random));
            let fast = white(n, random);
            let pairs = slow.iter().zip(&fast);
            pairs
                .map(|(s, f)| (s + f) * std::f64::consts::FRAC_1_SQRT_2)
                .collect()
        }
    };
    unit.into_iter().map(|e| std * e).collect()
}
