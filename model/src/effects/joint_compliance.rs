#![doc = include_str!("pages/joint_compliance.md")]

use super::remedy::digits;
use super::{Effect, EffectContext, Fitted, Measured, Parameter, Reason, Target, plausible};
use crate::expr::Id;

pub(super) struct JointCompliance;

impl Effect for JointCompliance {
    kind!("joint_compliance", Bends, all_and_each_revolute);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        // Fitted are rad per metre of moment over weight.
        const { &[Parameter::new("stiffness_nm_per_rad", 0.3).fitted(Fitted::WeightOver)] }
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("compliance of {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let name = context.spoken_name(target);
        format!(
            "true angle of {name} = reading + gravity moment / ({} Nm/rad)",
            digits(values[0], 3)
        )
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        for joint in target.revolute(at.robot()) {
            at.spring(joint, unknowns[0]);
        }
    }

    fn is_spring(&self) -> bool {
        true
    }

    fn bound_violation(&self, context: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        // Springs push back; beyond half of what buckles under the robot's own
        // weight it could not have stood.
        let most = 0.5 / context.height();
        let mut violation = vec![(-unknowns[0]).max(0.0) / 0.005];
        violation.extend(super::beyond(unknowns[0], most, 0.1 * most));
        violation
    }

    fn invalid_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let soft = values[0] <= 0.0;
        soft.then_some("a stiffness of 0 or less holds nothing; give Nm/rad above 0")
    }

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let pushes_back = values[0] > 0.0;
        (!pushes_back).then_some(plausible::STIFFNESS)
    }
}
