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
use super::stream::Stream;
use super::timing::Timing;
use crate::Error;
use crate::feet::ClosureFound;
use crate::health::Finding;
use crate::logs::{Block, Weight};
use crate::observations::correlation::Independent;
use crate::observations::grouping::{DOWN, Grouping, Visit};
use crate::observations::motion::Motion;
use crate::observations::motion_use::MotionUse;
use crate::observations::noise::{Known, LEAST_STD};
use crate::observations::repeats::{Group, Repeats};
use crate::observations::revisits::Again;
use crate::observations::row_matrix::RowMatrix;
use crate::observations::rows::{ByMotion, Measurement, Rows};
use crate::observations::sample_count;

/// A log that was read.
pub use sesc_model::DataUsed as LogUsed;

mod fold;
mod folding;
mod merge;
mod together;

pub use fold::Fold;
pub(super) use folding::Folding;
use folding::{Goal, Share, Work};

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
    pub(super) postures: Grouping<Group>,
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
        self.correlated |= self.stream.whitens() || timing.trust < 1.0;
        // Rows do not count as they are.
        if self.stream.whitens() || timing.axes != [1.0; 2] || timing.trust < 1.0 {
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
        let mut here = Folding::default();
        self.push_moving(measurement, (block, None), file, robust, &mut here)
    }

    /// The same with the motion of the block's joints, on the threads of `folding`.
    ///
    /// # Errors
    /// As [`Gathered::push`].
    pub(super) fn push_moving(
        &mut self,
        measurement: &mut Measurement,
        (block, motion): (&Block, Option<&Motion>),
        file: &str,
        robust: Option<(&Robust, &DVector<f64>)>,
        folding: &mut Folding,
    ) -> Result<(), Error> {
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
        let rows = measurement.moving_rows(block, motion)?;
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
                self.name_outliers(block, &rows, &weights, params, file);
                weights
            }
        };
        let dof = measurement.model().dof();
        let (first, by_time) = (self.stream.rows, self.stream.keys(block));
        let mut keys = Vec::with_capacity(block.len());
        for k in 0..block.len() {
            let support = block.support.as_ref().map_or("", |all| &all[k]);
            let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
            let q = &block.q[k * dof..(k + 1) * dof];
            let name = (block.pose[k], support);
            let (posture, visit) = self.postures.of_row(name, q, gravity);
            let first = self.stream.timing.first_visits.get(&posture.key);
            let key = *first.unwrap_or(&posture.key);
            keys.push(by_time.as_ref().map_or(key, |keys| keys[k]));
            // A reading that a robust fit rejects is no repeat.
            if trust[k] >= 0.5 {
                let visit = posture.visits;
                self.repeats
                    .push(&mut posture.own, visit, readings[k], std[k]);
            }
            for (sum, std) in self.axes.iter_mut().zip(std[k]) {
                *sum += std * std;
            }
            self.moved += u64::from(visit == Visit::Moved);
            if block.std.is_some() {
                self.stated += std[k][0] * std[k][0] + std[k][1] * std[k][1];
            }
        }
        self.stream.rows += block.len();
        let rows_of = |k: usize| [2 * k, 2 * k + 1];
        if self.stream.whitens() {
            let t = block.t.as_deref().unwrap_or_default();
            let independent = self.stream.push(t, &rows, &keys, &std, &trust);
            self.deal_independent(&independent, folding);
            let every = if self.stream.timing.long { PLAIN } else { 1 };
            let plain = (0..block.len()).filter(|k| (first + k).is_multiple_of(every));
            let plain = plain.flat_map(|k| rows_of(k).map(|row| (keys[k], row, 1.0)));
            self.deal(rows, plain, folding, |_| Goal::Plain);
            return Ok(());
        }
        let counts = self.stream.timing.trust;
        self.trusted += counts * trust.iter().sum::<f64>();
        let weighed = (0..block.len()).flat_map(|k| {
            let weight = |axis: usize| (counts * trust[k]).sqrt() / std[k][axis];
            [0, 1].map(|axis| (keys[k], rows_of(k)[axis], weight(axis)))
        });
        // The deviation that all rows of a fold have, if it is one.
        let each = |rows: &Share| {
            let each = std[rows.first()?.0 / 2][0];
            let is_it = |k: usize| counts * trust[k] == 1.0 && std[k] == [each; 2];
            rows.iter().all(|(row, _)| is_it(row / 2)).then_some(each)
        };
        self.deal(rows, weighed, folding, |shares| {
            Goal::Both(shares.iter().map(each).collect())
        });
        Ok(())
    }

    /// Rows to their folds: each with the key that deals it, its number and its weight.
    fn deal(
        &mut self,
        rows: Rows,
        dealt: impl Iterator<Item = (i64, usize, f64)>,
        folding: &mut Folding,
        goal: impl FnOnce(&[Share]) -> Goal,
    ) {
        let mut shares = vec![Share::new(); self.folds.len()];
        for (key, row, weight) in dealt {
            let fold = self.stream.fold(key, shares.len());
            shares[fold].push((row, weight));
        }
        let work = Work {
            matrix: rows.matrix,
            reading: rows.reading,
            goal: goal(&shares),
            shares,
        };
        folding.push(work, &mut self.folds);
    }

    /// Independent rows of the stream, each of one axis, to their folds.
    fn deal_independent(&mut self, independent: &[Independent], folding: &mut Folding) {
        let Some(first) = independent.first() else {
            return;
        };
        let params = first.row.len() - 1;
        let entries = independent.iter().flat_map(|row| &row.row[..params]);
        let rows = Rows {
            matrix: RowMatrix {
                entries: entries.copied().collect(),
                columns: params,
            },
            reading: DVector::from_fn(independent.len(), |row, _| independent[row].row[params]),
            motion: Vec::new(),
        };
        let weighed = independent.iter().enumerate();
        let weighed = weighed.map(|(k, row)| (row.key, k, row.trust.sqrt()));
        self.deal(rows, weighed, folding, |_| Goal::Weighted);
        self.trusted += 0.5 * independent.iter().map(|row| row.trust).sum::<f64>();
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
        mut folding: Folding,
    ) -> Result<(), Error> {
        if self.stream.timing.plan.is_none() || self.postures.is_of_stays() {
            measurement.join_reached_again(&mut self.repeats, &self.postures)?;
        }
        let independent = self.stream.end();
        self.deal_independent(&independent, &mut folding);
        folding.end(&mut self.folds);
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

    fn name_outliers(
        &mut self,
        block: &Block,
        rows: &Rows,
        weights: &[f64],
        params: &DVector<f64>,
        file: &str,
    ) {
        let residual = rows.residual(params);
        for (k, &weight) in weights.iter().enumerate() {
            if weight < 0.5 && self.down_weighted.len() < LISTED {
                self.down_weighted.push(DownWeighted {
                    file: file.to_string(),
                    line: block.line[k],
                    pose: block.pose[k],
                    weight,
                    residual: residual[2 * k].hypot(residual[2 * k + 1]),
                });
            }
        }
    }
}
