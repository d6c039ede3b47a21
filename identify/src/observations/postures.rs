//! A posture log in memory: one entry per posture, repeats averaged, noise known, and
//! the context of each posture.
//!
//! ```text
//! reading of n rows    ȳ ± s/√n  (s: of a row)        or ± √(Σ s_k²)/n where rows state s_k
//! ```

use sesc_model::Model;
use sesc_model::effects::PostureContext;

use super::grouping::{DOWN, Grouping, moved_sentence};
use super::noise::{LEAST_STD, NoiseSource};
use super::repeats::{Group, Repeats, Visits};
use super::rows;
use crate::logs::{LogSource, Options, PostureReader, Summary};
use crate::watch::{Watch, tell};
use crate::{Error, Message, Setting, message};

mod known;

use known::Noise;

/// Rows taken at once.
const BLOCK: usize = 4096;
/// Postures that a diagnosis looks at, up to twice this; evenly chosen of more.
pub const MOST: usize = 2000;

/// Postures and readings in memory.
#[derive(Debug, Clone)]
pub struct Postures {
    /// Number of each posture in the log.
    pub pose: Vec<i64>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// Posture by posture, see [`PostureContext`].
    pub posture_context: Vec<f64>,
    /// x, y per posture, m.
    pub reading: Vec<f64>,
    /// Standard deviation of each entry of `reading`, the floor included, m.
    pub std: Vec<f64>,
    /// What each entry is less known by for reasons of its own, m; empty where for none.
    pub less_known: Vec<f64>,
    /// Time of each posture, s.
    pub t: Option<Vec<f64>>,
    /// Noise of a posture's reading on one axis without the floor, m.
    pub noise: f64,
    /// The same with the floor, m.
    pub noise_floor: f64,
    /// What was added to the noise in quadrature, m.
    pub floor: f64,
    /// Where the noise is known from.
    pub noise_source: NoiseSource,
    /// What postures that were visited again differ by.
    pub visits: Option<Visits>,
    /// Foot cells, m.
    pub cells: Vec<[f64; 2]>,
    /// Raw loads were logged.
    pub raw_cells: bool,
    /// Postures of the log, of which these are an even choice.
    pub postures: usize,
    /// What the reader says about the log; none of postures that were given.
    pub summary: Option<Summary>,
    /// What is odd about the log.
    pub warnings: Vec<Message>,
}

/// One posture while its rows are gathered.
#[derive(Clone)]
struct Posture {
    pose: i64,
    rows: f64,
    q: Vec<f64>,
    sum: [f64; 2],
    /// Σ of stated variances, m².
    variance: [f64; 2],
    t: f64,
    tilt: [f64; 2],
    /// Neighbours in the log: time and joints.
    before: Option<(f64, Vec<f64>)>,
    after: Option<(f64, Vec<f64>)>,
}

impl Posture {
    fn mean(&self) -> Vec<f64> {
        self.q.iter().map(|sum| sum / self.rows).collect()
    }
}

/// Postures of a log of any length in bounded memory: every `stride`-th is kept,
/// and `stride` doubles whenever they are too many. An even choice keeps the
/// order, the times and the range.
struct Gathering {
    /// Postures number 0, `stride`, 2 `stride`, ….
    kept: Vec<Posture>,
    stride: usize,
    /// The number of each posture and its readings, for rows that come back to it.
    known: Grouping<(Option<usize>, Group)>,
    repeats: Repeats,
    /// Postures that are whole, and the one that rows belong to now.
    seen: usize,
    current: Option<Posture>,
    last: Option<(f64, Vec<f64>)>,
    first: Option<(i64, f64)>,
    /// Whether pose numbers rise all along.
    rising: bool,
    end: (i64, f64),
}

impl Gathering {
    fn new(any_unit: bool) -> Gathering {
        Gathering {
            kept: Vec::new(),
            stride: 1,
            known: match any_unit {
                true => Grouping::of_any_unit(),
                false => Grouping::default(),
            },
            repeats: Repeats::default(),
            seen: 0,
            current: None,
            last: None,
            first: None,
            rising: true,
            end: (0, 0.0),
        }
    }

    /// A row with gravity along `gravity` and its deviation (1 where none is stated), m.
    fn push(&mut self, row: Posture, gravity: [f64; 3], std: [f64; 2]) {
        let next = self.seen + usize::from(self.current.is_some());
        let (posture, _) = self.known.of_row((row.pose, ""), &row.q, gravity);
        let visit = posture.visits;
        let (number, group) = &mut posture.own;
        self.repeats.push(group, visit, row.sum, std);
        let number = *number.get_or_insert(next);
        if let Some(current) = self.current.as_mut().filter(|_| number == self.seen) {
            join(current, &row);
            return;
        }
        self.close();
        if number == next {
            self.current = Some(row);
        } else if number.is_multiple_of(self.stride) {
            // Back at an old posture: more readings of it.
            join(&mut self.kept[number / self.stride], &row);
        }
    }

    /// The posture at hand is whole.
    fn close(&mut self) {
        let Some(mut posture) = self.current.take() else {
            return;
        };
        let own = (posture.t, posture.mean());
        if let Some(before) = self.kept.last_mut().filter(|p| p.after.is_none())
            && self.last.as_ref().is_some_and(|last| last.0 == before.t)
        {
            before.after = Some(own.clone());
        }
        posture.before = self.last.replace(own);
        self.rising &= self.seen == 0 || posture.pose > self.end.0;
        self.first.get_or_insert((posture.pose, posture.t));
        self.end = (posture.pose, posture.t);
        if self.seen.is_multiple_of(self.stride) {
            self.kept.push(posture);
            if self.kept.len() > 2 * MOST {
                self.thin();
            }
        }
        self.seen += 1;
    }

    fn thin(&mut self) {
        self.stride *= 2;
        let kept = std::mem::take(&mut self.kept);
        self.kept = kept.into_iter().step_by(2).collect();
    }
}

fn join(posture: &mut Posture, row: &Posture) {
    posture.rows += row.rows;
    for (sum, q) in posture.q.iter_mut().zip(&row.q) {
        *sum += q;
    }
    for axis in 0..2 {
        posture.sum[axis] += row.sum[axis];
        posture.variance[axis] += row.variance[axis];
    }
}

/// How a log is to be taken.
#[derive(Debug, Clone)]
pub struct Taking {
    /// How the log is to be read.
    pub options: Options,
    /// Standard deviation of a single reading on one axis, m, where the user says.
    pub noise: Option<f64>,
    /// Added to the noise in quadrature, m: encoder ticks.
    pub floor: f64,
}

impl Postures {
    /// Read a log of readings on the model's support.
    ///
    /// # Errors
    /// As [`PostureReader`]; a log without a posture on that link; when `watch` stops it.
    pub fn read(
        log: impl Into<LogSource>,
        model: &Model,
        taking: &Taking,
        watch: &mut dyn Watch,
    ) -> Result<Postures, Error> {
        let log = log.into();
        let dofs = &model.tree.dofs;
        let mut reader = PostureReader::open(&log, dofs, &taking.options)?;
        let support = &model.tree.links[model.tree.support].name;
        let mut gathering = Gathering::new(taking.options.any_unit);
        let (mut stated, mut timed, mut raw) = (false, false, false);
        let mut elsewhere = 0_u64;
        let dof = dofs.len();
        loop {
            let block = reader.block(BLOCK)?;
            if block.is_empty() {
                break;
            }
            let (done, total) = reader.progress();
            tell(watch, "reading", done, total)?;
            stated |= block.std.is_some();
            timed |= block.t.is_some();
            raw |= block.cells.is_some();
            for k in 0..block.len() {
                let on = block.support.as_ref().map_or("", |all| &all[k]);
                if !on.is_empty() && on != support {
                    elsewhere += 1;
                    continue;
                }
                let reading = block.reading.as_ref().map_or([0.0; 2], |all| all[k]);
                let std = block.std.as_ref().map_or([1.0; 2], |all| all[k]);
                let std = std.map(|s| s.max(LEAST_STD));
                let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
                let row = Posture {
                    pose: block.pose[k],
                    rows: 1.0,
                    q: block.q[k * dof..(k + 1) * dof].to_vec(),
                    sum: reading,
                    variance: std.map(|s| s * s),
                    t: block.t.as_ref().map_or(0.0, |all| all[k]),
                    tilt: rows::tilt(gravity),
                    before: None,
                    after: None,
                };
                gathering.push(row, gravity, std);
            }
        }
        gathering.close();
        if gathering.kept.is_empty() {
            let message = message![
                format!("no posture stands on `{support}`; name another link by "),
                Setting::Support
            ];
            return Err(Error::log(log.name(), None, message));
        }
        let single = (1.0 - reader.averaged()).sqrt();
        let own = Taking {
            noise: taking.noise.map(|noise| noise * single),
            ..taking.clone()
        };
        let mut data = Postures::of(dof, &gathering, stated, timed, &own);
        data.cells = reader.sidecar.cells.clone().unwrap_or_default();
        data.raw_cells = raw;
        data.summary = reader.summary();
        data.warnings.splice(0..0, reader.warnings.iter().cloned());
        let moved = gathering.known.moved();
        if moved > 0 {
            let file = log.name();
            data.warnings
                .push(format!("{file}: {}", moved_sentence(moved)).into());
        }
        if elsewhere > 0 {
            let left_out = "rows stand on another link and are left out; diagnose them with ";
            data.warnings.push(message![
                format!("{}: {elsewhere} {left_out}", log.name()),
                Setting::Support
            ]);
        }
        Ok(data)
    }

    /// Postures and readings of known noise (m, one axis), `floor` beside it.
    pub fn given(dof: usize, q: &[f64], reading: &[f64], noise: f64, floor: f64) -> Postures {
        let mut gathering = Gathering::new(false);
        for (k, (q, y)) in q.chunks_exact(dof).zip(reading.chunks_exact(2)).enumerate() {
            let row = Posture {
                pose: k as i64,
                rows: 1.0,
                q: q.to_vec(),
                sum: [y[0], y[1]],
                variance: [1.0; 2],
                t: 0.0,
                tilt: [0.0; 2],
                before: None,
                after: None,
            };
            gathering.push(row, DOWN, [1.0; 2]);
        }
        gathering.close();
        let taking = Taking {
            options: Options::default(),
            noise: Some(noise),
            floor,
        };
        Postures::of(dof, &gathering, false, false, &taking)
    }

    fn of(
        dof: usize,
        gathering: &Gathering,
        stated: bool,
        timed: bool,
        taking: &Taking,
    ) -> Postures {
        let all = &gathering.kept;
        let noise = Noise::of(gathering, stated, taking.noise);
        let layout = PostureContext::with_joints(dof);
        let count = all.len();
        let mut data = Postures {
            pose: all.iter().map(|p| p.pose).collect(),
            q: Vec::with_capacity(count * dof),
            posture_context: vec![0.0; count * layout.len()],
            reading: Vec::with_capacity(2 * count),
            std: Vec::with_capacity(2 * count),
            less_known: Vec::new(),
            t: timed.then(|| all.iter().map(|p| p.t).collect()),
            noise: noise.overall,
            noise_floor: noise.overall.hypot(taking.floor),
            floor: taking.floor,
            noise_source: noise.source,
            visits: gathering.repeats.visits(),
            cells: Vec::new(),
            raw_cells: false,
            postures: gathering.seen,
            summary: None,
            warnings: noise.warning.into_iter().map(Message::from).collect(),
        };
        for (k, posture) in all.iter().enumerate() {
            let q = posture.mean();
            let u = &mut data.posture_context[k * layout.len()..(k + 1) * layout.len()];
            u[layout.place()] = gathering.place(k, timed);
            for axis in 0..2 {
                u[layout.tilt(axis)] = posture.tilt[axis];
                data.reading.push(posture.sum[axis] / posture.rows);
                data.std.push(noise.per_entry[k][axis].hypot(taking.floor));
            }
            if timed {
                for joint in 0..dof {
                    let [rate, acceleration] = motion(posture, &q, joint);
                    u[layout.rate(joint)] = rate;
                    u[layout.acceleration(joint)] = acceleration;
                }
            }
            data.q.extend(q);
        }
        data
    }

    /// Take the noise of each axis from what a fit that took up `taken` of the readings
    /// left, m: by the median, so that a few odd readings do not count.
    pub fn take_noise(&mut self, left: &[f64], taken: f64) {
        let share = (1.0 - taken / left.len() as f64).max(0.1).sqrt();
        let floor = self.floor.max(1e-6);
        let axes = [0, 1].map(|axis| {
            let own = left.iter().skip(axis).step_by(2);
            let mut sizes: Vec<f64> = own.map(|e| e.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            // The median of |N(0, 1)|.
            let median = sizes.get(sizes.len() / 2);
            median.map_or(0.0, |m| m / 0.674_489_750_196 / share)
        });
        self.noise = rms(axes.into_iter());
        self.noise_floor = self.noise.hypot(floor);
        for (row, std) in self.std.iter_mut().enumerate() {
            *std = axes[row % 2].hypot(floor);
        }
        let own = self.less_known.iter();
        for (std, own) in self.std.iter_mut().zip(own) {
            *std = std.hypot(*own);
        }
    }

    /// Count each reading for less known by `by`, m.
    pub fn trust_less(&mut self, by: Vec<f64>) {
        for (std, own) in self.std.iter_mut().zip(&by) {
            *std = std.hypot(*own);
        }
        self.less_known = by;
    }

    /// Postures.
    pub fn len(&self) -> usize {
        self.pose.len()
    }

    /// Whether there are no postures.
    pub fn is_empty(&self) -> bool {
        self.pose.is_empty()
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

impl Gathering {
    /// Place of a posture in the log, 0 to 1: by time, by number where numbers
    /// rise, else by order.
    fn place(&self, k: usize, timed: bool) -> f64 {
        let (first, end) = (self.first.unwrap_or_default(), self.end);
        let posture = &self.kept[k];
        let (from, to, at) = match (timed, self.rising) {
            (true, _) => (first.1, end.1, posture.t),
            (false, true) => (first.0 as f64, end.0 as f64, posture.pose as f64),
            (false, false) => (0.0, self.seen as f64 - 1.0, (k * self.stride) as f64),
        };
        if to > from {
            (at - from) / (to - from)
        } else {
            0.0
        }
    }
}

/// Velocity and acceleration of a joint, by the parabola through a posture and
/// its neighbours in time; at the ends of a log by the line to the one there is.
fn motion(posture: &Posture, q: &[f64], joint: usize) -> [f64; 2] {
    let slope = |(t, other): &(f64, Vec<f64>)| {
        let time = t - posture.t;
        (time != 0.0).then(|| ((other[joint] - q[joint]) / time, time.abs()))
    };
    let left = posture.before.as_ref().and_then(slope);
    let right = posture.after.as_ref().and_then(slope);
    match (left, right) {
        (Some((left, before)), Some((right, after))) => [
            (left * after + right * before) / (before + after),
            2.0 * (right - left) / (before + after),
        ],
        (Some((slope, _)), None) | (None, Some((slope, _))) => [slope, 0.0],
        (None, None) => [0.0; 2],
    }
}
