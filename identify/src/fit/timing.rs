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
use crate::observations::repeats::{Group, Repeats};
use crate::observations::row_matrix::RowMatrix;
use crate::observations::rows::{Measurement, Rows};

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

impl Timing {
    /// Nothing is known: readings are independent.
    pub const NONE: Timing = Timing {
        correlation: [Correlation::NONE; 2],
        axes: [1.0; 2],
        freed: [1.0; 2],
        trust: 1.0,
        timed: false,
        blocks: None,
        long: false,
        first_visits: BTreeMap::new(),
        plan: None,
        motion: MotionUse::NONE,
    };

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
        let timing = |head: Head| {
            let own_axes = own_axes && first.std.is_none();
            head.timing(folds, own_axes, !ended, (&cad, usual))
        };
        let moving = Head::of(&first, measurement, plan.as_ref())?;
        // RMS of what motion adds to readings, m.
        let seen = rms(moving.shift.iter().flatten().copied());
        let column = moving.moves.then(|| moving.column(&cad));
        let found = timing(moving);
        let rows = found.correlation.map(|axis| axis.rows_per_sample);
        let share = column.and_then(|(column, stride)| {
            let per_sample = (rows[0].max(rows[1]) / stride).max(1.0);
            column.share(masses, per_sample)
        });
        // A head that stands says nothing of what comes.
        let moves = share.is_some() || seen > 0.0;
        let found = match moves && share.is_some_and(|share| share.is_missing()) {
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
                ..MotionUse::NONE
            },
            ..found
        })
    }
}

/// The first rows.
#[derive(Default)]
struct Head {
    rows: usize,
    t: Vec<f64>,
    matrices: Vec<RowMatrix>,
    readings: Vec<f64>,
    /// Deviations, 1 where none are stated.
    std: Vec<[f64; 2]>,
    postures: Grouping<Group>,
    repeats: Repeats,
    /// Rows of each visit of a posture.
    stays: Vec<Range<usize>>,
    /// What motion adds to readings, m; zero where joints stand.
    shift: Vec<[f64; 2]>,
    /// The same by smooth motion, m.
    smooth: Vec<[f64; 2]>,
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
            head.push(&block, dof, rows);
        }
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
        let stride = self.rows.div_ceil(OF_SHARE).max(1);
        let axes = [self.axis(0), self.axis(1)];
        let of = |row: usize| (row / 2 * stride, row % 2);
        let n = 2 * self.rows.div_ceil(stride);
        let rows = DMatrix::from_fn(n, cad.len(), |row, column| {
            let (k, axis) = of(row);
            axes[axis].0[(k, column)]
        });
        let reading = DVector::from_fn(n, |row, _| {
            let (k, axis) = of(row);
            axes[axis].1[k]
        });
        let over_std = |all: &[[f64; 2]]| {
            let over = (0..n)
                .map(of)
                .map(|(k, axis)| all[k][axis] / self.std[k][axis]);
            over.collect::<Vec<f64>>()
        };
        let column = Column {
            shift: over_std(&self.shift),
            smooth: over_std(&self.smooth),
            residual: reading - &rows * cad,
            rows,
            masses: cad.len(),
        };
        (column, stride as f64)
    }

    fn push(&mut self, block: &Block, dof: usize, rows: Rows) {
        let Rows {
            matrix,
            reading,
            motion,
        } = rows;
        self.moves |= !motion.is_empty();
        let by = |k: usize| motion.get(k).copied().unwrap_or_default();
        self.shift.extend((0..block.len()).map(|k| by(k).read));
        self.smooth.extend((0..block.len()).map(|k| by(k).smooth));
        self.rows += block.len();
        self.t.extend(block.t.iter().flatten());
        for k in 0..block.len() {
            let std = block.std.as_ref().map_or([1.0; 2], |all| all[k]);
            let own = motion.get(k).filter(|_| block.std.is_some());
            let own = own.map_or([0.0; 2], |shift| shift.std);
            let std = [0, 1].map(|axis| std[axis].max(LEAST_STD).hypot(own[axis]));
            self.std.push(std);
            let support = block.support.as_ref().map_or("", |all| &all[k]);
            let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
            let q = &block.q[k * dof..(k + 1) * dof];
            let (posture, _) = self.postures.of_row((block.pose[k], support), q, gravity);
            let at = [reading[2 * k], reading[2 * k + 1]];
            let (visit, known) = (posture.visits, self.repeats.visits);
            self.repeats.push(&mut posture.own, visit, at, [1.0; 2]);
            let row = self.std.len() - 1;
            match self.stays.last_mut() {
                Some(stay) if self.repeats.visits == known => stay.end = row + 1,
                _ => self.stays.push(row..row + 1),
            }
        }
        self.readings.extend(reading.iter());
        self.matrices.push(matrix);
    }

    /// Noise is what is left beside masses that are off by their usual tolerances.
    fn timing(
        self,
        folds: usize,
        own_axes: bool,
        long: bool,
        (cad, usual): (&DVector<f64>, &DMatrix<f64>),
    ) -> Timing {
        let is_timed = self.t.len() == self.rows;
        let step = correlation::step(&self.t).filter(|_| is_timed);
        let axes = [self.axis(0), self.axis(1)];
        let of = |axis: usize| match step {
            Some(_) if self.rows >= ROWS_OF_STAY * self.stays.len() => {
                Correlation::of_stays(&self.t, &axes[axis].1, &axes[axis].0, &self.stays)
            }
            Some(_) => {
                let (x, y) = &axes[axis];
                let held = x * usual;
                let columns = DMatrix::from_fn(self.rows, 1 + held.ncols(), |k, c| match c {
                    0 => 1.0 / self.std[k][axis],
                    c => held[(k, c - 1)],
                });
                Correlation::with_held(&self.t, &(y - x * cad), &columns, held.ncols())
            }
            None => Correlation::NONE,
        };
        let correlation = [of(0), of(1)];
        let longest = correlation[0].time_s.max(correlation[1].time_s);
        let is_short = 0.5 * rows_per_sample(&correlation) > SHORT * self.rows as f64;
        let blocks = step.filter(|_| self.repeats.postures == self.rows as u64);
        let blocks = blocks.map(|step| {
            let length = self.t[self.rows - 1] - self.t[0] + step;
            // What lasts for most of a log leaves no blocks that are independent of each other.
            let least = if is_short {
                0.0
            } else {
                HELD_OUT_TIMES * longest
            };
            let held_out = (length / folds as f64).max(least);
            (self.t[0], held_out)
        });
        let own = match own_axes && self.rows > 0 {
            true => self.apart(&axes, &correlation),
            false => [1.0; 2],
        };
        Timing {
            axes: own,
            freed: self.freed_apart(&axes, &correlation).unwrap_or(own),
            trust: match is_short {
                true => 1.0 / rows_per_sample(&correlation),
                false => 1.0,
            },
            correlation: match is_short {
                true => correlation.map(|axis| Correlation {
                    process: None,
                    ..axis
                }),
                false => correlation,
            },
            timed: step.is_some(),
            blocks,
            long,
            first_visits: self.first_visits,
            ..Timing::NONE
        }
    }

    /// Rows of one axis over their deviations.
    fn axis<'a>(&'a self, axis: usize) -> (DMatrix<f64>, DVector<f64>) {
        let params = self.matrices.first().map_or(0, |rows| rows.columns);
        let own = |matrix: &'a RowMatrix| (axis..matrix.rows()).step_by(2).map(|k| matrix.row(k));
        let rows = self.matrices.iter().flat_map(own).zip(&self.std);
        let entries = rows.flat_map(|(row, std)| {
            let weight = 1.0 / std[axis];
            row.iter().map(move |x| x * weight)
        });
        let x = DMatrix::from_row_iterator(self.rows, params, entries);
        let y = |k: usize, _| self.readings[2 * k + axis] / self.std[k][axis];
        (x, DVector::from_fn(self.rows, y))
    }

    /// Noise of each axis in units of their RMS, where that is no chance.
    fn apart(
        &self,
        axes: &[(DMatrix<f64>, DVector<f64>); 2],
        correlation: &[Correlation; 2],
    ) -> [f64; 2] {
        let pure = self.repeats.pure();
        // What a fit leaves is no noise where readings repeat: it is tested against them.
        let squares = match pure.df > 0 {
            true => [0, 1].map(|axis| (pure.sum[axis] / pure.df as f64, pure.df as f64)),
            false => [0, 1].map(|axis| {
                let (x, y) = &axes[axis];
                let (square, df) = correlation::left(x, y);
                (square, df / correlation[axis].rows_per_sample)
            }),
        };
        unalike(squares).unwrap_or([1.0; 2])
    }

    /// The same of rows freed of their correlation: an axis whose noise is taken to last longer is
    /// taken to be larger, too, and its innovations are known as well as there are windows. None
    /// where rows stay as they are, or axes are alike.
    fn freed_apart(
        &self,
        axes: &[(DMatrix<f64>, DVector<f64>); 2],
        correlation: &[Correlation; 2],
    ) -> Option<[f64; 2]> {
        correlation.iter().find(|axis| axis.process.is_some())?;
        let square = |axis: usize| {
            let (x, y) = &axes[axis];
            match correlation[axis].process {
                Some(process) => {
                    let windows = match self.rows / process.cut.rows {
                        0 => self.stays.len(),
                        windows => windows,
                    };
                    let df = windows as f64 - x.ncols() as f64;
                    (correlation[axis].variance, df)
                }
                None => correlation::left(x, y),
            }
        };
        unalike([0, 1].map(square))
    }
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
