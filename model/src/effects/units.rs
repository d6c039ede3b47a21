#![doc = include_str!("pages/units.md")]

use super::{Effect, EffectContext, Measured, Target};
use crate::expr::Id;

pub(super) struct Units;

impl Effect for Units {
    kind!("units", Wiring);

    fn targets(&self, _: &EffectContext) -> Vec<Target> {
        ["degrees", "millimetres", "centimetres"]
            .map(Target::Way)
            .to_vec()
    }

    fn phrase(&self, target: &Target, _: &str) -> String {
        match target {
            Target::Way("degrees") => "joint angles in degrees, not radians".to_string(),
            Target::Way("millimetres") => "a CoP in millimetres, not metres".to_string(),
            _ => "a CoP in centimetres, not metres".to_string(),
        }
    }

    fn remedy(&self, _: &EffectContext, target: &Target, _: &[f64]) -> String {
        match target {
            Target::Way("degrees") => {
                "true angle = reading × π/180: joint angles are in degrees; say so in the log's \
                 sidecar (angles = \"deg\")"
            }
            Target::Way("millimetres") => {
                "true CoP = reading / 1000: the CoP is in millimetres; write metres into the log"
            }
            _ => "true CoP = reading / 100: the CoP is in centimetres; write metres into the log",
        }
        .to_string()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        match target {
            Target::Way("degrees") => {
                let radians = at.constant(core::f64::consts::PI / 180.0);
                for joint in Target::AllJoints.revolute(at.robot()) {
                    at.joints[joint] = at.mul(radians, at.joints[joint]);
                    at.wired[joint] = at.joints[joint];
                }
            }
            Target::Way("centimetres") => at.record_scale = 100.0,
            _ => at.record_scale = 1000.0,
        }
    }

    fn is_unit(&self) -> bool {
        true
    }

    fn label_has_target(&self) -> bool {
        // Which unit it is belongs to the finding, not to its name.
        false
    }

    fn is_sensor_effect(&self, target: &Target) -> bool {
        *target != Target::Way("degrees")
    }
}
