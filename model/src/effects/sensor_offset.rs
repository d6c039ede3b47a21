#![doc = include_str!("pages/sensor_offset.md")]

use super::remedy::{millimetres, signed};
use super::{Effect, EffectContext, Measured, Parameter, Target};
use crate::expr::Id;

pub(super) struct SensorOffset;

impl Effect for SensorOffset {
    kind!("sensor_offset", Offset);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("offset_x_m", 0.002),
            Parameter::new("offset_y_m", 0.002),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "an offset of the sensor".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        let of = |k: usize| signed(millimetres(-values[k]));
        format!(
            "true CoP = reading {} in x, {} in y; set the zero of the sensor",
            of(0),
            of(1)
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.reading[axis] = at.add(at.reading[axis], unknown);
        }
    }

    fn undo(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.reading[axis] = at.sub(at.reading[axis], unknown);
        }
    }
}
