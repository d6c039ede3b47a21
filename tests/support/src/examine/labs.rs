//! Recordings as labs have them: bows, squats and sways of robots whose masses are off, with offsets
//! of the reading, boxes in the hands and clocks that are late; judged on another recording, beside
//! what an expert's script makes of the same rows.
//!
//! ```text
//! expert   y − ZMP_CAD = d + Σ_k (∂p/∂m_k) m_k x_k        d free,  x_k ~ N(0, 0.15²) of the heaviest links
//! ```

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis};
use sesc_identify::fit;
use sesc_model::ModelFile;
use sesc_reference::{Track, World};

use super::bought::bought;
use super::{Failure, log, predicted, reread};
use crate::recording::{Kind, Recording, draw, normal};
use crate::stage::{Platform, Stage};

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moves {
    /// Down and up again, with rests.
    Bows,
    /// Down and up without a rest.
    Squats,
    /// Slow sines of a few degrees.
    Sways,
}

/// What is off beside masses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Off {
    /// Nothing, masses neither: the robot is as CAD has it.
    Nothing,
    /// Masses alone: 10 % and 5 mm.
    Masses,
    /// And readings, by 10 to 30 mm.
    Offset,
    /// And a box in a hand, a twentieth of the robot's mass.
    Box,
    /// And the clock of the readings, by 60 ms.
    Clock,
}

/// A kind of recording.
#[derive(Debug, Clone, Copy)]
pub struct Kept {
    /// The robot.
    pub platform: Platform,
    /// How it moves.
    pub moves: Moves,
    /// What is off.
    pub off: Off,
    /// Whether joint angles are those of markers, of 0.3°; else those of encoders.
    pub markers: bool,
    /// Rows per second.
    pub rate: f64,
}

impl fmt::Display for Kept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let angles = if self.markers { "markers" } else { "encoders" };
        write!(
            f,
            "{:?}, {:?}, {:?}, {angles}, {} Hz",
            self.platform, self.moves, self.off, self.rate
        )
    }
}

/// RMS of what predictions leave of another recording, m, and what was said of the first.
#[derive(Debug, Clone)]
pub struct Said {
    /// By CAD.
    pub cad: f64,
    /// By the expert's script.
    pub expert: f64,
    /// By `fit`.
    pub fit: f64,
    /// By `diagnose --prior cad`.
    pub diagnosed: f64,
    /// Whether a fifth of the rows says the same, where these are at 20 Hz.
    pub agree: Option<bool>,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
}

/// Length of a recording, s; that judges is as long.
const SECONDS: f64 = 60.0;
/// Lasting noise of readings, m, and how long it lasts, s.
const NOISE: (f64, f64) = (0.003, 0.5);
/// From this rate on, Hz, a fifth of the rows shows the moves.
const FAST: f64 = 100.0;
/// Links whose masses the expert lets free.
const HEAVIEST: usize = 4;

impl Kept {
    /// The robot as it is, and two recordings of it.
    ///
    /// # Errors
    /// Of the virtual robot.
    pub fn record(&self, stage: &Stage, seed: u64) -> Result<[Recording; 2], Failure> {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut world = match self.off {
            Off::Nothing => stage.world(),
            _ => World::new(&bought(&stage.robot, random), stage.support)?,
        };
        let size = stage.size / 2.2;
        match self.off {
            Off::Nothing | Off::Masses => {}
            Off::Offset => {
                let angle = TAU * random.random::<f64>();
                let length = size * random.random_range(0.010..0.030);
                world = world.sensor_offset([length * angle.cos(), length * angle.sin()]);
            }
            Off::Box => {
                let hand = stage.robot.links().last().map(|link| link.name.clone());
                let mass: f64 = stage.robot.links().iter().map(|link| link.mass_kg).sum();
                world = world.payload(&hand.ok_or("no link")?, mass / 20.0, [0.0; 3])?;
            }
            Off::Clock => world = world.time_delay(0.06),
        }
        let world = world.unsettled();
        // A posture to begin with, and ways from it.
        let middle = stage.balanced(1, random).concat();
        let ways = [(); 3].map(|()| {
            let step = middle.iter().map(|_| 0.35 * normal(random));
            self.within(stage, &middle, step.collect())
        });
        Ok([(); 2].map(|()| self.take(stage, &world, &middle, &ways, random)))
    }

    /// A way that keeps the CoP over the sole.
    fn within(&self, stage: &Stage, middle: &[f64], mut way: Vec<f64>) -> Vec<f64> {
        let world = stage.world();
        let limits = stage.robot.movable_joints().map(|joint| joint.range());
        for ((way, from), (low, high)) in way.iter_mut().zip(middle).zip(limits) {
            *way = (from + *way).clamp(low, high) - from;
        }
        if self.moves == Moves::Sways {
            way.iter_mut().for_each(|by| *by *= 0.3);
        }
        let is_over = |part: f64, way: &[f64]| {
            let q = middle.iter().zip(way).map(|(q, by)| q + part * by);
            let cop = world.cop(&q.collect::<Vec<_>>());
            cop.iter().all(|x| x.abs() < 0.04 * stage.size)
        };
        while !(1..=4).all(|k| is_over(0.25 * f64::from(k), &way)) {
            way.iter_mut().for_each(|by| *by *= 0.8);
        }
        way
    }

    fn take(
        &self,
        stage: &Stage,
        world: &World,
        middle: &[f64],
        ways: &[Vec<f64>; 3],
        random: &mut ChaCha8Rng,
    ) -> Recording {
        // Of each move: which way, how far, and how long.
        let lasts = match self.moves {
            Moves::Bows => 6.0,
            Moves::Squats => 3.0,
            Moves::Sways => 10.0,
        };
        let moves: Vec<(usize, f64)> = (0..40)
            .map(|_| (random.random_range(0..3), random.random_range(0.5..1.0)))
            .collect();
        let (middle, own) = (middle.to_vec(), ways.clone());
        let rests = self.moves == Moves::Bows;
        let at = move |t: f64| -> Vec<f64> {
            let (way, far) = moves[((t / lasts).max(0.0) as usize).min(moves.len() - 1)];
            let part = (t / lasts).rem_euclid(1.0);
            // Down and up, a third of the time each, with rests between.
            let part = match rests {
                true => (1.5 * part).min(1.0),
                false => part,
            };
            // Accelerations have no steps.
            let depth = far * (0.5 - 0.5 * (TAU * part).cos()).powi(2);
            let moved = middle.iter().zip(&own[way]);
            moved.map(|(q, by)| q + depth * by).collect()
        };
        let rows = 0..(SECONDS * self.rate) as usize;
        let t: Vec<f64> = rows.map(|k| k as f64 / self.rate).collect();
        let track = Track::moving(t.clone(), at);
        let noise = [(); 2].map(|()| {
            let std = NOISE.0 * stage.size / 2.2;
            draw(Kind::Ar1(NOISE.1), std, &t, random)
        });
        let readings = world.readings(&track).into_iter().enumerate();
        let cop =
            readings.map(|(k, reading)| [0, 1].map(|axis| reading.cop[axis] + noise[axis][k]));
        let cop = cop.collect();
        let mut q = track.postures().to_vec();
        for joint in 0..q[0].len() {
            let by = match self.markers {
                true => draw(Kind::Ar1(0.1), 0.3_f64.to_radians(), &t, random),
                false => vec![0.0; t.len()],
            };
            for (q, by) in q.iter_mut().zip(by) {
                q[joint] = match self.markers {
                    true => q[joint] + by,
                    false => (q[joint] * 4096.0 / TAU).round() * TAU / 4096.0,
                };
            }
        }
        Recording {
            joints: stage.joint_names(),
            t,
            pose: None,
            q,
            cop,
        }
    }

    /// Ask about the first recording, judge by the second.
    ///
    /// # Errors
    /// Of the robot or a recording.
    pub fn ask(&self, stage: &Stage, recordings: &[Recording; 2]) -> Result<Said, Failure> {
        let [first, judge] = recordings;
        let (robot, on) = (super::robot(stage)?, stage.support);
        let predicted = |recording: &Recording, file: Option<&ModelFile>| {
            let found = predicted(&robot, on, log(recording, true), file);
            found.map(|found| found.cop_m)
        };
        let left = |predicted: &[[f64; 2]]| {
            let gaps = judge.cop.iter().zip(predicted);
            let square = gaps.map(|(y, p)| (y[0] - p[0]).powi(2) + (y[1] - p[1]).powi(2));
            (square.sum::<f64>() / (2 * predicted.len()) as f64).sqrt()
        };
        let by_cad = [predicted(first, None)?, predicted(judge, None)?];
        let by_expert = expert(stage, recordings, &by_cad)?;
        let mut request = fit::Request::default();
        request.robot = Some(Arc::clone(&robot));
        request.logs = vec![log(first, true)];
        request.support = Some(on.into());
        let fitted = reread(&fit::fit(&request, &mut ())?.model_file)?;
        let diagnosed = |recording: &Recording| {
            let mut request = diagnose::Request::new(Arc::clone(&robot), log(recording, true));
            request.support = Some(on.into());
            request.prior = "cad".into();
            diagnose::diagnose(&request, &mut ())
        };
        let found = diagnosed(first)?;
        // A fifth of the rows still shows these moves.
        let agree = match self.rate >= FAST {
            true => Some(agree(
                &found.diagnosis,
                &diagnosed(&first.every(5))?.diagnosis,
            )),
            false => None,
        };
        let diagnosed = reread(&found.model_file)?;
        Ok(Said {
            cad: left(&by_cad[1]),
            expert: left(&by_expert),
            fit: left(&predicted(judge, Some(&fitted))?),
            diagnosed: left(&predicted(judge, Some(&diagnosed))?),
            agree,
            diagnosis: found.diagnosis,
        })
    }
}

/// Whether the first explanation of one is of the class of the other, with parameters within two
/// deviations where both begin with it.
fn agree(one: &Diagnosis, other: &Diagnosis) -> bool {
    let is_of = |a: &Diagnosis, b: &Diagnosis| match a.indistinguishable.first() {
        Some(first) => b.indistinguishable.contains(first),
        None => b.steps.is_empty(),
    };
    let mut pairs = one.steps.iter().flat_map(|step| {
        let same = other.steps.iter();
        let mut same = same.filter(|own| (own.effect, &own.target) == (step.effect, &step.target));
        same.next().map(|own| (step, own))
    });
    let near = pairs.all(|(a, b)| {
        a.parameters.iter().all(|(name, a)| {
            let b = &b.parameters[name];
            (a.value - b.value).abs() <= 2.0 * a.std.max(b.std)
        })
    });
    is_of(one, other) && is_of(other, one) && near
}

/// What an expert's script, made by the first recording, predicts of the second.
fn expert(
    stage: &Stage,
    [first, judge]: &[Recording; 2],
    by_cad: &[Vec<[f64; 2]>; 2],
) -> Result<Vec<[f64; 2]>, Failure> {
    let mut heaviest: Vec<_> = stage.robot.links().iter().collect();
    heaviest.sort_by(|a, b| b.mass_kg.total_cmp(&a.mass_kg));
    let heavier = heaviest.iter().take(HEAVIEST).map(|link| {
        let mass = 0.01 * link.mass_kg;
        let robot = stage.robot.clone();
        let robot = robot.with_point_mass(&link.name, mass, link.com_m.into())?;
        Ok::<_, Failure>(World::new(&robot, stage.support)?)
    });
    let heavier: Vec<World> = heavier.collect::<Result<_, _>>()?;
    let cad = stage.world();
    // Columns: a constant per axis, then what 15 % of each mass does.
    let columns = |recording: &Recording| {
        let mut all = DMatrix::zeros(2 * recording.q.len(), 2 + HEAVIEST);
        for (k, q) in recording.q.iter().enumerate() {
            let here = cad.cop(q);
            for axis in 0..2 {
                all[(2 * k + axis, axis)] = 1.0;
                for (column, world) in heavier.iter().enumerate() {
                    all[(2 * k + axis, 2 + column)] = 15.0 * (world.cop(q)[axis] - here[axis]);
                }
            }
        }
        all
    };
    let x = columns(first);
    let gap = first.cop.iter().zip(&by_cad[0]);
    let gap = gap.flat_map(|(y, p)| [y[0] - p[0], y[1] - p[1]]);
    let y = DVector::from_iterator(2 * first.q.len(), gap);
    let mut normal = x.tr_mul(&x);
    // Noise of 5 mm, of which rows a second apart are independent.
    let ridge = 0.005_f64.powi(2) * (first.q.len() as f64 / SECONDS);
    (2..2 + HEAVIEST).for_each(|k| normal[(k, k)] += ridge);
    let found = normal.cholesky().ok_or("no fit")?.solve(&x.tr_mul(&y));
    let by = columns(judge) * found;
    let rows = by_cad[1].iter().enumerate();
    let rows = rows.map(|(k, p)| [p[0] + by[2 * k], p[1] + by[2 * k + 1]]);
    Ok(rows.collect())
}
