#![doc = include_str!("pages/joint_swap.md")]

use super::{Effect, EffectContext, Measured, Target};
use crate::expr::Id;

pub(super) struct JointSwap;

impl Effect for JointSwap {
    kind!("joint_swap", Wiring);

    fn targets(&self, context: &EffectContext) -> Vec<Target> {
        let joints = context.revolute();
        let pairs = joints.iter().enumerate();
        pairs
            .flat_map(|(k, &a)| joints[k + 1..].iter().map(move |&b| Target::Joints(a, b)))
            .collect()
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!(
            "encoders of {} plugged into each other's channel",
            name.replace(',', " and ")
        )
    }

    fn remedy(&self, context: &EffectContext, target: &Target, _: &[f64]) -> String {
        let name = context.name_of(target).replace(',', " and ");
        format!("exchange the channels of {name}: each encoder is read as the other's")
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Target::Joints(a, b) = *target {
            at.joints.swap(a, b);
            at.wired.swap(a, b);
        }
    }
}
