//! What the first rows of a log say of its noise: whether it is correlated in time, and
//! on which axis it is larger.
//!
//! Rows are made independent as they are read, so this has to be known before: a fit of
//! free masses to the first `ROWS` rows tells, at the cost of reading those twice.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

use crate::Error;
use crate::logs::{Block, PostureReader};
use crate::observations::correlation::{self, Correlation, Process};
use crate::observations::grouping::{DOWN, Grouping};
use crate::observations::noise::LEAST_STD;
use crate::observations::repeats::{Group, Repeats, UNLIKELY};
use crate::observations::rows::Measurement;

/// Rows taken at once.
const BLOCK: usize = 4096;
/// Rows that are looked at.
const ROWS: usize = 20_000;
/// Held-out blocks are longer than this many correlation times.
const LONGER: f64 = 4.0;
/// Axes whose noise differs by more are not weighed any further.
const MOST_APART: f64 = 10.0;
/// Rows a visit from which a robot is said to stay.
const OF_STAY: usize = 3;
/// Degrees of freedom that tell the noise of an axis.
const FEWEST: f64 = 10.0;

/// The noise of a log in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// By axis.
    pub correlation: [Correlation; 2],
    /// Noise of each axis in units of their RMS.
    pub axes: [f64; 2],
    /// Whether times run forward.
    pub timed: bool,
    /// First time and length of the blocks that are held out, s; none where postures are.
    pub blocks: Option<(f64, f64)>,
    /// There are more rows than were looked at.
    pub long: bool,
}

impl Timing {
    /// Nothing is known: readings are independent.
    pub const NONE: Timing = Timing {
        correlation: [Correlation::NONE; 2],
        axes: [1.0; 2],
        timed: false,
        blocks: None,
        long: false,
    };

    /// Processes of both axes, if one is correlated.
    pub fn processes(&self) -> Option<[Process; 2]> {
        let any = self.correlation.iter().any(|axis| axis.process.is_some());
        any.then(|| {
            self.correlation
                .map(|axis| axis.process.unwrap_or_default())
        })
    }

    /// Read on until enough is known. `own_axes`: whether axes may differ where the log
    /// states no deviations.
    ///
    /// # Errors
    /// What is wrong with the log.
    pub fn read(
        reader: &mut PostureReader,
        measurement: &mut Measurement<'_>,
        folds: usize,
        own_axes: bool,
    ) -> Result<Timing, Error> {
        let mut head = Head::default();
        let mut ended = false;
        while head.rows < ROWS && !ended {
            let block = reader.block(BLOCK)?;
            let dof = measurement.model().dof();
            ended = block.is_empty() || block.reading.is_none();
            if !ended {
                let rows = measurement.rows(&block)?;
                head.push(&block, dof, rows.matrix, &rows.reading);
            }
        }
        Ok(head.timing(folds, own_axes && !head.stated, !ended))
    }
}

/// The first rows.
#[derive(Default)]
struct Head {
    rows: usize,
    t: Vec<f64>,
    matrices: Vec<DMatrix<f64>>,
    readings: Vec<f64>,
    /// Deviations, 1 where none are stated.
    std: Vec<[f64; 2]>,
    stated: bool,
    postures: Grouping<Group>,
    repeats: Repeats,
    /// Rows of each visit of a posture.
    stays: Vec<Range<usize>>,
}

impl Head {
    fn push(&mut self, block: &Block, dof: usize, matrix: DMatrix<f64>, reading: &DVector<f64>) {
        self.rows += block.len();
        self.stated |= block.std.is_some();
        self.t.extend(block.t.iter().flatten());
        for k in 0..block.len() {
            let std = block.std.as_ref().map_or([1.0; 2], |all| all[k]);
            self.std.push(std.map(|s| s.max(LEAST_STD)));
            let support = block.support.as_ref().map_or("", |all| &all[k]);
            let gravity = block.gravity.as_ref().map_or(DOWN, |all| all[k]);
            let q = &block.q[k * dof..(k + 1) * dof];
            let (posture, _) = self.postures.of_row((block.pose[k], support), q, gravity);
            let at = [reading[2 * k], reading[2 * k + 1]];
            let (visit, known) = (posture.visits, self.repeats.visits);
            self.repeats.push(&mut posture.own, visit, at, [1.0; 2]);
            let row = self.std.len() - 1;
            match self
                .stays
                .last_mut()
                .filter(|_| self.repeats.visits == known)
            {
                Some(stay) => stay.end = row + 1,
                None => self.stays.push(row..row + 1),
            }
        }
        self.readings.extend(reading.iter());
        self.matrices.push(matrix);
    }

    fn timing(&self, folds: usize, own_axes: bool, long: bool) -> Timing {
        let step = match self.t.len() == self.rows {
            true => correlation::step(&self.t),
            false => None,
        };
        let axes: Vec<_> = (0..2).map(|axis| self.axis(axis)).collect();
        let of = |axis: usize| match step {
            Some(_) if self.rows >= OF_STAY * self.stays.len() => {
                Correlation::of_stays(&self.t, &axes[axis].1, &axes[axis].0, &self.stays)
            }
            Some(_) => Correlation::of(&self.t, &axes[axis].1, &axes[axis].0),
            None => Correlation::NONE,
        };
        let correlation = match self.rows {
            0 => [Correlation::NONE; 2],
            _ => [of(0), of(1)],
        };
        let longest = correlation[0].time_s.max(correlation[1].time_s);
        let blocks = step.filter(|_| self.repeats.postures == self.rows as u64);
        let blocks = blocks.map(|step| {
            let length = self.t[self.rows - 1] - self.t[0] + step;
            (self.t[0], (length / folds as f64).max(LONGER * longest))
        });
        Timing {
            axes: match own_axes && self.rows > 0 {
                true => self.apart(&axes, &correlation),
                false => [1.0; 2],
            },
            correlation,
            timed: step.is_some(),
            blocks,
            long,
        }
    }

    /// Rows of one axis over their deviations.
    fn axis(&self, axis: usize) -> (DMatrix<f64>, DVector<f64>) {
        let params = self.matrices.first().map_or(0, DMatrix::ncols);
        let mut x = DMatrix::zeros(self.rows, params);
        let mut at = 0;
        for matrix in &self.matrices {
            for k in 0..matrix.nrows() / 2 {
                let weight = 1.0 / self.std[at][axis];
                x.set_row(at, &(matrix.row(2 * k + axis) * weight));
                at += 1;
            }
        }
        let y = |k: usize, _| self.readings[2 * k + axis] / self.std[k][axis];
        (x, DVector::from_fn(self.rows, y))
    }

    /// Noise of each axis in units of their RMS, where that is no chance.
    fn apart(
        &self,
        axes: &[(DMatrix<f64>, DVector<f64>)],
        correlation: &[Correlation; 2],
    ) -> [f64; 2] {
        let pure = self.repeats.pure();
        let squares = match pure.df as f64 >= FEWEST && self.repeats.rows > 0 {
            true => [0, 1].map(|axis| (pure.sum[axis] / pure.df as f64, pure.df as f64)),
            false => [0, 1].map(|axis| {
                let (x, y) = &axes[axis];
                let (square, df) = correlation::left(x, y);
                (square, df / correlation[axis].rows_per_sample)
            }),
        };
        let [(x, df_x), (y, df_y)] = squares;
        if df_x < FEWEST || df_y < FEWEST || !(x > 0.0 && y > 0.0) {
            return [1.0; 2];
        }
        let Ok(distribution) = FisherSnedecor::new(df_x, df_y) else {
            return [1.0; 2];
        };
        let below = distribution.cdf(x / y);
        if below.min(1.0 - below) > 0.5 * UNLIKELY {
            return [1.0; 2];
        }
        let ratio = (x / y).sqrt().clamp(1.0 / MOST_APART, MOST_APART);
        let rms = ((ratio * ratio + 1.0) / 2.0).sqrt();
        [ratio / rms, 1.0 / rms]
    }
}
