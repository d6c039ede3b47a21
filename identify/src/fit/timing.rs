//! What the first rows of a log say of its noise: whether it is correlated in time, and
//! on which axis it is larger; and whether readings show the motion of the joints.
//!
//! Rows are made independent as they are read, so this has to be known before: a fit of
//! free masses to the first `ROWS` rows tells, at the cost of reading those twice.

use super::criteria::{HELD_OUT_TIMES, MOST_APART, ROWS_OF_STAY, TO_KNOW_NOISE};
use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

use crate::Error;
use crate::logs::{BLOCK, Block, PostureReader};
use crate::observations::correlation::{self, Correlation};
use crate::observations::criteria::correlation::SHORT;
use crate::observations::criteria::repeats::UNLIKELY;
use crate::observations::grouping::{DOWN, Grouping};
use crate::observations::motion::{Plan, Wanted};
use crate::observations::motion_use::{Column, MotionModel, MotionUse};
use crate::observations::noise::LEAST_STD;
use crate::observations::postures::{HEAD, rms};
use crate::observations::repeats::Repeats;
use crate::observations::row_matrix::RowMatrix;
use crate::observations::rows::{ByMotion, Measurement, Rows};

/// Rows that the share of motion is taken from, at most.
const OF_SHARE: usize = 4000;

/// The noise of a log in time, and its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Correlation in time of each axis.
    pub correlation: [Correlation; 2],
    /// Noise of each axis in units of their RMS.
    pub axes: [f64; 2],
    /// The same of rows that were freed of their correlation.
    pub freed: [f64; 2],
    /// What a row counts: less than one where noise lasts for too much of the log to be told from a
    /// misfit, so that rows are not freed of it.
    pub trust: f64,
    /// Whether times run forward.
    pub timed: bool,
    /// First time and length of the blocks that are held out, s; none where postures are.
    pub blocks: Option<(f64, f64)>,
    /// There are more rows than were looked at.
    pub long: bool,
    /// Keys of postures that were reached again under a number of their own, each with that of
    /// the first visit.
    pub first_visits: BTreeMap<i64, i64>,
    /// How motion is known; none where readings are taken as static.
    pub plan: Option<Plan>,
    /// What is said of it.
    pub motion: MotionUse,
}

impl Default for Timing {
    /// Nothing is known: readings are independent.
    fn default() -> Timing {
        Timing {
            correlation: [Correlation::NONE; 2],
            axes: [1.0; 2],
            freed: [1.0; 2],
            trust: 1.0,
            timed: false,
            blocks: None,
            long: false,
            first_visits: BTreeMap::new(),
            plan: None,
            motion: MotionUse::default(),
        }
    }
}

impl Timing {
    /// What deals a row to its fold: the block of time that it is in where those are held out,
    /// else the `key` of its posture.
    pub fn key(&self, key: i64, t: Option<f64>) -> i64 {
        match self.blocks.zip(t) {
            Some(((start, length), t)) => ((t - start) / length).floor() as i64,
            None => *self.first_visits.get(&key).unwrap_or(&key),
        }
    }

    /// The fold of such a key, of `folds`.
    pub fn fold(&self, key: i64, folds: usize) -> usize {
        match self.blocks {
            Some(_) => key.rem_euclid(folds as i64) as usize,
            None => drawn(key, folds),
        }
    }

    /// Read on until enough is known. `own_axes`: whether axes may differ where the log
    /// states no deviations; `masses`: F of how far these may be off, p × m, and how far they usually
    /// are.
    ///
    /// # Errors
    /// What is wrong with the log.
    pub fn read(
        log: &mut PostureReader,
        measurement: &mut Measurement<'_>,
        (folds, own_axes): (usize, bool),
        motion: MotionModel,
        (masses, usual): (&DMatrix<f64>, &DMatrix<f64>),
    ) -> Result<Timing, Error> {
        let (mut first, mut ended) = (Block::default(), false);
        while first.len() < HEAD && !ended {
            let block = log.block(BLOCK)?;
            ended = block.is_empty() || block.reading.is_none();
            if !ended {
                first.append(block);
            }
        }
        let t = first.t.as_deref().unwrap_or_default();
        let plan = match motion {
            MotionModel::Auto => Plan::of(t, &first.q, measurement.model().dof()),
            MotionModel::Off => None,
        };
        let cad = DVector::from_vec(measurement.model().cad_params());
        let own_axes = own_axes && first.std.is_none();
        let timing = |head: Head| head.timing(folds, own_axes, !ended, (&cad, usual));
        let moving = Head::of(&first, measurement, plan.as_ref())?;
        // RMS of what motion adds to readings, m.
        let seen = rms(moving.motion.iter().flat_map(|by| by.read));
        let column = moving.moves.then(|| moving.column(&cad));
        let found = timing(moving);
        let share = column.and_then(|(column, stride)| {
            let per_sample = rows_per_sample(&found.correlation) / stride;
            column.share(masses, per_sample.max(1.0))
        });
        // A head that stands says nothing of what comes.
        let found = match share.is_some_and(|share| share.is_missing()) {
            true => timing(Head::of(&first, measurement, None)?),
            false => Timing { plan, ..found },
        };
        let plan = found.plan.as_ref();
        Ok(Timing {
            motion: MotionUse {
                too_fast: plan.is_some_and(|plan| plan.is_too_coarse),
                share,
                rms_m: seen,
                step_s: correlation::step(t),
                ..MotionUse::default()
            },
            ..found
        })
    }
}

/// The first rows.
#[derive(Default)]
struct Head {
    t: Vec<f64>,
    /// Rows of each axis over their deviations, and readings.
    axes: [(DMatrix<f64>, DVector<f64>); 2],
    /// Deviations, 1 where none are stated.
    std: Vec<[f64; 2]>,
    postures: Grouping,
    repeats: Repeats,
    /// Rows of each visit of a posture.
    stays: Vec<Range<usize>>,
    /// What motion adds to readings; zero where joints stand.
    motion: Vec<ByMotion>,
    /// Whether joints move.
    moves: bool,
    /// See [`Timing`].
    first_visits: BTreeMap<i64, i64>,
}

impl Head {
    /// Prepare rows whose motion `plan` knows, or rows as they are without a plan.
    fn of(
        first: &Block,
        measurement: &mut Measurement<'_>,
        plan: Option<&Plan>,
    ) -> Result<Head, Error> {
        let mut head = Head::default();
        let (mut entries, mut readings) = (Vec::new(), Vec::<f64>::new());
        let dof = measurement.model().dof();
        let t = first.t.as_deref().unwrap_or_default();
        for start in (0..first.len()).step_by(BLOCK) {
            let rows = start..first.len().min(start + BLOCK);
            let mut block = first.select(rows.clone());
            let motion = |plan: &Plan| plan.motion((t, &first.q, dof), rows, Wanted::Smooth);
            let mut motion = plan.and_then(motion);
            if let Some(motion) = &mut motion {
                motion.leave_out_unknown(&mut block);
            }
            let rows = measurement.moving_rows(&block, motion.as_ref())?;
            head.push(&block, &rows);
            entries.extend(rows.matrix.entries);
            readings.extend(rows.reading.as_slice());
        }
        let columns = measurement.model().base.params.len();
        let all = RowMatrix { entries, columns };
        let n = head.std.len();
        head.axes = [0, 1].map(|axis| {
            let over = |k: usize| 1.0 / head.std[k][axis];
            let x = |k: usize, column: usize| all[(2 * k + axis, column)] * over(k);
            let y = |k: usize, _| readings[2 * k + axis] / head.std[k][axis];
            (DMatrix::from_fn(n, columns, x), DVector::from_fn(n, y))
        });
        if plan.is_none() || head.postures.is_of_stays() {
            let joined = measurement.join_reached_again(&mut head.repeats, &head.postures)?;
            let pairs = joined.iter().flatten().enumerate();
            head.first_visits = pairs
                .filter(|(k, first)| *first < k)
                .map(|(k, first)| [k, *first].map(|k| head.postures.posture(k).key).into())
                .collect();
        }
        Ok(head)
    }

    /// What motion adds to some of the rows, over their deviations, and of how many rows each
    /// is one; readings less those of `cad`.
    fn column(&self, cad: &DVector<f64>) -> (Column, f64) {
        let stride = self.std.len().div_ceil(OF_SHARE).max(1);
        let chosen = (0..self.std.len()).step_by(stride);
        let chosen: Vec<_> = chosen.flat_map(|k| [(k, 0), (k, 1)]).collect();
        let rows = DMatrix::from_fn(chosen.len(), cad.len(), |row, column| {
            let (k, axis) = chosen[row];
            self.axes[axis].0[(k, column)]
        });
        let reading = chosen.iter().map(|(k, axis)| self.axes[*axis].1[*k]);
        let reading = DVector::from_vec(reading.collect());
        let over_std = |of: fn(&ByMotion) -> [f64; 2]| {
            let over = chosen.iter();
            over.map(|&(k, axis)| of(&self.motion[k])[axis] / self.std[k][axis])
                .collect()
        };
        let column = Column {
            shift: over_std(|by| by.read),
            smooth: over_std(|by| by.smooth),
            residual: reading - &rows * cad,
            rows,
            masses: cad.len(),
        };
        (column, stride as f64)
    }

    fn push(&mut self, block: &Block, rows: &Rows) {
        self.moves |= !rows.motion.is_empty();
        self.t.extend(block.t.iter().flatten());
        for k in 0..block.len() {
            let by = rows.motion.get(k).copied().unwrap_or_default();
            self.motion.push(by);
            self.std.push(match &block.std {
                Some(all) => [0, 1].map(|axis| all[k][axis].max(LEAST_STD).hypot(by.std[axis])),
                None => [1.0; 2],
            });
            let support = block.support.as_ref().map_or("", |all| &all[k]);
            let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
            let name = (block.pose[k], support);
            let posture = self.postures.of_row(name, block.joints(k), gravity);
            let at = [rows.reading[2 * k], rows.reading[2 * k + 1]];
            let known = self.repeats.visits;
            self.repeats
                .push(&mut posture.group, posture.visits, at, [1.0; 2]);
            let row = self.std.len() - 1;
            match self.stays.last_mut() {
                Some(stay) if self.repeats.visits == known => stay.end = row + 1,
                _ => self.stays.push(row..row + 1),
            }
        }
    }

    /// Noise is what is left beside masses that are off by their usual tolerances.
    fn timing(
        self,
        folds: usize,
        own_axes: bool,
        long: bool,
        (cad, usual): (&DVector<f64>, &DMatrix<f64>),
    ) -> Timing {
        let rows = self.std.len();
        let step = correlation::step(&self.t).filter(|_| self.t.len() == rows);
        let correlation = [0, 1].map(|axis| {
            let (x, y) = &self.axes[axis];
            if step.is_none() {
                return Correlation::NONE;
            }
            if rows >= ROWS_OF_STAY * self.stays.len() {
                return Correlation::of_stays(&self.t, y, x, &self.stays);
            }
            let held = x * usual;
            let ones = DVector::from_fn(rows, |k, _| 1.0 / self.std[k][axis]);
            let count = held.ncols();
            let mut columns = held.insert_column(0, 0.0);
            columns.set_column(0, &ones);
            Correlation::with_held(&self.t, &(y - x * cad), &columns, count)
        });
        let per_sample = rows_per_sample(&correlation);
        let is_short = 0.5 * per_sample > SHORT * rows as f64;
        let blocks = step.filter(|_| self.repeats.postures == rows as u64);
        let blocks = blocks.map(|step| {
            let length = self.t[rows - 1] - self.t[0] + step;
            let longest = correlation[0].time_s.max(correlation[1].time_s);
            // What lasts for most of a log leaves no blocks that are independent of each other.
            let least = match is_short {
                true => 0.0,
                false => HELD_OUT_TIMES * longest,
            };
            (self.t[0], (length / folds as f64).max(least))
        });
        let own = match own_axes && rows > 0 {
            true => self.apart(&correlation),
            false => [1.0; 2],
        };
        let process = |axis: Correlation| axis.process.filter(|_| !is_short);
        Timing {
            axes: own,
            freed: self.freed_apart(&correlation).unwrap_or(own),
            trust: if is_short { 1.0 / per_sample } else { 1.0 },
            correlation: correlation.map(|axis| Correlation {
                process: process(axis),
                ..axis
            }),
            timed: step.is_some(),
            blocks,
            long,
            first_visits: self.first_visits,
            ..Timing::default()
        }
    }

    /// Noise of each axis in units of their RMS, where that is no chance.
    fn apart(&self, correlation: &[Correlation; 2]) -> [f64; 2] {
        let pure = self.repeats.pure();
        // What a fit leaves is no noise where readings repeat: it is tested against them.
        let squares = [0, 1].map(|axis| match pure.df > 0 {
            true => (pure.sum[axis] / pure.df as f64, pure.df as f64),
            false => {
                let (square, df) = self.left(axis);
                (square, df / correlation[axis].rows_per_sample)
            }
        });
        unalike(squares).unwrap_or([1.0; 2])
    }

    /// The same of rows freed of their correlation: an axis whose noise is taken to last longer is
    /// taken to be larger, too, and its innovations are known as well as there are windows. None
    /// where rows stay as they are, or axes are alike.
    fn freed_apart(&self, correlation: &[Correlation; 2]) -> Option<[f64; 2]> {
        correlation.iter().find(|axis| axis.process.is_some())?;
        unalike([0, 1].map(|axis| match correlation[axis].process {
            Some(process) => {
                let windows = match self.std.len() / process.cut.rows {
                    0 => self.stays.len(),
                    windows => windows,
                };
                let df = windows as f64 - self.axes[axis].0.ncols() as f64;
                (correlation[axis].variance, df)
            }
            None => self.left(axis),
        }))
    }

    /// Mean square of what free masses leave of an axis, and its degrees of freedom.
    fn left(&self, axis: usize) -> (f64, f64) {
        let (x, y) = &self.axes[axis];
        correlation::left(x, y)
    }
}

/// A pseudo-random fold for a key, the same on every machine.
fn drawn(key: i64, folds: usize) -> usize {
    let mut x = (key as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) % folds as u64) as usize
}

/// Rows per independent one, of the axis that has fewer.
fn rows_per_sample(correlation: &[Correlation; 2]) -> f64 {
    correlation[0]
        .rows_per_sample
        .max(correlation[1].rows_per_sample)
}

/// Noise of each axis in units of their RMS by its mean square and degrees of freedom, where they
/// differ by more than chance.
fn unalike([(x, df_x), (y, df_y)]: [(f64, f64); 2]) -> Option<[f64; 2]> {
    if df_x < TO_KNOW_NOISE || df_y < TO_KNOW_NOISE || !(x > 0.0 && y > 0.0) {
        return None;
    }
    let below = FisherSnedecor::new(df_x, df_y).ok()?.cdf(x / y);
    if below.min(1.0 - below) > 0.5 * UNLIKELY {
        return None;
    }
    let ratio = (x / y).sqrt().clamp(1.0 / MOST_APART, MOST_APART);
    let rms = ((ratio * ratio + 1.0) / 2.0).sqrt();
    Some([ratio / rms, 1.0 / rms])
}
