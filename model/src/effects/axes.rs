#![doc = include_str!("pages/sensor_axes.md")]

use super::{Effect, EffectContext, Measured, Target};
use crate::expr::Id;

pub(super) struct SensorAxes;

impl Effect for SensorAxes {
    kind!("sensor_axes", Record);

    fn targets(&self, _: &EffectContext) -> Vec<Target> {
        ["swapped", "flip_x", "flip_y"].map(Target::Way).to_vec()
    }

    fn phrase(&self, target: &Target, _: &str) -> String {
        match target {
            Target::Way("swapped") => "swapped axes of the sensor".to_string(),
            Target::Way("flip_x") => "a flipped x axis of the sensor".to_string(),
            _ => "a flipped y axis of the sensor".to_string(),
        }
    }

    fn remedy(&self, _: &EffectContext, target: &Target, _: &[f64]) -> String {
        match target {
            Target::Way("swapped") => {
                "true x = reading of y, true y = reading of x; exchange the axes"
            }
            Target::Way("flip_x") => "true x = −reading of x; reverse that axis of the sensor",
            _ => "true y = −reading of y; reverse that axis of the sensor",
        }
        .to_string()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        let [x, y] = at.reading;
        at.reading = match target {
            Target::Way("swapped") => [y, x],
            Target::Way("flip_x") => [at.neg(x), y],
            _ => [x, at.neg(y)],
        };
    }

    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        // Each way is its own inverse.
        self.rewrite(target, at, unknowns);
    }
}
