//! Regressor rows of CoP readings, in one parameter vector whatever foot a
//! posture stands on.
//!
//! ```text
//! CoP = CoM − (g_xy / g_z) CoM_z        CoM = rows(q) r        r_foot = T r + t
//! ```
//!
//! The CoM is projected along gravity g on the sole plane. `T` and `t` hold
//! lengths of the URDF only ([`Model::params_from`]), so readings on both feet
//! speak about the same parameters.

use nalgebra::{DMatrix, DVector};
use sesc_model::standard::Shift;
use sesc_model::{Function, Model, Snapping};

use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::Block;
use crate::robot::Robot;

/// What a robot shows when it stands on one link.
struct Standing {
    link: String,
    model: Model,
    flat: Evaluator,
    /// Three rows per posture, where gravity is not along −z.
    space: Evaluator,
    /// From the parameters of the first support; none on the first itself.
    shift: Option<Shift>,
}

/// Rows of the measurement equation: `matrix · r = reading`.
pub struct Rows {
    /// 2 per posture (x, y) × base parameters of the first support.
    pub matrix: DMatrix<f64>,
    /// x, y, x, y, …, m
    pub reading: DVector<f64>,
}

/// Turns postures into rows about the base parameters of one support.
pub struct Measurement<'r> {
    robot: &'r Robot,
    snapping: Snapping,
    standing: Vec<Standing>,
}

impl<'r> Measurement<'r> {
    /// Parameters are those seen from `support`.
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
        let (n, p) = (block.len(), self.model().base.params.len());
        let dof = self.model().dof();
        let mut rows = Rows {
            matrix: DMatrix::zeros(2 * n, p),
            reading: DVector::zeros(2 * n),
        };
        let mut start = 0;
        while start < n {
            let support = |k: usize| block.support.as_ref().map_or("", |all| &all[k]);
            let link = support(start);
            let count = (start..n).take_while(|k| support(*k) == link).count();
            let standing = self.stand_on(link)?;
            let gravity = block.gravity.as_ref().map(|all| &all[start..start + count]);
            let q = &block.q[start * dof..(start + count) * dof];
            let matrix = self.standing[standing].matrix(q, count, gravity);
            let mut reading = DVector::zeros(2 * count);
            if let Some(all) = &block.reading {
                let flat = all[start..start + count].iter().flatten();
                reading.iter_mut().zip(flat).for_each(|(y, cop)| *y = *cop);
            }
            let (at, len) = (2 * start, 2 * count);
            match &self.standing[standing].shift {
                None => rows.matrix.rows_mut(at, len).copy_from(&matrix),
                Some(shift) => {
                    rows.matrix
                        .rows_mut(at, len)
                        .copy_from(&(&matrix * &shift.matrix));
                    reading -= &matrix * &shift.offset;
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
            flat: Evaluator::new(&model, Function::RegressorCop).fastest(),
            space: Evaluator::new(&model, Function::Regressor).fastest(),
            model,
            shift,
        });
        Ok(self.standing.len() - 1)
    }
}

impl Standing {
    /// x and y rows per posture: 2n × base parameters of this support.
    fn matrix(&self, q: &[f64], n: usize, gravity: Option<&[[f64; 3]]>) -> DMatrix<f64> {
        let p = self.model.base.params.len();
        let level = |g: &[f64; 3]| g[0] == 0.0 && g[1] == 0.0;
        let tilted = gravity.filter(|all| !all.iter().all(level));
        let Some(gravity) = tilted else {
            return DMatrix::from_row_slice(2 * n, p, &self.flat.run(q, n));
        };
        let rows = self.space.run(q, n);
        let mut matrix = DMatrix::zeros(2 * n, p);
        for (k, g) in gravity.iter().enumerate() {
            let row = |axis: usize, column: usize| rows[(3 * k + axis) * p + column];
            for column in 0..p {
                let z = row(2, column) / g[2];
                matrix[(2 * k, column)] = row(0, column) - g[0] * z;
                matrix[(2 * k + 1, column)] = row(1, column) - g[1] * z;
            }
        }
        matrix
    }
}
