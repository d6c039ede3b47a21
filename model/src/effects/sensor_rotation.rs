//! The sensor is turned about the vertical.
//!
//! ```text
//! y = Rot(ψ) p         ψ in rad, counter-clockwise seen from above
//! ```
//!
//! Nothing imitates it (residual share 0.99 on bench postures). Linearised
//! rotations are wrong by ψ²/2 of the CoP: sine and cosine are kept.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct SensorRotation;

impl Effect for SensorRotation {
    fn name(&self) -> &'static str {
        "sensor_rotation"
    }

    fn stage(&self) -> Stage {
        Stage::Rotation
    }

    fn targets(&self, _: &Setting) -> Vec<Target> {
        vec![Target::Whole]
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.05]
    }

    fn rewrite(&self, _: &Target, at: &mut Measured, unknowns: &[Id]) {
        let [x, y] = at.reading;
        let g = at.g();
        let (s, c) = (g.sin(unknowns[0]), g.cos(unknowns[0]));
        let (cx, sy) = (g.mul(c, x), g.mul(s, y));
        let (sx, cy) = (g.mul(s, x), g.mul(c, y));
        at.reading = [at.sub(cx, sy), at.add(sx, cy)];
    }

    fn values(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        super::plain(&["yaw_rad"], unknowns)
    }

    fn unknowns(&self, _: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        values.to_vec()
    }

    fn undo(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        let back = at.neg(unknowns[0]);
        self.rewrite(target, at, &[back]);
    }
}
