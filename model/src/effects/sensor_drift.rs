#![doc = include_str!("pages/sensor_drift.md")]

use super::remedy::{millimetres, signed};
use super::{
    Carry, Effect, EffectContext, Experiment, Measured, Parameter, PostureContext, Target,
};
use crate::expr::Id;

pub(super) struct SensorDrift;

impl Effect for SensorDrift {
    kind!("sensor_drift", Offset);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("drift_x_m", 0.002),
            Parameter::new("drift_y_m", 0.002),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "a drift of the sensor over the log".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        let of = |k: usize| signed(millimetres(-values[k]));
        format!(
            "true CoP = reading {} in x, {} in y at the end of the log, in proportion before; set \
             the zero of the sensor more often",
            of(0),
            of(1)
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        let place = PostureContext::of(at.robot()).place();
        let u = at.posture_context(place);
        for (axis, &unknown) in unknowns.iter().enumerate() {
            let moved = at.mul(u, unknown);
            at.reading[axis] = at.add(at.reading[axis], moved);
        }
    }

    fn is_static(&self) -> bool {
        false
    }

    fn in_experiment(&self, _: Experiment, _: &Target) -> Carry {
        Carry::Gone
    }
}
