#![doc = include_str!("pages/unsettled_motion.md")]

use super::remedy::digits;
use super::{
    Carry, Effect, EffectContext, EffectId, Experiment, Measured, Parameter, PostureContext, Stage,
    Target, plausible,
};
use crate::expr::Id;
use crate::inertia::GRAVITY;

pub(super) struct UnsettledMotion;

impl Effect for UnsettledMotion {
    fn id(&self) -> EffectId {
        EffectId::new("unsettled_motion")
    }

    fn page(&self) -> &'static str {
        include_str!("pages/unsettled_motion.md")
    }

    fn stage(&self) -> Stage {
        Stage::Joints
    }

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        match context.times {
            true => vec![Target::Whole],
            false => Vec::new(),
        }
    }

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[Parameter::new("share", 0.3)];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "readings taken while the robot still moved".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        format!(
            "readings hold {} of the inertia of the motion; let the robot come to rest before \
             each reading",
            digits(values[0], 3)
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        // c(q) − a (z/g) c'' is c where joints lag by a (z/g) q'', to first order.
        let layout = PostureContext::of(at.robot());
        let height = at.constant(at.robot().cad_height() / GRAVITY);
        let lag = at.mul(height, unknowns[0]);
        for joint in 0..at.robot().dof() {
            let acceleration = at.posture_context(layout.acceleration(joint));
            let moved = at.mul(lag, acceleration);
            let back = at.neg(moved);
            at.shift_joint(joint, back);
        }
    }

    fn is_static(&self) -> bool {
        false
    }

    fn in_experiment(&self, _: Experiment, _: &Target) -> Carry {
        Carry::Gone
    }

    fn implausible_reason(
        &self,
        _: &EffectContext,
        _: &Target,
        values: &[f64],
    ) -> Option<&'static str> {
        plausible::outside(plausible::DYNAMIC_SHARE, values[0])
    }
}
