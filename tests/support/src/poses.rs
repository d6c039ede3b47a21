//! The postures of one log, and those that were put aside.
//!
//! Still postures are numbered as they were taken; a third of them was put
//! aside at random to try a model on, so that a log's numbers have gaps.

use std::f64::consts::PI;

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Track, World};

use crate::stage::{Postures, Stage};

/// A log's postures in the order of their numbers.
pub struct Poses {
    /// Where the joints are over time.
    pub track: Track,
    /// Number of every posture.
    pub numbers: Vec<f64>,
    /// Time of every posture, s.
    pub times: Option<Vec<f64>>,
    /// Postures between them that the log does not have; none of a motion.
    pub aside: Vec<(f64, Vec<f64>)>,
}

impl Poses {
    /// Draws postures of this kind for the robot of `stage`.
    pub fn draw(
        stage: &Stage,
        postures: Postures,
        degrees: bool,
        random: &mut ChaCha8Rng,
    ) -> Poses {
        let count = postures.count();
        let still = match postures {
            Postures::Motion(_) => return Self::moving(stage, count, random),
            Postures::Bench(_) => stage.balanced(count + count / 2, random),
            Postures::Wide(_) => stage.wide(count + count / 2, random),
        };
        let unit = if degrees { 180.0 / PI } else { 1.0 };
        let mut taken: Vec<(f64, Vec<f64>)> = still
            .into_iter()
            .enumerate()
            .map(|(n, q)| (n as f64, q.into_iter().map(|q| q * unit).collect()))
            .collect();
        let mut aside = Vec::new();
        while taken.len() > count {
            // The first and the last stay: they say how long the log is.
            aside.push(taken.remove(random.random_range(1..taken.len() - 1)));
        }
        let (numbers, postures): (Vec<f64>, _) = taken.into_iter().unzip();
        Poses {
            track: Track::still(postures).numbered(numbers.clone()),
            numbers,
            times: None,
            aside,
        }
    }

    fn moving(stage: &Stage, count: usize, random: &mut ChaCha8Rng) -> Poses {
        let mut t = 1.0;
        let times: Vec<f64> = (0..count)
            .map(|_| {
                t += 0.12 + 0.06 * random.random::<f64>();
                (t * 1000.0_f64).round() / 1000.0
            })
            .collect();
        Poses {
            track: Track::moving(times.clone(), stage.motion(random)),
            numbers: (0..count).map(|i| i as f64).collect(),
            times: Some(times),
            aside: Vec::new(),
        }
    }

    /// What the sensor would have said about the postures put aside, m.
    pub fn read_aside(&self, world: &World) -> Vec<[f64; 2]> {
        let (numbers, postures): (Vec<f64>, Vec<Vec<f64>>) = self.aside.iter().cloned().unzip();
        let (Some(first), Some(last)) = (self.numbers.first(), self.numbers.last()) else {
            return Vec::new();
        };
        // Between the log's own ends, so that a drift has its length.
        let ends = self.track.postures();
        let all = [&ends[..1], &postures, &ends[ends.len() - 1..]].concat();
        let numbers = [&[*first], &numbers[..], &[*last]].concat();
        let readings = world.readings(&Track::still(all).numbered(numbers));
        let inner = readings.into_iter().skip(1).take(self.aside.len());
        inner.map(|reading| reading.cop).collect()
    }
}
