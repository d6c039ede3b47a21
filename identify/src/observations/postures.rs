//! A posture log in memory: one entry per posture, repeats averaged, noise known, and
//! the context of each posture.
//!
//! ```text
//! reading of n rows    ȳ ± s/√n  (s: of a row)        or ± √(Σ s_k²)/n where rows state s_k
//! ```
//!
//! Rows of one stay that are correlated tell less: s √f(n) ([`super::stays`]), unless what visits
//! differ by says it all.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use sesc_model::Model;
use sesc_model::effects::PostureContext;

use super::approach::Approach;
use super::correlation::Correlation;
use super::criteria::accelerations::APART_S;
use super::criteria::noise::{LEAST_PART, SCATTER};
use super::grouping::{DOWN, moved_sentence};
use super::motion::{Motion, Wanted};
use super::motion_use::MotionUse;
use super::moving::Moving;
use super::noise::{self, Known, LEAST_STD, Noise, NoiseSource};
use super::repeats::Visits;
use super::rows;
use super::stays::of_mean;
use super::zmp::Moved;
use crate::logs::{BLOCK, Samples, Summary, Weight, keep_some};
use crate::watch::{Watch, tell};
use crate::{Error, Message, Setting, message};

pub(crate) mod gathering;

use gathering::{Gathering, Motions, Posture};

/// A reading of which a joint took up more tells nothing of the noise; nor does an axis of whose
/// readings more are such.
const MOST_SPENT: f64 = 0.75;
/// First rows of a log, which say of its noise and its motion what holds for all.
pub(crate) const HEAD: usize = 20_000;

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
    /// What each entry of `reading` is less known by since the position of a joint was taken from
    /// it, m; empty where encoders are believed.
    pub spent: Vec<f64>,
    /// Time of each posture, s.
    pub t: Option<Vec<f64>>,
    /// Noise of a posture's reading on one axis without the floor, m.
    pub noise: f64,
    /// The same with the floor, m.
    pub noise_floor: f64,
    /// What was added to the noise in quadrature, m.
    pub floor: f64,
    /// How long it lasts within the stays of the log, by axis.
    pub within_stays: [Correlation; 2],
    /// Where the noise is known from.
    pub noise_source: NoiseSource,
    /// What postures that were visited again differ by.
    pub visits: Option<Visits>,
    /// The first of the postures here that each is a visit of, under a number of its own; empty
    /// where visits share a number.
    pub first_visits: Vec<usize>,
    /// Foot cells, m.
    pub cells: Vec<[f64; 2]>,
    /// Raw loads were logged.
    pub raw_cells: bool,
    /// The other sole that stands, by the log or its sidecar.
    pub other_foot: Option<String>,
    /// What that has of the load, and that times its CoP on its sole, m; empty where the log does
    /// not have each contact.
    pub other_contact: Vec<[f64; 3]>,
    /// Postures of the log, of which these are an even choice.
    pub postures: usize,
    /// Rows of the log on its support, those that were left out as copies or without contact
    /// not among them. Of a robot that moves not all are here, see `APART_S`.
    pub rows: u64,
    /// Rows of a posture, on average.
    pub rows_per_posture: f64,
    /// What the reader says about the log; none of postures that were given.
    pub summary: Option<Summary>,
    /// Rows of the log that stand on another link, by that link.
    pub elsewhere: BTreeMap<String, u64>,
    /// What is odd about the log.
    pub warnings: Vec<Message>,
    /// How the joints move, where the log is dense enough in time to know.
    pub motion: Option<Motion>,
    /// What that adds to readings, where they are compared with the ZMP.
    pub moved: Option<Arc<Moved>>,
    /// How motion counts.
    pub motion_use: MotionUse,
    /// What the robot weighs, where the log has its total force.
    pub weight: Option<Weight>,
}

impl Postures {
    /// The postures of a log that stand on the model's support. `noise` is that of a single reading
    /// on one axis, m, where the user says; `floor`, m, is added to the noise in quadrature: encoder
    /// ticks.
    ///
    /// # Errors
    /// As [`Rows::block`]; a log without a posture on that link; when `watch` stops it.
    pub fn read(
        samples: &Samples,
        model: &Model,
        noise: (Option<f64>, f64),
        watch: &mut dyn Watch,
    ) -> Result<Postures, Error> {
        let data = Postures::read_some(samples, model, noise, watch)?;
        data.ok_or_else(|| {
            let message = message![
                format!(
                    "no posture stands on `{}`; name another link by ",
                    model.support()
                ),
                Setting::Support
            ];
            Error::log(samples.log.name(), None, message)
        })
    }

    /// The same; none of a log without a posture on that link.
    ///
    /// # Errors
    /// As [`Rows::block`]; when `watch` stops it.
    pub fn read_some(
        samples: &Samples,
        model: &Model,
        (noise, floor): (Option<f64>, f64),
        watch: &mut dyn Watch,
    ) -> Result<Option<Postures>, Error> {
        let (dof, sidecar) = (samples.dof(), &samples.sidecar);
        let mut reader = Moving::planned(samples.rows()?, dof, HEAD, Wanted::Changes)?;
        let support = model.support();
        let mut gathering = Gathering::new(samples.options.any_unit);
        let mut approach = Approach::of(&model.tree.dofs);
        let [mut stated, mut timed, mut raw, mut contacts] = [false; 4];
        let (mut elsewhere, mut taken) = (BTreeMap::<String, u64>::new(), 0_u64);
        // Time and number of the posture that was taken last.
        let (mut last, moves) = ((f64::NEG_INFINITY, 0), reader.plan.is_some());
        loop {
            let (block, motion) = reader.rows(BLOCK)?;
            if block.is_empty() {
                break;
            }
            let (done, total) = reader.log.progress();
            tell(watch, "reading", done, total)?;
            stated |= block.std.is_some();
            timed |= block.t.is_some();
            raw |= block.cells.is_some();
            contacts |= block.other.is_some();
            let positions = motion.as_ref().map_or(&block.q, |motion| &motion.positions);
            for k in 0..block.len() {
                let q = &positions[k * dof..(k + 1) * dof];
                let sides = approach.at(q);
                let on = block.support.as_ref().map_or("", |all| &all[k]);
                if !on.is_empty() && on != support {
                    *elsewhere.entry(on.to_string()).or_default() += 1;
                    continue;
                }
                taken += 1;
                let now = (block.t.as_ref().map_or(0.0, |all| all[k]), block.pose[k]);
                if moves && now.1 != last.1 && (0.0..APART_S).contains(&(now.0 - last.0)) {
                    continue;
                }
                last = now;
                let reading = block.reading.as_ref().map_or([0.0; 2], |all| all[k]);
                let std = block.std.as_ref().map_or([1.0; 2], |all| all[k]);
                let std = std.map(|s| s.max(LEAST_STD));
                let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
                let row = Posture {
                    pose: now.1,
                    rows: 1.0,
                    q: q.to_vec(),
                    sum: reading,
                    variance: std.map(|s| s * s),
                    t: now.0,
                    tilt: rows::tilt(gravity),
                    other: block.other.as_ref().map_or([0.0; 3], |all| all[k]),
                    moving: Motions::of(motion.as_ref(), k, dof),
                    sides: sides.to_vec(),
                };
                gathering.push(row, gravity, std);
            }
        }
        gathering.close();
        if gathering.kept.is_empty() {
            return Ok(None);
        }
        if reader.plan.is_none() || gathering.known.is_of_stays() {
            gathering.join_reached_again(model);
        }
        let single = (1.0 - reader.log.averaged()).sqrt();
        let noise = noise.map(|noise| noise * single);
        let mut data = Postures::of(dof, &gathering, (stated, timed), (noise, floor));
        data.cells = sidecar.cells.clone().unwrap_or_default();
        data.raw_cells = raw;
        data.weight = samples.weight;
        data.other_foot = sidecar.other_foot.clone();
        if contacts {
            let mean = |posture: &Posture| posture.other.map(|sum| sum / posture.rows);
            data.other_contact = gathering.kept.iter().map(mean).collect();
        }
        data.motion_use.step_s = reader.step_s;
        data.motion_use.too_fast = reader.plan.as_ref().is_some_and(|plan| plan.is_too_coarse);
        data.motion = reader.plan.is_some().then(|| gathering.motion(dof));
        data.summary = reader.log.summary();
        data.rows = taken;
        data.warnings
            .splice(0..0, reader.log.warnings.iter().cloned());
        let moved = gathering.known.moved();
        if moved > 0 {
            let file = samples.log.name();
            data.warnings
                .push(format!("{file}: {}", moved_sentence(moved)).into());
        }
        data.elsewhere = elsewhere;
        Ok(Some(data))
    }

    /// Postures and readings of known noise (m, one axis), `floor` beside it.
    #[doc(hidden)]
    pub fn given(dof: usize, q: &[f64], reading: &[f64], noise: f64, floor: f64) -> Postures {
        let pose: Vec<i64> = (0..reading.len() as i64 / 2).collect();
        Postures::of_rows(dof, (&pose, q, reading), Some(noise), floor)
    }

    /// Rows with the number of their posture, their joint positions and readings; `noise` of a
    /// row on one axis (m) where it is known otherwise than by repeats, `floor` beside it.
    pub fn of_rows(
        dof: usize,
        (pose, q, reading): (&[i64], &[f64], &[f64]),
        noise: Option<f64>,
        floor: f64,
    ) -> Postures {
        let mut gathering = Gathering::new(false);
        let rows = q.chunks_exact(dof).zip(reading.chunks_exact(2)).zip(pose);
        for ((q, y), pose) in rows {
            let row = Posture {
                pose: *pose,
                rows: 1.0,
                q: q.to_vec(),
                sum: [y[0], y[1]],
                variance: [1.0; 2],
                ..Posture::default()
            };
            gathering.push(row, DOWN, [1.0; 2]);
        }
        gathering.close();
        Postures::of(dof, &gathering, (false, false), (noise, floor))
    }

    fn of(
        dof: usize,
        gathering: &Gathering,
        (stated, timed): (bool, bool),
        (given, floor): (Option<f64>, f64),
    ) -> Postures {
        let all = &gathering.kept;
        let layout = PostureContext::with_joints(dof);
        let count = all.len();
        let mut data = Postures {
            pose: all.iter().map(|p| p.pose).collect(),
            q: Vec::with_capacity(count * dof),
            posture_context: vec![0.0; count * layout.len()],
            reading: Vec::with_capacity(2 * count),
            std: vec![f64::NAN; 2 * count],
            less_known: Vec::new(),
            spent: Vec::new(),
            t: timed.then(|| all.iter().map(|p| p.t).collect()),
            noise: f64::NAN,
            noise_floor: f64::NAN,
            floor,
            within_stays: [Correlation::NONE; 2],
            noise_source: NoiseSource::Residuals,
            visits: gathering.repeats.visits(),
            first_visits: gathering.first_visits.clone(),
            cells: Vec::new(),
            raw_cells: false,
            other_foot: None,
            other_contact: Vec::new(),
            postures: gathering.repeats.postures as usize,
            rows: count as u64,
            rows_per_posture: all.iter().map(|p| p.rows).sum::<f64>() / count.max(1) as f64,
            summary: None,
            elsewhere: BTreeMap::new(),
            warnings: Vec::new(),
            motion: None,
            moved: None,
            motion_use: MotionUse::default(),
            weight: None,
        };
        data.know_noise(gathering, stated, given);
        for (k, posture) in all.iter().enumerate() {
            let u = &mut data.posture_context[k * layout.len()..(k + 1) * layout.len()];
            u[layout.place()] = gathering.place(k, timed);
            u[layout.time()] = gathering.since(k, timed);
            for (joint, side) in posture.sides.iter().enumerate() {
                u[layout.approach(joint)] = side / posture.rows;
            }
            for axis in 0..2 {
                u[layout.tilt(axis)] = posture.tilt[axis];
                data.reading.push(posture.sum[axis] / posture.rows);
            }
            let [rates, accelerations, ..] = &posture.moving.sums;
            let pairs = rates.iter().zip(accelerations).enumerate();
            for (joint, (rate, acceleration)) in pairs {
                u[layout.rate(joint)] = rate / posture.moving.rows;
                u[layout.acceleration(joint)] = acceleration / posture.moving.rows;
            }
            data.q.extend(posture.mean());
        }
        data
    }

    /// Take the noise from what is known before anything is fitted; where nothing is, what a fit
    /// leaves tells it later ([`Postures::take_noise`]). Rows of a log without times are independent.
    fn know_noise(&mut self, gathering: &Gathering, stated: bool, given: Option<f64>) {
        let all = &gathering.kept;
        let pure = gathering.repeats.pure();
        let rows: f64 = all.iter().map(|p| p.rows).sum();
        let variance = || all.iter().flat_map(|p| p.variance).sum::<f64>();
        let known = Known {
            given,
            stated: stated.then(|| (variance() / (2.0 * rows)).sqrt()),
            repeats: pure.both(),
        };
        let Some(noise) = Noise::known(&known) else {
            return;
        };
        let repeats = noise.source == NoiseSource::Repeats;
        let of_axis = match repeats && !stated {
            true => pure.by_axis(),
            false => [1.0; 2],
        };
        if self.t.is_some() && !(repeats && gathering.repeats.by_visits()) {
            self.within_stays = gathering.stays.correlation();
        }
        for (axis, within) in self.within_stays.iter().enumerate() {
            let mut own: Vec<f64> = match stated {
                true => all
                    .iter()
                    .map(|p| p.variance[axis].sqrt() / p.rows)
                    .collect(),
                false => all.iter().map(|p| 1.0 / p.rows.sqrt()).collect(),
            };
            // Stated deviations that are all about alike are estimates of the same number, and their
            // mean square is a better one than each.
            let together = rms(own.iter().copied());
            if stated && rms(own.iter().map(|s| s - together)) < SCATTER * together {
                own.fill(together);
            }
            // The scatter about the means of stays has lost the slow part of the noise.
            let row = if repeats {
                within.variance.max(1.0)
            } else {
                1.0
            };
            for (k, posture) in all.iter().enumerate() {
                let worth = within
                    .process
                    .map_or(1.0, |_| row * posture.rows * of_mean(within, posture.rows));
                self.std[2 * k + axis] = own[k] * noise.sigma * of_axis[axis] * worth.sqrt();
            }
        }
        self.noise = rms(self.std.iter().copied());
        self.noise_floor = self.noise.hypot(self.floor);
        self.noise_source = noise.source;
        self.warnings.extend(noise.warning().map(Message::from));
        self.std
            .iter_mut()
            .for_each(|std| *std = std.hypot(self.floor));
    }

    /// Take the noise of each axis from what a fit that took up `taken` of the readings
    /// left, m; a few odd readings do not count.
    pub fn take_noise(&mut self, left: &[f64], taken: f64) {
        let share = (1.0 - taken / left.len() as f64).max(0.1).sqrt();
        let floor = self.floor.max(1e-6);
        // Part of the variance of a reading that the position of a joint took up.
        let part = |row: usize| {
            self.spent.chunks_exact(2).nth(row / 2).map_or(0.0, |pair| {
                let all: f64 = pair.iter().map(|x| x * x).sum();
                pair[row % 2] * pair[row % 2] / all.max(f64::MIN_POSITIVE)
            })
        };
        let own = [0, 1].map(|axis| -> Vec<f64> {
            let own = left.iter().enumerate().skip(axis).step_by(2);
            let own = own.map(|(row, left)| (part(row), left));
            own.filter(|(part, _)| *part <= MOST_SPENT)
                .map(|(part, left)| left / (1.0 - part).sqrt())
                .collect()
        });
        // An axis that is spent has the noise of the other.
        let least = (1.0 - MOST_SPENT) * (left.len() / 2) as f64;
        let few = |axis: usize| (own[axis].len() as f64) < least;
        let axes = [0, 1].map(|axis| {
            let of = if few(axis) { 1 - axis } else { axis };
            let size = noise::scale(&own[of]) / share;
            // What readings are less known by is in what is left, and added below.
            let known = rms(self.less_known.iter().skip(axis).step_by(2).copied());
            (size * size - known * known)
                .max(LEAST_PART * size * size)
                .sqrt()
        });
        self.noise = rms(axes.into_iter());
        let moved = self.moved.iter();
        let moved = moved.flat_map(|moved| moved.std.as_flattened());
        self.noise_floor = self.noise.hypot(floor).hypot(rms(moved.copied()));
        for (row, std) in self.std.iter_mut().enumerate() {
            *std = axes[row % 2].hypot(floor);
        }
        add_noise(&mut self.std, &self.less_known);
        add_noise(&mut self.std, &self.spent);
    }

    /// What motion makes readings less known by, as far as a fit that took up `taken` of the readings
    /// left more in motion than at rest, m: polynomials bend what is fast, and count it as noise of
    /// positions.
    ///
    /// ```text
    /// e² = σ² + f² s²        least squares, f² and two of its deviations, ≤ 1        s: what is said
    /// ```
    pub fn limit_motion_noise(&mut self, left: &[f64], taken: f64) {
        let Some(moved) = &mut self.moved else { return };
        let share = (1.0 - taken / left.len() as f64).max(0.1).sqrt();
        let is_known = self.noise_source != NoiseSource::Residuals;
        let factors = [0, 1].map(|axis| {
            let own = left.iter().skip(axis).step_by(2);
            let own: Vec<f64> = own.map(|e| e / share).collect();
            let count = own.len() as f64;
            let said: Vec<f64> = moved.std.iter().map(|std| std[axis] * std[axis]).collect();
            let mean = said.iter().sum::<f64>() / count;
            let spread = said.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>();
            let pull = own.iter().zip(&said).map(|(e, s)| e * e * (s - mean));
            let size = noise::scale(&own).powi(2);
            // Squares of normal values scatter by √2 of their mean; what is said stands unless that
            // is not the reason.
            let unsure = 2.0 * std::f64::consts::SQRT_2 * size / spread.sqrt();
            // What is more than known noise is motion's before it is anything else's.
            let over_noise = match is_known {
                true => {
                    let stds = self.std.iter().skip(axis).step_by(2);
                    size - stds.map(|std| std * std).sum::<f64>() / count + mean
                }
                false => 0.0,
            };
            let by_motion = match spread > 1e-6 * count * mean * mean {
                true => (pull.sum::<f64>() / spread + unsure)
                    .max(over_noise / mean)
                    .clamp(0.0, 1.0),
                false => 1.0,
            };
            // Odd values do not count.
            let most = (1.0 - LEAST_PART) * size / mean;
            by_motion.min(most).sqrt()
        });
        if factors == [1.0; 2] {
            return;
        }
        let known = self.std.iter_mut().zip(&mut self.less_known).enumerate();
        for (row, (std, less)) in known {
            let (own, factor) = (moved.std[row / 2][row % 2], factors[row % 2]);
            let over = own * own * (1.0 - factor * factor);
            *std = (*std * *std - over).max(0.0).sqrt();
            *less = (*less * *less - over).max(0.0).sqrt();
        }
        let said = |moved: &Moved| rms(moved.std.as_flattened().iter().copied());
        let before = said(moved);
        for std in &mut Arc::make_mut(moved).std {
            *std = [0, 1].map(|axis| std[axis] * factors[axis]);
        }
        let over = before.powi(2) - said(moved).powi(2);
        self.noise_floor = (self.noise_floor.powi(2) - over).max(0.0).sqrt();
    }

    /// The noise of each axis is `factors` times as large as it was taken to be.
    pub fn scale_noise(&mut self, factors: [f64; 2]) {
        for (row, std) in self.std.iter_mut().enumerate() {
            *std *= factors[row % 2];
        }
        let overall = rms(factors.into_iter());
        self.noise *= overall;
        self.noise_floor *= overall;
    }

    /// Leave out postures whose motion is not known.
    pub fn leave_out_unknown(&mut self) {
        if let Some(motion) = &self.motion {
            let keep = motion.known.clone();
            self.keep(&keep);
        }
    }

    /// Leave out the postures that are false in `keep`.
    pub fn keep(&mut self, keep: &[bool]) {
        let width = self.q.len() / keep.len().max(1);
        let context = self.posture_context.len() / keep.len().max(1);
        keep_some(&mut self.pose, 1, keep);
        keep_some(&mut self.q, width, keep);
        keep_some(&mut self.posture_context, context, keep);
        keep_some(&mut self.reading, 2, keep);
        keep_some(&mut self.std, 2, keep);
        keep_some(&mut self.less_known, 2, keep);
        keep_some(&mut self.spent, 2, keep);
        keep_some(&mut self.other_contact, 1, keep);
        self.t.iter_mut().for_each(|t| keep_some(t, 1, keep));
        let mut firsts = HashMap::new();
        keep_some(&mut self.first_visits, 1, keep);
        for (k, first) in self.first_visits.iter_mut().enumerate() {
            *first = *firsts.entry(*first).or_insert(k);
        }
        if let Some(motion) = &mut self.motion {
            motion.keep(keep);
        }
    }

    /// Readings are those of a robot that is `moved`.
    pub fn move_by(&mut self, moved: Moved) {
        let less_known = moved.std.as_flattened();
        self.noise_floor = self.noise_floor.hypot(rms(less_known.iter().copied()));
        add_noise(&mut self.std, less_known);
        self.less_known.resize(less_known.len(), 0.0);
        add_noise(&mut self.less_known, less_known);
        self.tell_moved(moved);
    }

    /// The same where the noise of motion is counted already.
    pub fn tell_moved(&mut self, moved: Moved) {
        let count = self.len().max(1);
        let width = self.posture_context.len() / count;
        let layout = PostureContext::with_joints(self.q.len() / count);
        let contexts = self.posture_context.chunks_exact_mut(width.max(1));
        for (k, context) in contexts.enumerate() {
            moved.tell(k, layout, context);
        }
        self.moved = Some(Arc::new(moved));
    }

    /// A joint is at `positions`, whatever its encoder says: readings were spent on that, each
    /// of which is `less_known` since, m.
    pub fn put_joint(&mut self, joint: usize, positions: &[f64], less_known: &[f64]) {
        let width = self.q.len() / self.len().max(1);
        let own = self.q.iter_mut().skip(joint).step_by(width.max(1));
        own.zip(positions).for_each(|(q, at)| *q = *at);
        add_noise(&mut self.std, less_known);
        self.spent = less_known.to_vec();
    }

    /// The log with what motion adds taken from its readings.
    pub fn standing(&self) -> Postures {
        let mut data = self.clone();
        if let Some(moved) = &self.moved {
            let pairs = data.reading.iter_mut().zip(moved.shift.as_flattened());
            pairs.for_each(|(reading, shift)| *reading -= shift);
        }
        data
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

/// Add noise to deviations, in quadrature.
fn add_noise(std: &mut [f64], by: &[f64]) {
    let pairs = std.iter_mut().zip(by);
    pairs.for_each(|(std, by)| *std = std.hypot(*by));
}

/// Least and largest of some values.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.fold(none, |(low, high), x| (low.min(x), high.max(x)))
}

/// Root of the mean square; zero of nothing.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, n), x| (sum + x * x, n + 1.0));
    f64::sqrt(sum / f64::max(count, 1.0))
}
