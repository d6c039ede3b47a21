#![doc = include_str!("pages/backlash.md")]

use super::remedy::degrees;
use super::{Effect, EffectContext, Measured, Parameter, Reason, Target, plausible};
use crate::expr::Id;

pub(super) struct Backlash;

impl Effect for Backlash {
    kind!("backlash", Bends, all_and_each_revolute);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const { &[Parameter::new("width_rad", 0.02)] }
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("backlash in {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let name = context.spoken_name(target);
        format!(
            "true angle of {name} = reading ± {}, to the side that gravity turns it to; the play \
             itself is the gear's",
            degrees(0.5 * values[0])
        )
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let half = at.constant(0.5);
        let half = at.mul(half, unknowns[0]);
        for joint in target.revolute(at.robot()) {
            at.slack(joint, half);
        }
    }

    fn dead_band(&self) -> Option<f64> {
        Some(0.01)
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let mut violation = vec![(-unknowns[0]).max(0.0) / 0.0005];
        violation.extend(super::beyond(unknowns[0], 0.35, 0.05));
        violation
    }

    fn invalid_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
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

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        plausible::above(plausible::WIDEST_BACKLASH_RAD, values[0])
    }
}
