//! An encoder counts backwards.
//!
//! ```text
//! φ_j = −q_j
//! ```
//!
//! No unknown and far from linear: found by full evaluation.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct JointSign;

impl Effect for JointSign {
    fn name(&self) -> &'static str {
        "joint_sign"
    }

    fn stage(&self) -> Stage {
        Stage::Wiring
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        setting.joints()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        Vec::new()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Target::Joint(j) = *target {
            at.joints[j] = at.neg(at.joints[j]);
            at.wired[j] = at.joints[j];
        }
    }

    fn values(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<Value> {
        Vec::new()
    }

    fn unknowns(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
