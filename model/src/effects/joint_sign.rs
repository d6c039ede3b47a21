//! An encoder counts backwards.
//!
//! ```text
//! φ_j = −q_j
//! ```
//!
//! No unknown and far from linear: found by full evaluation.

use super::{Effect, EffectContext, EffectId, Measured, Stage, Target};
use crate::expr::Id;

pub(super) struct JointSign;

impl Effect for JointSign {
    fn id(&self) -> EffectId {
        EffectId::new("joint_sign")
    }

    fn stage(&self) -> Stage {
        Stage::Wiring
    }

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        context.joints()
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("a reversed encoder of {name}")
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Target::Joint(j) = *target {
            at.joints[j] = at.neg(at.joints[j]);
            at.wired[j] = at.joints[j];
        }
    }
}
