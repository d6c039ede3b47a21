//! The robot was still moving: its CoP is not that of a posture.
//!
//! ```text
//! p = c_xy − a (c_z / g) c''_xy          a = 1: the zero moment point
//! ```
//!
//! `c'' ≈ Σ ∂c/∂q_j q''_j`, which drops terms of second order in the velocities:
//! to first order the CoM of joints that lag by `a (h/g) q''`. Imitated by a sensor gain in slow
//! sinusoidal motion (gain 1 + ω² h / g). Logs with `t` only.

use super::setting::GRAVITY;
use super::{Circumstances, Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct UnsettledMotion;

impl Effect for UnsettledMotion {
    fn name(&self) -> &'static str {
        "unsettled_motion"
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
        vec![0.3]
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        // c(q) − a (z/g) c'' is c where joints lag by a (z/g) q'', to first order.
        let circumstances = Circumstances::of(at.model());
        let height = at.constant(at.model().cad_height() / GRAVITY);
        let lag = at.mul(height, unknowns[0]);
        for joint in 0..at.model().dof() {
            let acceleration = at.circumstance(circumstances.acceleration(joint));
            let moved = at.mul(lag, acceleration);
            let back = at.neg(moved);
            at.shift_joint(joint, back);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["share"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn of_posture(&self) -> bool {
        false
    }
}
