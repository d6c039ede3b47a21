//! Regressor rows of CoP readings, in one parameter vector whatever foot a
//! posture stands on.
//!
//! ```text
//! CoP = CoM − (g_xy / g_z) CoM_z        CoM = rows(q) r        r_foot = T r + t
//! ```
//!
//! The CoM is projected along gravity g on the sole plane; where joints move, the ZMP takes
//! the place of the CoP ([`super::zmp`]). `T` and `t` hold
//! lengths of the URDF only ([`sesc_model::Robot::params_from`]), so readings on both feet
//! describe the same parameters.

use nalgebra::{DMatrix, DVector};
use sesc_model::standard::Shift;
use sesc_model::{Function, Model, Snapping};

use super::grouping::Grouping;
use super::motion::Motion;
use super::repeats::Repeats;
use super::row_matrix::RowMatrix;
use super::zmp::Zmp;
use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::Block;
use crate::robot::{Robot, check_joints};

/// Tilt of the sole plane under `gravity`: the CoP moves by it times the CoM's height.
pub(crate) fn tilt(gravity: [f64; 3]) -> [f64; 2] {
    [-gravity[0] / gravity[2], -gravity[1] / gravity[2]]
}

/// CoP rows of a robot on one link.
pub(crate) struct CopRows {
    params: usize,
    flat: Evaluator,
    /// Three rows per posture, where the sole is tilted.
    space: Evaluator,
}

impl CopRows {
    /// Rows of the CoP for `model`.
    pub(crate) fn new(model: &Model) -> CopRows {
        CopRows {
            params: model.base.params.len(),
            flat: Evaluator::new(model, Function::RegressorCop),
            space: Evaluator::new(model, Function::Regressor),
        }
    }

    /// On the fastest instructions, to rounding the same.
    pub(crate) fn fastest(self) -> CopRows {
        CopRows {
            flat: self.flat.fastest(),
            space: self.space.fastest(),
            ..self
        }
    }

    /// x and y rows of `n` postures `q` by base parameters of this support, 2n × p;
    /// `tilt` of each posture ([`tilt`]), level where not given.
    pub(crate) fn of(&self, q: &[f64], n: usize, tilt: Option<&[[f64; 2]]>) -> DMatrix<f64> {
        let mut rows = RowMatrix::zeros(2 * n, self.params);
        self.write(q, n, tilt, &mut rows.entries);
        rows.dense()
    }

    /// The same into the caller's memory, row after row.
    fn write(&self, q: &[f64], n: usize, tilt: Option<&[[f64; 2]]>, out: &mut [f64]) {
        let p = self.params;
        let Some(tilt) = tilt.filter(|all| all.iter().flatten().any(|t| *t != 0.0)) else {
            return self.flat.run_into(q, n, out);
        };
        let space = self.space.run(q, n);
        let postures = out.chunks_exact_mut(2 * p);
        for ((out, space), tilt) in postures.zip(space.chunks_exact(3 * p)).zip(tilt) {
            let (flat, height) = space.split_at(2 * p);
            for (axis, out) in out.chunks_exact_mut(p).enumerate() {
                let own = flat[axis * p..(axis + 1) * p].iter().zip(height);
                let own = own.map(|(x, z)| x + tilt[axis] * z);
                out.iter_mut().zip(own).for_each(|(to, x)| *to = x);
            }
        }
    }
}

/// What a robot shows when it stands on one link.
struct Standing {
    link: String,
    model: Model,
    rows: CopRows,
    /// Made when joints move.
    zmp: Option<Zmp>,
    /// From the parameters of the first support; none on the first itself.
    shift: Option<Shift>,
}

/// Rows of the measurement equation: `matrix · r = reading`.
pub struct Rows {
    /// 2 per posture (x, y) × base parameters of the first support.
    pub matrix: RowMatrix,
    /// x, y, x, y, …, m; less what of the motion is no matter of parameters.
    pub reading: DVector<f64>,
    /// What motion adds to readings; empty where joints stand.
    pub motion: Vec<ByMotion>,
}

/// What motion adds to a reading by CAD, x and y, m.
#[derive(Debug, Clone, Copy, Default)]
pub struct ByMotion {
    /// By the motion that was read.
    pub read: [f64; 2],
    /// By smooth motion.
    pub smooth: [f64; 2],
    /// Deviation of the first.
    pub std: [f64; 2],
}

impl Rows {
    /// What `params` leave of the readings, m.
    pub fn residual(&self, params: &DVector<f64>) -> DVector<f64> {
        &self.reading - self.matrix.times(params)
    }
}

/// Builds rows of the regressor of one support from postures.
pub struct Measurement<'r> {
    robot: &'r Robot,
    snapping: Snapping,
    standing: Vec<Standing>,
}

impl<'r> Measurement<'r> {
    /// Rows for the base parameters of `support`.
    pub fn new(robot: &'r Robot, support: &str, snapping: Snapping) -> Result<Self, Error> {
        let mut measurement = Measurement {
            robot,
            snapping,
            standing: Vec::new(),
        };
        measurement.stand_on(support)?;
        Ok(measurement)
    }

    /// The model whose parameters are meant.
    pub fn model(&self) -> &Model {
        &self.standing[0].model
    }

    /// Links that postures stood on so far, the one of the parameters first.
    pub fn supports(&self) -> Vec<&str> {
        self.standing.iter().map(|s| s.link.as_str()).collect()
    }

    /// Rows of a block; postures without a support of their own stand on the first.
    pub fn rows(&mut self, block: &Block) -> Result<Rows, Error> {
        self.moving_rows(block, None)
    }

    /// The same of joints in motion.
    pub fn moving_rows(&mut self, block: &Block, motion: Option<&Motion>) -> Result<Rows, Error> {
        let (n, p) = (block.len(), self.model().base.params.len());
        let dof = self.model().dof();
        let read = block.reading.as_ref().map(|all| all.as_flattened());
        let mut rows = Rows {
            matrix: RowMatrix::zeros(2 * n, p),
            reading: read.map_or_else(|| DVector::zeros(2 * n), DVector::from_column_slice),
            motion: Vec::new(),
        };
        let mut start = 0;
        while start < n {
            let support = |k: usize| block.support.as_ref().map_or("", |all| &all[k]);
            let link = support(start);
            let count = (start..n).take_while(|k| support(*k) == link).count();
            let standing = self.stand_on(link)?;
            check_joints(&standing.model, block.q.len() / n)?;
            let gravity = block.gravity.as_ref().map(|all| &all[start..start + count]);
            let tilts = gravity.map(|all| all.iter().map(|g| tilt(*g)).collect::<Vec<_>>());
            let q = motion.map_or(&block.q, |motion| &motion.positions);
            let q = &q[start * dof..(start + count) * dof];
            let moved = motion.map(|motion| {
                let level = vec![[0.0; 2]; count];
                let tilts = tilts.as_deref().unwrap_or(&level);
                let zmp = standing
                    .zmp
                    .get_or_insert_with(|| Zmp::new(&standing.model));
                zmp.moved(q, motion, start..start + count, tilts)
            });
            let own = 2 * start..2 * (start + count);
            let reading = &mut rows.reading.as_mut_slice()[own.clone()];
            if let Some(moved) = &moved {
                let flat = moved.correction.iter().flatten();
                reading.iter_mut().zip(flat).for_each(|(y, by)| *y -= by);
                let both = moved.shift.iter().zip(&moved.smooth_shift).zip(&moved.std);
                let shifts = both.map(|((&read, &smooth), &std)| ByMotion { read, smooth, std });
                rows.motion.extend(shifts);
            }
            let entries = &mut rows.matrix.entries[own.start * p..own.end * p];
            match (&standing.shift, moved) {
                (None, None) => standing.rows.write(q, count, tilts.as_deref(), entries),
                (None, Some(moved)) => entries.copy_from_slice(&moved.rows.entries),
                (Some(shift), moved) => {
                    let matrix = match moved {
                        Some(moved) => moved.rows.dense(),
                        None => standing.rows.of(q, count, tilts.as_deref()),
                    };
                    let there = &matrix * &shift.offset;
                    reading.iter_mut().zip(&there).for_each(|(y, by)| *y -= by);
                    let here = shift.matrix.tr_mul(&matrix.transpose());
                    entries.copy_from_slice(here.as_slice());
                }
            }
            start += count;
        }
        Ok(rows)
    }

    /// Join the visits of postures that were reached again under another number; the first
    /// posture that each is a visit of, none where nothing was joined.
    ///
    /// # Errors
    /// As [`Measurement::rows`].
    pub fn join_reached_again(
        &mut self,
        repeats: &mut Repeats,
        known: &Grouping,
    ) -> Result<Option<Vec<usize>>, Error> {
        let Some(first) = known.reached_again() else {
            return Ok(None);
        };
        let cad = DVector::from_vec(self.model().cad_params());
        let predicted = -self.rows(&known.stances())?.residual(&cad);
        let group = |k| &known.posture(k).group;
        repeats.join_visits(&first, group, predicted.as_slice());
        Ok(Some(first))
    }

    /// The robot as it stands on `link` (the first where none is named).
    fn stand_on(&mut self, link: &str) -> Result<&mut Standing, Error> {
        let known = |s: &Standing| s.link == link || link.is_empty();
        if let Some(at) = self.standing.iter().position(known) {
            return Ok(&mut self.standing[at]);
        }
        let model = self.robot.model(link, self.snapping, None)?;
        let first = self.standing.first();
        let shift = first.map(|first| model.params_from(&first.model));
        let at = self.standing.len();
        self.standing.push(Standing {
            link: link.to_string(),
            rows: CopRows::new(&model).fastest(),
            zmp: None,
            model,
            shift,
        });
        Ok(&mut self.standing[at])
    }
}
