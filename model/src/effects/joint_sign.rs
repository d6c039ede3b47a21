#![doc = include_str!("pages/joint_sign.md")]

use super::remedy::EncoderMap;
use super::{Effect, EffectContext, Measured, Target};
use crate::expr::Id;

pub(super) struct JointSign;

impl Effect for JointSign {
    kind!("joint_sign", Wiring, joints);

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("a reversed encoder of {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, _: &[f64]) -> String {
        let kind = context.by_kind(target, "angle", "position");
        let name = context.name_of(target);
        format!("true {kind} of {name} = −reading; reverse the sign of its encoder")
    }

    fn encoder_map(&self, _: &[f64]) -> Option<EncoderMap> {
        Some(EncoderMap {
            scale: -1.0,
            offset: 0.0,
        })
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Target::Joint(j) = *target {
            at.joints[j] = at.neg(at.joints[j]);
            at.wired[j] = at.joints[j];
        }
    }
}
