//! The ground is not level.
//!
//! ```text
//! p = c_xy + c_z θ     θ: rise over run, so gravity points along (θ_x, θ_y, −1)
//! ```
//!
//! Imitated by an ankle's offset (they differ by the ankle's height only), and by
//! a sensor offset or a tether while the CoM keeps its height. The same postures
//! after a turn by 180° on the floor separate it completely.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct GroundSlope;

impl Effect for GroundSlope {
    fn name(&self) -> &'static str {
        "ground_slope"
    }

    fn stage(&self) -> Stage {
        Stage::Ground
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        vec![Target::Whole]
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.01; 2]
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        for (axis, &unknown) in unknowns.iter().enumerate() {
            at.tilt[axis] = at.add(at.tilt[axis], unknown);
        }
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["slope_x", "slope_y"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }
}
