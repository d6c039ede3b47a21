//! Two encoders are plugged into each other's channel.
//!
//! ```text
//! φ_a = q_b            φ_b = q_a
//! ```
//!
//! No unknown and far from linear: found by full evaluation of every pair.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct JointSwap;

impl Effect for JointSwap {
    fn name(&self) -> &'static str {
        "joint_swap"
    }

    fn stage(&self) -> Stage {
        Stage::Wiring
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        let joints = setting.turning();
        let pairs = joints.iter().enumerate();
        pairs
            .flat_map(|(k, &a)| joints[k + 1..].iter().map(move |&b| Target::Joints(a, b)))
            .collect()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        Vec::new()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Target::Joints(a, b) = *target {
            at.joints.swap(a, b);
            at.wired.swap(a, b);
        }
    }

    fn values(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<Value> {
        Vec::new()
    }

    fn unknowns(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }
}
