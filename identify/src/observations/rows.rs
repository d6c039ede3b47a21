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

use super::motion::Motion;
use super::zmp::Zmp;
use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::Block;
use crate::robot::Robot;

/// Tilt of the sole plane under `gravity`: the CoP moves by it times the CoM's height.
pub fn tilt(gravity: [f64; 3]) -> [f64; 2] {
    [-gravity[0] / gravity[2], -gravity[1] / gravity[2]]
}

/// CoP rows of a robot on one link.
pub struct CopRows {
    params: usize,
    flat: Evaluator,
    /// Three rows per posture, where the sole is tilted.
    space: Evaluator,
}

impl CopRows {
    /// Rows of the CoP for `model`.
    pub fn new(model: &Model) -> CopRows {
        CopRows {
            params: model.base.params.len(),
            flat: Evaluator::new(model, Function::RegressorCop),
            space: Evaluator::new(model, Function::Regressor),
        }
    }

    /// On the fastest instructions, to rounding the same.
    pub fn fastest(self) -> CopRows {
        CopRows {
            params: self.params,
            flat: self.flat.fastest(),
            space: self.space.fastest(),
        }
    }

    /// x and y rows of `n` postures `q` by base parameters of this support, 2n × p;
    /// `tilt` of each posture ([`tilt`]), level where not given.
    pub fn of(&self, q: &[f64], n: usize, tilt: Option<&[[f64; 2]]>) -> DMatrix<f64> {
        let p = self.params;
        let Some(tilt) = tilt.filter(|all| all.iter().flatten().any(|t| *t != 0.0)) else {
            return DMatrix::from_row_slice(2 * n, p, &self.flat.run(q, n));
        };
        let rows = self.space.run(q, n);
        let of = |k: usize, axis: usize, column: usize| rows[(3 * k + axis) * p + column];
        DMatrix::from_fn(2 * n, p, |row, column| {
            let (k, axis) = (row / 2, row % 2);
            of(k, axis, column) + tilt[k][axis] * of(k, 2, column)
        })
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
    pub matrix: DMatrix<f64>,
    /// x, y, x, y, …, m; less what of the motion is no matter of parameters.
    pub reading: DVector<f64>,
    /// What motion adds to readings by CAD, and how well that is known, m; empty where joints
    /// stand.
    pub motion: Vec<([f64; 2], [f64; 2])>,
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
        let mut rows = Rows {
            matrix: DMatrix::zeros(2 * n, p),
            reading: DVector::zeros(2 * n),
            motion: Vec::new(),
        };
        let mut start = 0;
        while start < n {
            let support = |k: usize| block.support.as_ref().map_or("", |all| &all[k]);
            let link = support(start);
            let count = (start..n).take_while(|k| support(*k) == link).count();
            let standing = self.stand_on(link)?;
            let gravity = block.gravity.as_ref().map(|all| &all[start..start + count]);
            let tilts = gravity.map(|all| all.iter().map(|g| tilt(*g)).collect::<Vec<_>>());
            let q = &block.q[start * dof..(start + count) * dof];
            let standing = &mut self.standing[standing];
            let moved = motion.map(|motion| {
                let level = vec![[0.0; 2]; count];
                let tilts = tilts.as_deref().unwrap_or(&level);
                let zmp = standing
                    .zmp
                    .get_or_insert_with(|| Zmp::new(&standing.model));
                zmp.moved(q, motion, start..start + count, tilts)
            });
            let matrix = match &moved {
                Some(moved) => &moved.rows,
                None => &standing.rows.of(q, count, tilts.as_deref()),
            };
            let mut reading = DVector::zeros(2 * count);
            if let Some(all) = &block.reading {
                let flat = all[start..start + count].iter().flatten();
                reading.iter_mut().zip(flat).for_each(|(y, cop)| *y = *cop);
            }
            if let Some(moved) = &moved {
                let flat = moved.correction.iter().flatten();
                reading.iter_mut().zip(flat).for_each(|(y, by)| *y -= by);
                let pairs = moved.shift.iter().zip(&moved.std);
                rows.motion.extend(pairs.map(|(shift, std)| (*shift, *std)));
            }
            let (at, len) = (2 * start, 2 * count);
            match &standing.shift {
                None => rows.matrix.rows_mut(at, len).copy_from(matrix),
                Some(shift) => {
                    rows.matrix
                        .rows_mut(at, len)
                        .copy_from(&(matrix * &shift.matrix));
                    reading -= matrix * &shift.offset;
                }
            }
            rows.reading.rows_mut(at, len).copy_from(&reading);
            start += count;
        }
        Ok(rows)
    }

    /// Index of the standing on `link` (the first where none is named).
    fn stand_on(&mut self, link: &str) -> Result<usize, Error> {
        let known = |s: &Standing| s.link == link || link.is_empty();
        if let Some(at) = self.standing.iter().position(known) {
            return Ok(at);
        }
        let model = self.robot.model(link, self.snapping, None)?;
        let shift = self
            .standing
            .first()
            .map(|first| model.params_from(&first.model));
        self.standing.push(Standing {
            link: link.to_string(),
            rows: CopRows::new(&model).fastest(),
            zmp: None,
            model,
            shift,
        });
        Ok(self.standing.len() - 1)
    }
}
