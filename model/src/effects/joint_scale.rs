#![doc = include_str!("pages/joint_scale.md")]

use super::remedy::EncoderMap;
use super::{Effect, EffectContext, Fitted, Measured, Parameter, Reason, Target, plausible};
use crate::expr::Id;

pub(super) struct JointScale;

impl Effect for JointScale {
    kind!("joint_scale", Joints, joints);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const { &[Parameter::new("scale", 0.05).fitted(Fitted::LessOne)] }
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("a wrong scale of {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let kind = context.by_kind(target, "angle", "position");
        let name = context.name_of(target);
        format!("true {kind} of {name} = {:.4} × reading", values[0])
    }

    fn encoder_map(&self, values: &[f64]) -> Option<EncoderMap> {
        Some(EncoderMap {
            scale: values[0],
            offset: 0.0,
        })
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Joint(j) = *target {
            // Of what the encoder says, whatever offset comes beside it.
            let q = at.wired[j];
            let stretched = at.mul(unknowns[0], q);
            at.shift_joint(j, stretched);
        }
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        super::beyond(unknowns[0], 0.9, 0.05)
    }

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        // A wrong sign is another effect.
        plausible::outside(plausible::JOINT_SCALE, libm::fabs(values[0]))
    }
}
