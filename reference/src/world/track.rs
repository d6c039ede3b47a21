//! What a log holds besides one posture: an order, and perhaps motion.
//!
//! ```text
//! u    = (number - first) / (last - first)          how far the log has come
//! φ(t) = motion(t + delay)                          angles that were written down late
//! q(t) ≈ cubics, tangents those of parabolas        motion known by its samples alone
//! ```

use std::fmt;
use std::rc::Rc;

use nalgebra::Vector2;

use super::World;
use super::ground::Inertia;
use super::sensor::Outliers;

/// A posture at any time, s.
type Motion = Rc<dyn Fn(f64) -> Vec<f64>>;

/// The joint columns of a log: postures as the encoders have them.
#[derive(Clone)]
pub struct Track {
    postures: Vec<Vec<f64>>,
    numbers: Vec<f64>,
    motion: Option<(Vec<f64>, Motion)>,
}

impl fmt::Debug for Track {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Track")
            .field("postures", &self.postures.len())
            .field("moving", &self.motion.is_some())
            .finish()
    }
}

/// What the sensor says about one posture, without noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The centre of pressure in the support frame, m unless the
    /// [unit](World::sensor_unit) is another.
    pub cop: [f64; 2],
    /// The cells' loads, N, in their order; empty where there are no
    /// [cells](World::cells).
    pub cells_n: Vec<f64>,
}

impl Track {
    /// Postures taken one after the other, at rest.
    pub fn still(postures: Vec<Vec<f64>>) -> Self {
        let numbers = (0..postures.len()).map(|i| i as f64).collect();
        Self {
            postures,
            numbers,
            motion: None,
        }
    }

    /// Postures passed at these times (s, rising) by a motion known at any time.
    pub fn moving(times: Vec<f64>, motion: impl Fn(f64) -> Vec<f64> + 'static) -> Self {
        let postures = times.iter().map(|&t| motion(t)).collect();
        let mut track = Self::still(postures);
        track.motion = Some((times, Rc::new(motion)));
        track
    }

    /// Postures passed at these times (s, rising) by a motion known by them
    /// alone: cubics between, parabolas beyond the ends.
    pub fn sampled(times: Vec<f64>, postures: Vec<Vec<f64>>) -> Self {
        assert_eq!(times.len(), postures.len(), "one time per posture");
        let (at, through) = (times.clone(), postures);
        Self::moving(times, move |t| interpolate(&at, &through, t))
    }

    /// Pose numbers other than 0, 1, 2…: a log may have gaps.
    #[must_use]
    pub fn numbered(mut self, numbers: Vec<f64>) -> Self {
        assert_eq!(numbers.len(), self.postures.len(), "one number per posture");
        self.numbers = numbers;
        self
    }

    /// The postures as the encoders have them.
    pub fn postures(&self) -> &[Vec<f64>] {
        &self.postures
    }

    /// How far the log has come at a posture, 0 to 1.
    fn progress(&self, i: usize) -> f64 {
        let (first, last) = (self.numbers[0], self.numbers[self.numbers.len() - 1]);
        if last > first {
            (self.numbers[i] - first) / (last - first)
        } else {
            0.0
        }
    }
}

/// Cubic Hermite, with the tangents of parabolas through three neighbours.
fn interpolate(times: &[f64], postures: &[Vec<f64>], t: f64) -> Vec<f64> {
    let n = times.len();
    let dof = postures.first().map_or(0, Vec::len);
    if n < 3 {
        return (0..dof).map(|j| line(times, postures, j, t)).collect();
    }
    let left = times.partition_point(|&at| at <= t).clamp(1, n - 1) - 1;
    let parabola = |i: usize, j: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| i.clamp(1, n - 2) - 1 + k);
        let value = |k: usize| postures[k][j];
        let first = (value(b) - value(a)) / (times[b] - times[a]);
        let second = (value(c) - value(b)) / (times[c] - times[b]);
        Parabola {
            from: [times[a], times[b]],
            value: value(a),
            slope: first,
            bend: (second - first) / (times[c] - times[a]),
        }
    };
    if t < times[0] || t > times[n - 1] {
        return (0..dof)
            .map(|j| parabola(left + usize::from(t > times[0]), j).at(t))
            .collect();
    }
    let width = times[left + 1] - times[left];
    let s = (t - times[left]) / width;
    let p = (3.0 - 2.0 * s) * s * s;
    let (v, w) = (((s - 2.0) * s + 1.0) * s, (s - 1.0) * s * s);
    (0..dof)
        .map(|j| {
            let [before, after] = [left, left + 1].map(|i| parabola(i, j).slope_at(times[i]));
            (1.0 - p) * postures[left][j]
                + p * postures[left + 1][j]
                + width * (v * before + w * after)
        })
        .collect()
}

/// One joint through one or two samples.
fn line(times: &[f64], postures: &[Vec<f64>], j: usize, t: f64) -> f64 {
    let (first, last) = (postures[0][j], postures[postures.len() - 1][j]);
    let span = times[times.len() - 1] - times[0];
    if span > 0.0 {
        first + (last - first) * (t - times[0]) / span
    } else {
        first
    }
}

/// Newton's form: `value + slope (t - t_0) + bend (t - t_0)(t - t_1)`.
struct Parabola {
    from: [f64; 2],
    value: f64,
    slope: f64,
    bend: f64,
}

impl Parabola {
    fn at(&self, t: f64) -> f64 {
        let [a, b] = self.from;
        self.value + (t - a) * (self.slope + self.bend * (t - b))
    }

    fn slope_at(&self, t: f64) -> f64 {
        let [a, b] = self.from;
        self.slope + self.bend * (2.0 * t - a - b)
    }
}

/// Half the span over which accelerations are taken, s.
const STEP_S: f64 = 1e-3;

impl World {
    /// The joint angles are written down `delay_s` late: a CoP beside the
    /// angles of time `t` belongs to the posture at `t + delay_s`. Shows in
    /// logs that [move](Track::moving).
    #[must_use]
    pub fn time_delay(mut self, delay_s: f64) -> Self {
        self.delay_s += delay_s;
        self
    }

    /// The robot has not come to rest when it is read: its links' inertia
    /// shifts the CoP. Shows in logs that [move](Track::moving).
    #[must_use]
    pub fn unsettled(mut self) -> Self {
        self.unsettled = true;
        self
    }

    /// What the sensor says all along a log.
    ///
    /// # Panics
    /// As [`World::cop`].
    pub fn readings(&self, track: &Track) -> Vec<Reading> {
        let count = track.postures.len();
        let jumps = match &self.sensor.outliers {
            Some(outliers) => outliers.jumps(count),
            None => vec![Vector2::zeros(); count],
        };
        (0..count)
            .map(|i| self.reading(track, i, jumps[i]))
            .collect()
    }

    fn reading(&self, track: &Track, i: usize, jump: Vector2<f64>) -> Reading {
        let written = &track.postures[i];
        let progress = track.progress(i);
        let Some((times, motion)) = &track.motion else {
            let joints = self.settle(written);
            let pressure = self.pressure(&joints, &Inertia::default());
            return self.sense(written, &pressure, progress, jump);
        };
        let t = times[i] + self.delay_s;
        let q = if self.delay_s == 0.0 {
            written.clone()
        } else {
            motion(t)
        };
        let joints = self.settle(&q);
        let inertia = if self.unsettled {
            let before = self.settle(&motion(t - STEP_S));
            let after = self.settle(&motion(t + STEP_S));
            self.inertia([&before, &joints, &after], STEP_S)
        } else {
            Inertia::default()
        };
        self.sense(&q, &self.pressure(&joints, &inertia), progress, jump)
    }
}

impl Outliers {
    /// How far every posture of a log jumps, m.
    fn jumps(&self, count: usize) -> Vec<Vector2<f64>> {
        let mut random = SplitMix(self.seed);
        let mut order: Vec<usize> = (0..count).collect();
        let wrong = ((self.fraction * count as f64).round() as usize).min(count);
        let mut jumps = vec![Vector2::zeros(); count];
        for k in 0..wrong {
            let rest = (count - k) as f64;
            order.swap(k, k + (random.uniform() * rest) as usize);
            let (sin, cos) = (random.uniform() * std::f64::consts::TAU).sin_cos();
            let size = self.size_m * (0.6 + 0.9 * random.uniform());
            jumps[order[k]] = Vector2::new(cos, sin) * size;
        }
        jumps
    }
}

/// Sebastiano Vigna's SplitMix64: the same numbers on every machine.
struct SplitMix(u64);

impl SplitMix {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
