//! One look at a log for a fit, in memory that does not grow with it.
//!
//! Rows are looked at one by one and, thinned out, as postures. A stuck encoder
//! leaves its joint's motion to the noise:
//!
//! ```text
//! σ² → σ² + (a ∂p/∂q_j)²        a: how far the joint may be from where it says
//! ```

use std::fmt;
use std::sync::Arc;

use sesc_model::{Function, Model, Snapping};

use super::criteria::{ANYWHERE, UNKNOWN_NOISE_M};
use super::encoders::{Stuck, of_joint, parked};
use super::rows::{self, LeftOut, LogRows};
use super::{Finding, Health, On, Views};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::{Block, LogSource, Options, Screen, Screening};
use crate::robot::Robot;
use crate::watch::Watch;

/// How a log of a fit is read.
#[derive(Debug, Clone, Copy)]
pub struct Reading<'a> {
    /// Units, links, support.
    pub options: &'a Options,
    /// How decimals of right angles are read.
    pub snapping: Snapping,
    /// Standard deviation of a single reading, m, where the user says.
    pub noise: Option<f64>,
    /// Whether no other log is fitted with it: rows may be told deviations then.
    pub alone: bool,
}

/// What is wrong with a log on the model's support, and the log without it.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub fn look(
    log: &LogSource,
    robot: &Robot,
    model: &Model,
    reading: Reading,
    watch: &mut dyn Watch,
) -> Result<(LogSource, Vec<Finding>), Error> {
    let log = log.clone();
    if !log.can_be_read_again() {
        return Ok((log, Vec::new()));
    }
    let on = On {
        robot,
        model,
        snapping: reading.snapping,
    };
    let rows = LogRows::read(&log, (robot, model), reading.options, reading.noise, watch)?;
    let (left_out, findings) = judge(&rows, on);
    // At most 2000 postures.
    let stride = rows.len().div_ceil(2000).max(1);
    let kept = |k: &usize| {
        left_out.keeps(rows.reading[*k], rows.force(*k)) && left_out.follows(rows.q(*k))
    };
    let chosen: Vec<usize> = (0..rows.len()).filter(kept).step_by(stride).collect();
    if chosen.is_empty() {
        return Ok((log, findings));
    }
    let noise = rows.noise.unwrap_or(UNKNOWN_NOISE_M);
    let (read, still) = rows.views(&chosen, model);
    let found = Views::of(on, &read, still.as_ref()).examine(true);
    let Health { findings, stuck } = found.after(findings);
    let Some(Stuck { joint, .. }) = stuck else {
        return Ok((screened(log, left_out), findings));
    };
    let screen = LessKnown {
        left_out,
        slopes: Arc::new(Evaluator::new(model, Function::ComJacobian).fastest()),
        joint,
        dof: rows.dof,
        anywhere: of_joint(&model.tree.dofs[joint], ANYWHERE),
        noise: reading.alone.then_some(noise),
    };
    Ok((log.screened(Arc::new(screen)), findings))
}

/// Look at the rows of a log on the model's support: what is wrong with them, and the log
/// without those that cannot be used. `noise`: of a single reading, m, where the user says.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub fn screen(
    log: &LogSource,
    (robot, model): (&Robot, &Model),
    options: &Options,
    noise: Option<f64>,
    watch: &mut dyn Watch,
) -> Result<(LogSource, Vec<Finding>), Error> {
    let log = log.clone();
    if !log.can_be_read_again() {
        return Ok((log, Vec::new()));
    }
    let log = log.unchanged()?;
    let rows = LogRows::read(&log, (robot, model), options, noise, watch)?;
    let snapping = Snapping::default();
    let on = On {
        robot,
        model,
        snapping,
    };
    let (left_out, findings) = judge(&rows, on);
    Ok((screened(log, left_out), findings))
}

/// What is wrong with rows, by themselves and beside what CAD says, and what to leave out.
fn judge(rows: &LogRows, on: On) -> (LeftOut, Vec<Finding>) {
    let (mut left_out, mut findings) = rows::judge(rows, on.model);
    findings.extend(parked(rows, on, &mut left_out));
    (left_out, findings)
}

/// A log without the rows that are to be left out.
fn screened(log: LogSource, left_out: LeftOut) -> LogSource {
    if left_out == LeftOut::default() {
        return log;
    }
    log.screened(Arc::new(left_out))
}

/// Rows that are left out, and the others count for less along the motion of one joint.
struct LessKnown {
    left_out: LeftOut,
    slopes: Arc<Evaluator>,
    joint: usize,
    dof: usize,
    anywhere: f64,
    /// Noise of rows that state none, m.
    noise: Option<f64>,
}

impl fmt::Debug for LessKnown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "LessKnown({}, {:?})", self.joint, self.left_out)
    }
}

impl Screen for LessKnown {
    fn start(&self) -> Screening {
        let mut left_out = self.left_out.start();
        let (slopes, noise) = (Arc::clone(&self.slopes), self.noise);
        let (joint, dof, anywhere) = (self.joint, self.dof, self.anywhere);
        Box::new(move |block: &mut Block| {
            left_out(block);
            let n = block.len();
            if let (None, Some(noise)) = (&block.std, noise) {
                block.std = Some(vec![[noise; 2]; n]);
            }
            let slopes = slopes.run(&block.q, n);
            for (k, std) in block.std.iter_mut().flatten().enumerate() {
                *std = [0, 1].map(|axis| {
                    let slope = slopes[(3 * k + axis) * dof + joint];
                    std[axis].hypot(anywhere * slope)
                });
            }
        })
    }
}
