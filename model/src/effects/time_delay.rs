//! Joint angles and readings are not of the same moment.
//!
//! ```text
//! φ = q(t + d) ≈ q + d q' + d² q''/2          d in s: angles older than readings
//! ```
//!
//! Seen in motion only: logs with `t`. Nothing else follows the velocities.

use super::{Circumstances, Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct TimeDelay;

impl Effect for TimeDelay {
    fn name(&self) -> &'static str {
        "time_delay"
    }

    fn stage(&self) -> Stage {
        Stage::Joints
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        match setting.times {
            true => vec![Target::Whole],
            false => Vec::new(),
        }
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.03]
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        let circumstances = Circumstances::of(at.model());
        let d = unknowns[0];
        let half = at.constant(0.5);
        let half_d = at.mul(half, d);
        for joint in 0..at.model().dof() {
            let rate = at.circumstance(circumstances.rate(joint));
            let acceleration = at.circumstance(circumstances.acceleration(joint));
            let g = at.g();
            let curve = g.mul(half_d, acceleration);
            let slope = g.add(curve, rate);
            let moved = g.mul(d, slope);
            at.shift_joint(joint, moved);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["delay_s"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn of_posture(&self) -> bool {
        false
    }
}
