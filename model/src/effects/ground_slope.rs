#![doc = include_str!("pages/ground_slope.md")]

use super::remedy::{degrees, signed};
use super::{
    Carry, Effect, EffectContext, Experiment, Measured, Parameter, Reason, Target, plausible,
};
use crate::expr::Id;

pub(super) struct GroundSlope;

impl Effect for GroundSlope {
    kind!("ground_slope", Ground);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("slope_x", 0.01),
            Parameter::new("slope_y", 0.01),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "a slope of the ground".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        let fall = |k: usize| signed(degrees(libm::atan(values[k])));
        format!(
            "the ground falls by {} towards +x and {} towards +y of the support frame; level it, \
             or expect true CoP = CoM + CoM height × ({:.4}, {:.4})",
            fall(0),
            fall(1),
            values[0],
            values[1]
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.tilt[axis] = at.add(at.tilt[axis], unknown);
        }
    }

    fn in_experiment(&self, experiment: Experiment, _: &Target) -> Carry {
        match experiment {
            // The ground stays as it is while the robot turns.
            Experiment::Turned => Carry::Scaled(vec![-1.0; 2]),
            _ => Carry::Same,
        }
    }

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let steepest = libm::hypot(values[0], values[1]);
        plausible::above(plausible::LARGEST_SLOPE, steepest)
    }
}
