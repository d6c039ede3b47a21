//! One pass over posture logs: everything a fit needs, in memory that does not
//! depend on the number of postures.
//!
//! Postures are dealt into folds by their `pose`, so that repeated readings and visits
//! stay together, or by blocks of time where no posture comes back; each fold keeps its
//! own factors, and cross-validation needs no second pass:
//!
//! ```text
//! held-out error of fold k = ‖R_k r_(−k) − z_k‖² + ρ_k²        r_(−k) from the other folds
//! ```

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use super::robust::Robust;
use super::timing::Timing;
use crate::Error;
use crate::feet::ClosureFound;
use crate::health::Finding;
use crate::logs::{Block, Weight};
use crate::observations::correlation::{Independent, Whitener};
use crate::observations::grouping::{DOWN, Grouping};
use crate::observations::motion_use::MotionUse;
use crate::observations::noise::{Known, LEAST_STD};
use crate::observations::repeats::Repeats;
use crate::observations::revisits::Again;
use crate::observations::row_matrix::RowMatrix;
use crate::observations::rows::{ByMotion, Measurement, Rows};
use crate::observations::sample_count;

/// A log that was read.
pub use sesc_model::DataUsed as LogUsed;

mod fold;
mod merge;

pub(super) use fold::Fold;
use fold::Goal;
pub(super) use fold::{Work, fold_in};

/// A posture that a robust fit trusts less.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DownWeighted {
    /// Name of the log.
    pub file: String,
    /// Line or row of the log.
    pub line: u64,
    /// Its number in the log.
    pub pose: i64,
    /// 0 to 1.
    pub weight: f64,
    /// |measured − fitted|, m.
    pub residual: f64,
}

/// What passes over the logs leave.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Gathered {
    /// Sums of each fold; every posture belongs to one.
    pub folds: Vec<Fold>,
    /// Repeated readings, for the noise.
    #[serde(rename = "replicates")]
    pub repeats: Repeats,
    /// Σ of stated variances over rows and axes, m²; 0 where none are stated.
    pub stated: f64,
    /// Rows of logs with both axes.
    pub readings: u64,
    /// The logs that were read.
    pub logs: Vec<LogUsed>,
    /// Postures that a robust loss trusts less.
    pub down_weighted: Vec<DownWeighted>,
    /// Σ of robust weights over rows of logs: all of them in a plain fit.
    pub trusted: f64,
    /// What robust weights leave of the mean square of normal noise; 1 in a plain fit.
    pub consistency: f64,
    /// Rows that share a `pose` with an earlier row but not its joint positions.
    pub moved: u64,
    /// Logs with more postures than can be known: those that come back later count anew.
    pub overfull: u64,
    /// Σ over rows of what averaging took off the variance of a single reading, as a
    /// part of it: 0 where every reading is a row, 0.99 where rows are means of 100.
    pub averaged: f64,
    /// Rows whose stated deviation no sensor has.
    pub tiny: u64,
    /// What is wrong with the logs themselves.
    pub health: Vec<Finding>,
    /// What rows are worth.
    pub samples: sample_count::Sum,
    /// Σ over rows of each axis' variance: stated, or in units of both axes' mean.
    pub axes: [f64; 2],
    /// Rows were freed of their correlation: repeats within a visit are no noise.
    pub correlated: bool,
    /// How the motion of the joints counted.
    pub motion: MotionUse,
    /// How the soles of both feet lie on one floor, of the log in which they lie worst.
    pub closure: Option<ClosureFound>,
    /// Postures to reach once more, where nothing tells the noise.
    pub again: Option<Again>,
    /// What the robot weighs, of the log in which it is farthest from its URDF.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<Weight>,
    #[serde(skip)]
    pub(super) postures: Grouping,
    #[serde(skip)]
    pub(super) stream: Stream,
}

/// One row in this many of a long log is also counted as it is, beside independent samples.
const PLAIN: usize = 4;
/// Down-weighted postures that are listed, at most.
const LISTED: usize = 1000;

impl Gathered {
    /// Sums without data, for `params` parameters and `folds` folds.
    pub fn new(params: usize, folds: usize) -> Gathered {
        Gathered {
            folds: vec![Fold::new(params); folds.max(2)],
            consistency: 1.0,
            ..Gathered::default()
        }
    }

    /// Number of parameters.
    pub fn params(&self) -> usize {
        self.folds[0].weighted.params()
    }

    /// Whether rows carry deviations of their own.
    pub fn has_deviations(&self) -> bool {
        self.stated > 0.0
    }

    /// What is known of the noise of a row; `given` is that of a single reading, m.
    pub fn known_noise(&self, given: Option<f64>) -> Known {
        let rows = self.readings.max(1) as f64;
        let single = (1.0 - self.averaged / rows).max(0.0).sqrt();
        Known {
            given: given.map(|noise| noise * single),
            stated: self
                .has_deviations()
                .then(|| (self.stated / (2.0 * rows)).sqrt()),
            repeats: match self.correlated {
                true => (0.0, 0),
                false => self.repeats.pure().both(),
            },
        }
    }

    /// Noise of each axis in units of their RMS.
    pub fn noise_by_axis(&self) -> [f64; 2] {
        let rows = self.axes[0] + self.axes[1];
        self.axes.map(|axis| match rows > 0.0 {
            true => (2.0 * axis / rows).sqrt(),
            false => 1.0,
        })
    }

    /// A log begins whose noise is like `timing` says; without, its rows are independent.
    pub fn begin_log(&mut self, timing: &Timing) {
        self.stream = Stream::new(timing);
        let freed = self.stream.whiteners.is_some() || timing.trust < 1.0;
        self.correlated |= freed;
        // Rows do not count as they are.
        if freed || timing.axes != [1.0; 2] {
            for fold in &mut self.folds {
                fold.part_plain();
            }
        }
    }

    /// Fold in a block of the log that was opened last.
    ///
    /// # Errors
    /// When the block has no readings, or deviations where others had none.
    pub fn push(
        &mut self,
        measurement: &mut Measurement,
        block: &Block,
        file: &str,
        robust: Option<(&Robust, &DVector<f64>)>,
    ) -> Result<(), Error> {
        let rows = measurement.rows(block)?;
        let work = self.take(block, rows, file, robust)?;
        fold_in(&work, &mut self.folds);
        Ok(())
    }

    /// Sum up a block with its `rows`, but for what is left to be folded in.
    ///
    /// # Errors
    /// As [`Gathered::push`].
    pub(super) fn take(
        &mut self,
        block: &Block,
        rows: Rows,
        file: &str,
        robust: Option<(&Robust, &DVector<f64>)>,
    ) -> Result<Vec<Work>, Error> {
        let bad = |message: &str| Error::log(file, None, message);
        let readings = block
            .reading
            .as_ref()
            .ok_or_else(|| bad("no readings; give columns cop_x, cop_y or foot cells fsr_1, …"))?;
        if self.readings > 0 && block.std.is_some() != self.has_deviations() {
            return Err(bad(
                "some logs state deviations (cop_x_std, …) and some do not; \
                 add the columns or leave them out of all",
            ));
        }
        let std = self.deviations(block, &rows);
        self.stream.moving.0 += rows.motion.len();
        let shifts = rows.motion.iter().flat_map(|shift| shift.read);
        self.stream.moving.1 += shifts.map(|x| x * x).sum::<f64>();
        self.readings += block.len() as u64;
        let trust = match robust {
            None => vec![1.0; block.len()],
            Some((robust, params)) => {
                let weights = robust.weights(&rows, &std, params);
                self.consistency = robust.consistency();
                let residual = rows.residual(params);
                let distrusted = (0..block.len()).filter(|k| weights[*k] < 0.5);
                let listed = distrusted.map(|k| DownWeighted {
                    file: file.to_string(),
                    line: block.line[k],
                    pose: block.pose[k],
                    weight: weights[k],
                    residual: residual[2 * k].hypot(residual[2 * k + 1]),
                });
                let room = LISTED - self.down_weighted.len();
                self.down_weighted.extend(listed.take(room));
                weights
            }
        };
        let (first, moved) = (self.stream.rows, self.postures.moved());
        let mut keys = Vec::with_capacity(block.len());
        for k in 0..block.len() {
            let support = block.support.as_ref().map_or("", |all| &all[k]);
            let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
            let name = (block.pose[k], support);
            let posture = self.postures.of_row(name, block.joints(k), gravity);
            let t = block.t.as_ref().map(|all| all[k]);
            keys.push(self.stream.timing.key(posture.key, t));
            // A reading that a robust fit rejects is no repeat.
            if trust[k] >= 0.5 {
                let visit = posture.visits;
                self.repeats
                    .push(&mut posture.group, visit, readings[k], std[k]);
            }
            for (sum, std) in self.axes.iter_mut().zip(std[k]) {
                *sum += std * std;
            }
            if block.std.is_some() {
                self.stated += std[k][0] * std[k][0] + std[k][1] * std[k][1];
            }
        }
        self.moved += self.postures.moved() - moved;
        self.stream.rows += block.len();
        if self.stream.whiteners.is_some() {
            let t = block.t.as_deref().unwrap_or_default();
            let independent = self.stream.push(t, &rows, &keys, &std, &trust);
            let every = if self.stream.timing.long { PLAIN } else { 1 };
            let plain = (0..block.len()).filter(|k| (first + k).is_multiple_of(every));
            let plain = plain.flat_map(|k| [2 * k, 2 * k + 1].map(|row| (keys[k], row, 1.0)));
            let plain = self.deal((rows.matrix, rows.reading), plain, Goal::Plain);
            let freed = self.deal_independent(&independent);
            return Ok(freed.into_iter().chain([plain]).collect());
        }
        let counts = self.stream.timing.trust;
        self.trusted += counts * trust.iter().sum::<f64>();
        let weighed = (0..block.len()).flat_map(|k| {
            let weight = |axis: usize| (counts * trust[k]).sqrt() / std[k][axis];
            [0, 1].map(|axis| (keys[k], 2 * k + axis, weight(axis)))
        });
        Ok(vec![self.deal(
            (rows.matrix, rows.reading),
            weighed,
            Goal::Both,
        )])
    }

    /// Rows to their folds: each with the key that deals it, its number and its weight.
    fn deal(
        &self,
        (matrix, reading): (RowMatrix, DVector<f64>),
        dealt: impl Iterator<Item = (i64, usize, f64)>,
        goal: Goal,
    ) -> Work {
        let mut shares = vec![Vec::new(); self.folds.len()];
        for (key, row, weight) in dealt {
            let fold = self.stream.timing.fold(key, shares.len());
            shares[fold].push((row, weight));
        }
        Work {
            matrix,
            reading,
            shares,
            goal,
        }
    }

    /// Independent rows of the stream, each of one axis, to their folds.
    fn deal_independent(&mut self, independent: &[Independent]) -> Option<Work> {
        let columns = independent.first()?.row.len() - 1;
        let entries = independent.iter().flat_map(|row| &row.row[..columns]);
        let entries = entries.copied().collect();
        let reading = independent.iter().map(|row| row.row[columns]);
        let reading = DVector::from_vec(reading.collect());
        let weighed = independent.iter().enumerate();
        let weighed = weighed.map(|(k, row)| (row.key, k, row.trust.sqrt()));
        self.trusted += 0.5 * independent.iter().map(|row| row.trust).sum::<f64>();
        let matrix = RowMatrix { entries, columns };
        Some(self.deal((matrix, reading), weighed, Goal::Weighted))
    }

    /// Deviations of a block's rows, m; in units of both axes' RMS where none are stated.
    fn deviations(&mut self, block: &Block, rows: &Rows) -> Vec<[f64; 2]> {
        let Some(stated) = &block.std else {
            return vec![self.stream.timing.axes; block.len()];
        };
        let small = |std: &&[f64; 2]| std.iter().any(|s| *s < LEAST_STD);
        self.tiny += stated.iter().filter(small).count() as u64;
        let floored = stated.iter().map(|std| std.map(|s| s.max(LEAST_STD)));
        let mut all: Vec<[f64; 2]> = floored.collect();
        for (std, ByMotion { std: own, .. }) in all.iter_mut().zip(&rows.motion) {
            *std = [std[0].hypot(own[0]), std[1].hypot(own[1])];
        }
        all
    }

    /// The log that was read, `left_out` of whose rows do not know their motion, has ended:
    /// poses of the next one are others. Where the robot stands, postures that were reached again
    /// under another number are visits of one.
    ///
    /// # Errors
    /// As [`Measurement::rows`].
    pub(super) fn end_log(
        &mut self,
        measurement: &mut Measurement,
        left_out: u64,
    ) -> Result<(), Error> {
        if self.stream.timing.plan.is_none() || self.postures.is_of_stays() {
            measurement.join_reached_again(&mut self.repeats, &self.postures)?;
        }
        let independent = self.stream.end();
        let work = self.deal_independent(&independent);
        fold_in(work.as_slice(), &mut self.folds);
        let stream = std::mem::take(&mut self.stream);
        let timing = &stream.timing;
        let rows = stream.rows as u64 + left_out;
        self.samples.push(rows, &timing.correlation, timing.timed);
        let (moving, square) = stream.moving;
        self.motion.merge(&MotionUse {
            used: square > 0.0,
            rms_m: match moving {
                0 => timing.motion.rms_m,
                moving => (square / (2 * moving) as f64).sqrt(),
            },
            rows_left_out: left_out,
            ..timing.motion.clone()
        });
        self.overfull += u64::from(self.postures.full());
        self.postures.clear();
        Ok(())
    }
}

/// State between the blocks of a log.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Stream {
    timing: Timing,
    /// Rows so far.
    rows: usize,
    /// Rows in motion, and the square sum of what it adds to their readings, m².
    moving: (usize, f64),
    /// Of each axis, where rows are freed of their correlation.
    whiteners: Option<[Whitener; 2]>,
}

impl Stream {
    fn new(timing: &Timing) -> Stream {
        let processes = timing.correlation.map(|axis| axis.process);
        let whiteners = processes.map(|process| Whitener::new(process.unwrap_or_default()));
        Stream {
            whiteners: processes.iter().any(Option::is_some).then_some(whiteners),
            timing: timing.clone(),
            ..Stream::default()
        }
    }

    /// The independent rows that a block's rows complete: each has a time, the key that deals it
    /// to its fold, deviations, m or in units of both axes' RMS, and a trust, 0 to 1.
    fn push(
        &mut self,
        t: &[f64],
        rows: &Rows,
        keys: &[i64],
        std: &[[f64; 2]],
        trust: &[f64],
    ) -> Vec<Independent> {
        let params = rows.matrix.columns;
        let Timing { axes, freed, .. } = &self.timing;
        let (mut row, mut ended) = (vec![0.0; params + 1], Vec::new());
        for (k, &t) in t.iter().enumerate() {
            for (axis, whitener) in self.whiteners.iter_mut().flatten().enumerate() {
                let weight = axes[axis] / freed[axis] / std[k][axis];
                for (to, from) in row.iter_mut().zip(rows.matrix.row(2 * k + axis)) {
                    *to = from * weight;
                }
                row[params] = rows.reading[2 * k + axis] * weight;
                ended.extend(whitener.push(t, keys[k], &row, trust[k]));
            }
        }
        ended
    }

    /// The independent rows that the end of the log completes.
    fn end(&mut self) -> Vec<Independent> {
        let whiteners = self.whiteners.iter_mut().flatten();
        whiteners.flat_map(Whitener::end).collect()
    }
}
