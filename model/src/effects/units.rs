#![doc = include_str!("pages/units.md")]

use super::{Effect, EffectContext, Measured, Target};
use crate::expr::Id;

pub(super) struct Units;

/// What a reading can be in, how many of that a metre is, and what to do. A wrench whose force and
/// moment are in units that do not go together gives a CoP in none.
const READINGS: [(&str, f64, &str, &str); 5] = [
    (
        "millimetres",
        1000.0,
        "a CoP in millimetres, not metres",
        "true CoP = reading / 1000: the CoP is in millimetres; write metres into the log",
    ),
    (
        "centimetres",
        100.0,
        "a CoP in centimetres, not metres",
        "true CoP = reading / 100: the CoP is in centimetres; write metres into the log",
    ),
    (
        "inches",
        1.0 / 0.0254,
        "a CoP in inches, not metres",
        "true CoP = reading × 0.0254: the CoP is in inches; write metres into the log",
    ),
    (
        "kilograms_force",
        9.80665,
        "a CoP of forces in kgf and moments in N m",
        "true CoP = reading / 9.80665: forces are in kgf where moments are in N m; write both in N \
         and N m before the CoP is taken",
    ),
    (
        "pounds_force",
        4.448_221_615_260_5,
        "a CoP of forces in lbf and moments in N m",
        "true CoP = reading / 4.44822: forces are in lbf where moments are in N m; write both in N \
         and N m before the CoP is taken",
    ),
];

impl Effect for Units {
    kind!("units", Wiring);

    fn targets(&self, _: &EffectContext) -> Vec<Target> {
        let readings = READINGS.iter().map(|(name, ..)| *name);
        ["degrees"]
            .into_iter()
            .chain(readings)
            .map(Target::Way)
            .collect()
    }

    fn phrase(&self, target: &Target, _: &str) -> String {
        let own = reading(target).map(|(_, _, phrase, _)| *phrase);
        own.unwrap_or("joint angles in degrees, not radians")
            .to_string()
    }

    fn remedy(&self, _: &EffectContext, target: &Target, _: &[f64]) -> String {
        let own = reading(target).map(|(_, _, _, remedy)| *remedy);
        let degrees = "true angle = reading × π/180: joint angles are in degrees; say so in the \
                       log's sidecar (angles = \"deg\")";
        own.unwrap_or(degrees).to_string()
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, _: &[Id]) {
        if let Some((_, scale, ..)) = reading(target) {
            at.record_scale = *scale;
            return;
        }
        let radians = at.constant(core::f64::consts::PI / 180.0);
        for joint in Target::AllJoints.revolute(at.robot()) {
            at.joints[joint] = at.mul(radians, at.joints[joint]);
            at.wired[joint] = at.joints[joint];
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

/// The unit of the readings that a target is; none of degrees.
fn reading(target: &Target) -> Option<&'static (&'static str, f64, &'static str, &'static str)> {
    READINGS
        .iter()
        .find(|(name, ..)| *target == Target::Way(name))
}
