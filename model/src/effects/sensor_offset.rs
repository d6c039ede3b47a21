//! The sensor's zero lies elsewhere.
//!
//! ```text
//! y = p + o            o in m
//! ```
//!
//! Imitated by a load on the foot, and by a slope, a tether or an ankle's offset
//! as long as the CoM keeps its height; turning the robot by 180° on the floor,
//! the other foot, or squats of different depth separate it. Source: the facts
//! of plate and insole sensors; `sensor_offset` of the study of discrepancies.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct SensorOffset;

impl Effect for SensorOffset {
    fn name(&self) -> &'static str {
        "sensor_offset"
    }

    fn stage(&self) -> Stage {
        Stage::Offset
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        vec![Target::Whole]
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.002; 2]
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.reading[axis] = at.add(at.reading[axis], unknown);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        let names = ["offset_x_m", "offset_y_m"];
        super::plain(&names, unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn undo(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.reading[axis] = at.sub(at.reading[axis], unknown);
        }
    }
}
