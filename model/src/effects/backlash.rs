//! A joint (or all alike) has a dead band and rests where gravity puts it.
//!
//! ```text
//! φ_j = q_j + (β/2) sign τ_j(φ)          β in rad, whole width
//! ```
//!
//! `τ` under everything else that is known; loose joints slide together from the
//! middle of their bands, at one speed. Imitated by the joint's offset while
//! gravity always loads it one way; postures approached from both sides, with
//! moments of both signs, separate them. Near zero moment a joint that carries
//! the robot can rest on either side: a fit takes the sides from the log.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct Backlash;

impl Effect for Backlash {
    fn name(&self) -> &'static str {
        "backlash"
    }

    fn stage(&self) -> Stage {
        Stage::Bends
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        let mut targets = vec![Target::AllJoints];
        targets.extend(setting.turning().into_iter().map(Target::Joint));
        targets
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.02]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let half = at.constant(0.5);
        let half = at.mul(half, unknowns[0]);
        for joint in at.turning(target) {
            at.slack(joint, half);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["width_rad"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn excess(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let mut excess = vec![(-unknowns[0]).max(0.0) / 0.0005];
        excess.extend(super::beyond(unknowns[0], 0.35, 0.05));
        excess
    }

    fn fault(&self, _: &Setting, _: &Target, values: &[f64]) -> Option<&'static str> {
        let negative = values[0] < 0.0;
        negative.then_some("a dead band is 0 or wider; give width_rad without its sign")
    }

    fn caution(&self) -> Option<&'static str> {
        Some(
            "backlash: the bound of cop is as large as the dead band lets the CoP move. Where a \
             joint's gravity moment is next to zero, rounding can flip the side it rests on; \
             everywhere else the error is that of com.",
        )
    }
}
