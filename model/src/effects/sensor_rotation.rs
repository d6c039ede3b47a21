#![doc = include_str!("pages/sensor_rotation.md")]

use super::remedy::degrees;
use super::{Effect, EffectContext, Measured, Parameter, Target};
use crate::expr::Id;

pub(super) struct SensorRotation;

impl Effect for SensorRotation {
    kind!("sensor_rotation", Rotation);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const { &[Parameter::new("yaw_rad", 0.05)] }
    }

    fn phrase(&self, _: &Target, _: &str) -> String {
        "a sensor turned about the vertical".to_string()
    }

    fn remedy(&self, _: &EffectContext, _: &Target, values: &[f64]) -> String {
        let way = if values[0] > 0.0 {
            "clockwise"
        } else {
            "counter-clockwise"
        };
        format!(
            "true CoP = reading turned {way} by {}, seen from above; mount the sensor straight",
            degrees(values[0].abs())
        )
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        let [x, y] = at.reading;
        let g = at.g();
        let (s, c) = (g.sin(unknowns[0]), g.cos(unknowns[0]));
        let (cx, sy) = (g.mul(c, x), g.mul(s, y));
        let (sx, cy) = (g.mul(s, x), g.mul(c, y));
        at.reading = [at.sub(cx, sy), at.add(sx, cy)];
    }

    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let back = at.neg(unknowns[0]);
        self.rewrite(target, at, &[back]);
    }
}
