//! The sensor wanders while the log is taken.
//!
//! ```text
//! y = p + u d          u from 0 (first posture) to 1 (last), by time where the
//!                      log has it, else by pose number; d in m over the log
//! ```
//!
//! Imitated by nothing that belongs to postures if their order is random; sorted
//! postures make it look like whatever they are sorted by.

use super::{Circumstances, Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct SensorDrift;

impl Effect for SensorDrift {
    fn name(&self) -> &'static str {
        "sensor_drift"
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
        let place = Circumstances::of(at.model()).place();
        let u = at.circumstance(place);
        for (axis, &unknown) in unknowns.iter().enumerate() {
            let moved = at.mul(u, unknown);
            at.reading[axis] = at.add(at.reading[axis], moved);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["drift_x_m", "drift_y_m"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn of_posture(&self) -> bool {
        false
    }
}
