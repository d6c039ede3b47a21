//! An encoder's angle is stretched: a wrong gear ratio or resolution.
//!
//! ```text
//! φ_j = (1 + s) q_j
//! ```
//!
//! Imitated by the same joint's offset while the joint keeps to a narrow range
//! away from zero; a wide range on both sides of zero separates the two.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct JointScale;

impl Effect for JointScale {
    fn name(&self) -> &'static str {
        "joint_scale"
    }

    fn stage(&self) -> Stage {
        Stage::Joints
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        setting.joints()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.05]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Joint(j) = *target {
            // Of what the encoder says, whatever offset comes beside it.
            let q = at.wired[j];
            let stretched = at.mul(unknowns[0], q);
            at.shift_joint(j, stretched);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["scale"], &[1.0 + unknowns[0]])
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        vec![values[0] - 1.0]
    }

    fn excess(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        super::beyond(unknowns[0], 0.9, 0.05)
    }
}
