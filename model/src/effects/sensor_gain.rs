#![doc = include_str!("pages/sensor_gain.md")]

use super::remedy::digits;
use super::{Effect, EffectContext, Fitted, Measured, Parameter, Reason, Target, plausible};
use crate::expr::Id;

pub(super) struct SensorGain;

impl Effect for SensorGain {
    kind!("sensor_gain", Gain);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("gain_x", 0.05).fitted(Fitted::LessOne),
            Parameter::new("gain_y", 0.05).fitted(Fitted::LessOne),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "a gain of the sensor".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        format!(
            "true CoP = reading / {} in x, reading / {} in y; calibrate the sensor",
            digits(values[0], 4),
            digits(values[1], 4)
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            let (p, g) = (at.reading[axis], at.g());
            let one = g.constant(1.0);
            let gain = g.add(one, unknown);
            at.reading[axis] = at.mul(gain, p);
        }
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        // A gain near zero leaves no signal; a negative one is a wiring error.
        let (_, largest, _) = plausible::SENSOR_GAIN;
        let beyond = |g: &f64| (-0.6 - g).max(g + 1.0 - largest).max(0.0);
        unknowns.iter().map(|g| beyond(g) / 0.05).collect()
    }

    fn invalid_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let zero = values.contains(&0.0);
        zero.then_some("a gain of 0 shows no CoP; leave it out or give another")
    }

    fn undo(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            let (y, one) = (at.reading[axis], at.constant(1.0));
            let gain = at.add(one, unknown);
            at.reading[axis] = at.div(y, gain);
        }
    }

    fn implausible_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let outside = |gain: &f64| plausible::outside(plausible::SENSOR_GAIN, *gain);
        values.iter().find_map(outside)
    }
}
