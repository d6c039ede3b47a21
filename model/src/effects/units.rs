//! A column is in another unit than the log says.
//!
//! ```text
//! φ = q π/180 (degrees)       y = 1000 p (millimetres)       y = 100 p (centimetres)
//! ```
//!
//! No unknown and far from linear: found by full evaluation.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct Units;

impl Effect for Units {
    fn name(&self) -> &'static str {
        "units"
    }

    fn stage(&self) -> Stage {
        Stage::Wiring
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        ["degrees", "millimetres", "centimetres"]
            .map(Target::Way)
            .to_vec()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        Vec::new()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        match target {
            Target::Way("degrees") => {
                let radians = at.constant(core::f64::consts::PI / 180.0);
                for joint in at.turning(&Target::AllJoints) {
                    at.joints[joint] = at.mul(radians, at.joints[joint]);
                    at.wired[joint] = at.joints[joint];
                }
            }
            Target::Way("centimetres") => at.record_scale = 100.0,
            _ => at.record_scale = 1000.0,
        }
    }

    fn values(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<Value> {
        Vec::new()
    }

    fn unknowns(&self, _: &Setting, _: &Target, _: &[f64]) -> Vec<f64> {
        Vec::new()
    }

    fn of_sensor(&self, target: &Target) -> bool {
        *target != Target::Way("degrees")
    }
}
