//! An encoder's zero lies elsewhere.
//!
//! ```text
//! φ_j = q_j + δ        δ in rad (m for a slide)
//! ```
//!
//! Imitated by the offset of a joint with a parallel axis (ankle pitch, knee, hip
//! pitch) and at the ankles by a slope. Deep squats separate the parallel ones.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct JointOffset;

impl Effect for JointOffset {
    fn name(&self) -> &'static str {
        "joint_offset"
    }

    fn stage(&self) -> Stage {
        Stage::Joints
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        setting.joints()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.02]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Joint(j) = *target {
            at.shift_joint(j, unknowns[0]);
        }
    }

    fn values(&self, setting: &Setting, target: &Target, unknowns: &[f64]) -> Vec<Value> {
        let name = setting.by_kind(target, "offset_rad", "offset_m");
        super::plain(&[name], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn excess(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        super::beyond(unknowns[0], 0.7, 0.1)
    }
}
