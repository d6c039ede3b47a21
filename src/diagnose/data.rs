//! A posture log as the diagnosis sees it: one entry per posture, repeats
//! averaged, noise known, and what each posture brings along.

use std::collections::BTreeMap;
use std::path::Path;

use sesc_codegen::effects::Circumstances;
use sesc_codegen::{Model, tree::Dof};

use crate::Error;
use crate::posture_log::{Options, PostureReader, Summary};

/// Rows taken at once.
const BLOCK: usize = 4096;
/// Postures that a diagnosis looks at; evenly chosen of more.
pub const MOST: usize = 4000;
/// Stated deviations that scatter less than this are estimates of one number.
const SCATTER: f64 = 0.15;

/// Postures and readings in memory.
#[derive(Debug, Clone)]
pub struct Data {
    pub pose: Vec<i64>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// Posture by posture, see [`Circumstances`].
    pub circumstances: Vec<f64>,
    /// x, y per posture, m.
    pub reading: Vec<f64>,
    /// Standard deviation of each entry of `reading`, the floor included, m.
    pub std: Vec<f64>,
    /// Time of each posture, s.
    pub t: Option<Vec<f64>>,
    /// Noise of a posture's reading on one axis without and with the floor, m.
    pub noise: f64,
    pub noise_floor: f64,
    /// Where the noise is known from.
    pub noise_source: NoiseSource,
    /// Foot cells, m.
    pub cells: Vec<[f64; 2]>,
    /// Raw loads were logged.
    pub raw_cells: bool,
    /// Postures of the log, of which these are an even choice.
    pub postures: usize,
    pub summary: Option<Summary>,
    pub warnings: Vec<String>,
}

/// Where the size of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseSource {
    /// Columns of standard deviations.
    Stated,
    /// Repeated readings of postures.
    Repeats,
    /// The command line.
    Given,
    /// Nowhere: what the best model with free masses leaves.
    Residuals,
}

/// One posture while its rows are gathered.
struct Posture {
    rows: f64,
    q: Vec<f64>,
    sum: [f64; 2],
    squares: [f64; 2],
    weight: [f64; 2],
    t: f64,
    tilt: [f64; 2],
}

/// How a log is to be taken.
#[derive(Debug, Clone)]
pub struct Taking {
    pub options: Options,
    /// Noise of one posture's reading on one axis, m, where the user says.
    pub noise: Option<f64>,
    /// Added to the noise in quadrature, m: encoder ticks.
    pub floor: f64,
}

impl Data {
    /// Read a log of readings on the model's support.
    ///
    /// # Errors
    /// As [`PostureReader`]; a log that stands on several links.
    pub fn read(path: &Path, model: &Model, taking: &Taking) -> Result<Data, Error> {
        let dofs = &model.tree.dofs;
        let mut reader = PostureReader::open(path, dofs, &taking.options)?;
        let mut postures: BTreeMap<usize, Posture> = BTreeMap::new();
        let mut order: BTreeMap<i64, usize> = BTreeMap::new();
        let mut pose = Vec::new();
        let (mut stated, mut timed, mut raw) = (false, false, false);
        loop {
            let block = reader.block(BLOCK)?;
            if block.is_empty() {
                break;
            }
            stated |= block.std.is_some();
            timed |= block.t.is_some();
            raw |= block.cells.is_some();
            let dof = dofs.len();
            for k in 0..block.len() {
                let at = *order.entry(block.pose[k]).or_insert_with(|| {
                    pose.push(block.pose[k]);
                    pose.len() - 1
                });
                let q = &block.q[k * dof..(k + 1) * dof];
                let reading = block.reading.as_ref().map_or([0.0; 2], |all| all[k]);
                let std = block.std.as_ref().map_or([0.0; 2], |all| all[k]);
                let gravity = block
                    .gravity
                    .as_ref()
                    .map_or([0.0, 0.0, -1.0], |all| all[k]);
                let posture = postures.entry(at).or_insert_with(|| Posture {
                    rows: 0.0,
                    q: vec![0.0; dof],
                    sum: [0.0; 2],
                    squares: [0.0; 2],
                    weight: [0.0; 2],
                    t: block.t.as_ref().map_or(0.0, |all| all[k]),
                    tilt: [-gravity[0] / gravity[2], -gravity[1] / gravity[2]],
                });
                posture.rows += 1.0;
                for (sum, q) in posture.q.iter_mut().zip(q) {
                    *sum += q;
                }
                for axis in 0..2 {
                    posture.sum[axis] += reading[axis];
                    posture.squares[axis] += reading[axis] * reading[axis];
                    posture.weight[axis] += std[axis] * std[axis];
                }
            }
        }
        let all: Vec<Posture> = postures.into_values().collect();
        let mut data = Data::gather(dofs, &pose, &all, stated, timed, taking);
        data.cells = reader.sidecar.cells.clone().unwrap_or_default();
        data.raw_cells = raw;
        data.summary = reader.summary();
        data.warnings = reader.warnings.clone();
        Ok(data)
    }

    fn gather(
        dofs: &[Dof],
        pose: &[i64],
        all: &[Posture],
        stated: bool,
        timed: bool,
        taking: &Taking,
    ) -> Data {
        let n = all.len();
        let noise = Noise::of(all, stated, taking);
        // An even choice keeps the order, the times and the range.
        let chosen: Vec<usize> = match n <= MOST {
            true => (0..n).collect(),
            false => (0..MOST).map(|k| k * (n - 1) / (MOST - 1)).collect(),
        };
        let dof = dofs.len();
        let layout = Circumstances::with_joints(dof);
        let count = chosen.len();
        let mut data = Data {
            pose: chosen.iter().map(|&k| pose[k]).collect(),
            q: Vec::with_capacity(count * dof),
            circumstances: vec![0.0; count * layout.len()],
            reading: Vec::with_capacity(2 * count),
            std: Vec::with_capacity(2 * count),
            t: timed.then(|| chosen.iter().map(|&k| all[k].t).collect()),
            noise: noise.overall,
            noise_floor: noise.overall.hypot(taking.floor),
            noise_source: noise.source,
            cells: Vec::new(),
            raw_cells: false,
            postures: n,
            summary: None,
            warnings: Vec::new(),
        };
        let place = places(pose, all, timed);
        let motion = timed.then(|| motion(all, dof));
        for (row, &k) in chosen.iter().enumerate() {
            let posture = &all[k];
            data.q
                .extend(posture.q.iter().map(|sum| sum / posture.rows));
            let u = &mut data.circumstances[row * layout.len()..(row + 1) * layout.len()];
            u[layout.place()] = place[k];
            for axis in 0..2 {
                u[layout.tilt(axis)] = posture.tilt[axis];
                data.reading.push(posture.sum[axis] / posture.rows);
                data.std.push(noise.of_posture(k, axis).hypot(taking.floor));
            }
            if let Some(motion) = &motion {
                for joint in 0..dof {
                    let [rate, acceleration] = motion[k * dof + joint];
                    u[layout.rate(joint)] = rate;
                    u[layout.acceleration(joint)] = acceleration;
                }
            }
        }
        data
    }

    /// Postures.
    pub fn len(&self) -> usize {
        self.pose.len()
    }

    pub fn is_empty(&self) -> bool {
        self.pose.is_empty()
    }
}

/// Noise of the mean reading of each posture.
struct Noise {
    per_entry: Vec<[f64; 2]>,
    overall: f64,
    source: NoiseSource,
}

impl Noise {
    fn of(all: &[Posture], stated: bool, taking: &Taking) -> Noise {
        let constant = |std: f64, source| Noise {
            per_entry: all.iter().map(|p| [std / p.rows.sqrt(); 2]).collect(),
            overall: rms(all.iter().map(|p| std / p.rows.sqrt())),
            source,
        };
        if let Some(noise) = taking.noise {
            return Noise {
                per_entry: vec![[noise; 2]; all.len()],
                overall: noise,
                source: NoiseSource::Given,
            };
        }
        if stated {
            return Noise::stated(all);
        }
        let mut pure = (0.0, 0.0);
        for posture in all.iter().filter(|p| p.rows > 1.0) {
            for axis in 0..2 {
                let mean = posture.sum[axis] / posture.rows;
                pure.0 += (posture.squares[axis] - posture.rows * mean * mean).max(0.0);
                pure.1 += posture.rows - 1.0;
            }
        }
        match pure.1 >= 10.0 {
            true => constant((pure.0 / pure.1).sqrt(), NoiseSource::Repeats),
            // Filled in later from what is left over.
            false => constant(f64::NAN, NoiseSource::Residuals),
        }
    }

    /// Deviations that are all about alike are estimates of the same number,
    /// and their mean square is a better one than each.
    fn stated(all: &[Posture]) -> Noise {
        let own = |p: &Posture, axis: usize| (p.weight[axis]).sqrt() / p.rows;
        let mut per_entry: Vec<[f64; 2]> = all.iter().map(|p| [own(p, 0), own(p, 1)]).collect();
        for axis in 0..2 {
            let together = rms(per_entry.iter().map(|s| s[axis]));
            let away = rms(per_entry.iter().map(|s| s[axis] - together));
            if away < SCATTER * together {
                per_entry.iter_mut().for_each(|s| s[axis] = together);
            }
        }
        Noise {
            overall: rms(per_entry.iter().flatten().copied()),
            per_entry,
            source: NoiseSource::Stated,
        }
    }

    fn of_posture(&self, k: usize, axis: usize) -> f64 {
        self.per_entry[k][axis]
    }
}

/// Root of the mean square; zero of nothing.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
    if count > 0.0 {
        f64::sqrt(sum / count)
    } else {
        0.0
    }
}

/// Place of each posture in the log, 0 to 1: by time, by number where numbers
/// rise, else by order.
fn places(pose: &[i64], all: &[Posture], timed: bool) -> Vec<f64> {
    let by_number = pose.windows(2).all(|pair| pair[0] < pair[1]);
    let raw: Vec<f64> = match (timed, by_number) {
        (true, _) => all.iter().map(|p| p.t).collect(),
        (false, true) => pose.iter().map(|&p| p as f64).collect(),
        (false, false) => (0..all.len()).map(|k| k as f64).collect(),
    };
    let (first, last) = (raw[0], raw[raw.len() - 1]);
    let length = if last > first { last - first } else { 1.0 };
    raw.iter().map(|x| (x - first) / length).collect()
}

/// Velocity and acceleration of every joint at every posture, by the parabola
/// through a posture and its neighbours in time.
fn motion(all: &[Posture], dof: usize) -> Vec<[f64; 2]> {
    let n = all.len();
    let mut motion = vec![[0.0; 2]; n * dof];
    if n < 3 {
        return motion;
    }
    for k in 0..n {
        let middle = k.clamp(1, n - 2);
        let [a, b, c] = [middle - 1, middle, middle + 1];
        let (before, after) = (all[b].t - all[a].t, all[c].t - all[b].t);
        if !(before > 0.0 && after > 0.0) {
            continue;
        }
        let ahead = all[k].t - all[b].t;
        for j in 0..dof {
            let q = |i: usize| all[i].q[j] / all[i].rows;
            let (left, right) = ((q(b) - q(a)) / before, (q(c) - q(b)) / after);
            let acceleration = 2.0 * (right - left) / (before + after);
            let rate = (left * after + right * before) / (before + after);
            motion[k * dof + j] = [rate + ahead * acceleration, acceleration];
        }
    }
    motion
}
