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
use sesc_reference::{Track, World};

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

    /// One in so many rows.
    pub fn every(&self, nth: usize) -> Recording {
        Recording {
            joints: self.joints.clone(),
            t: self.t.iter().step_by(nth).copied().collect(),
            pose: self
                .pose
                .as_ref()
                .map(|pose| pose.iter().step_by(nth).copied().collect()),
            q: self.q.iter().step_by(nth).cloned().collect(),
            cop: self.cop.iter().step_by(nth).copied().collect(),
        }
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

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Noise at times `t`.
pub fn draw(kind: Kind, std: f64, t: &[f64], random: &mut ChaCha8Rng) -> Vec<f64> {
    let steps = |k: usize| {
        if k == 0 {
            f64::INFINITY
        } else {
            t[k] - t[k - 1]
        }
    };
    let white = |n: usize, random: &mut ChaCha8Rng| -> Vec<f64> {
        (0..n).map(|_| normal(random)).collect()
    };
    let ar1 = |tau: f64, drive: &[f64]| -> Vec<f64> {
        let mut e = 0.0;
        let all = drive.iter().enumerate().map(|(k, w)| {
            let rho = (-steps(k) / tau).exp();
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
            let step = if n > 1 { t[1] - t[0] } else { 1.0 };
            let rho = (-step / tau).exp();
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

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;

    use super::*;

    /// Variance and correlation at 0.5 s, τ = 0.5 s, against their closed forms.
    #[test]
    fn noise_has_the_variance_and_the_correlation_it_says() {
        let t: Vec<f64> = (0..200_000).map(|k| 0.05 * f64::from(k)).collect();
        let e1 = (-1.0_f64).exp();
        let kinds = [
            (Kind::White, 0.0),
            (Kind::Ar1(0.5), e1),
            (Kind::Smooth(0.5), 2.0 * e1),
            (Kind::Sway(0.5), 0.5 * e1),
        ];
        for (kind, expected) in kinds {
            let e = draw(kind, 2.0, &t, &mut ChaCha8Rng::seed_from_u64(3));
            let mean = |lag: usize| {
                let pairs = e.iter().zip(&e[lag..]);
                pairs.map(|(a, b)| a * b).sum::<f64>() / (e.len() - lag) as f64
            };
            let variance = mean(0);
            assert!((variance / 4.0 - 1.0).abs() < 0.06, "{kind:?}: {variance}");
            let found = mean(10) / variance;
            assert!((found - expected).abs() < 0.03, "{kind:?}: {found}");
        }
    }
}
