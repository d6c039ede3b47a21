//! A link carries a mass that its URDF does not know, or lacks one.
//!
//! ```text
//! r' = (1 − μ) r + W_l (μ, μ p)          μ = m / (M + m), p in the link's frame, m
//! ```
//!
//! Linear in μ and μ p. A load on the foot is imitated by a sensor offset, loads
//! on neighbouring links by each other while their arms change little; the sum
//! of raw cells shows the mass itself. Bounds: the arm stays within reach of the
//! link, no more is missing than the link's body has.

use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct Payload;

impl Effect for Payload {
    fn name(&self) -> &'static str {
        "payload"
    }

    fn stage(&self) -> Stage {
        Stage::Loads
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        setting.links()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.03, 0.002, 0.002, 0.002]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Link(link) = *target {
            at.load(link, unknowns[0], [unknowns[1], unknowns[2], unknowns[3]]);
        }
    }

    fn values(&self, setting: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        let share = unknowns[0];
        let mass = setting.mass() * share / (1.0 - share);
        let names = ["mass_kg", "x_m", "y_m", "z_m"];
        let at = |k: usize| unknowns[k] / share;
        super::plain(&names, &[mass, at(1), at(2), at(3)])
    }

    fn unknowns(&self, setting: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        let share = values[0] / (setting.mass() + values[0]);
        let moment = |k: usize| share * values[k];
        vec![share, moment(1), moment(2), moment(3)]
    }

    fn excess(&self, setting: &Setting, target: &Target, unknowns: &[f64]) -> Vec<f64> {
        let Target::Link(link) = *target else {
            return Vec::new();
        };
        let share = unknowns[0];
        let moment = unknowns[1..4].iter().map(|x| x * x).sum::<f64>();
        let lever = setting.lever_of(link);
        // |μ p| ≤ lever |μ|: an arm too long, in shares of a tenth of a percent.
        let long = (libm::sqrt(moment) - lever * libm::fabs(share)).max(0.0) / lever;
        let missing = setting.mass_of(link) / setting.mass();
        let lacking = (-share - missing / (1.0 - missing).max(1e-3)).max(0.0);
        let heavy = (share - 0.5).max(0.0);
        vec![long / 1e-3, lacking / 1e-3, heavy / 0.02]
    }

    fn fault(&self, setting: &Setting, _: &Target, values: &[f64]) -> Option<&'static str> {
        let gone = values[0] <= -setting.mass();
        gone.then_some("more is missing than the robot weighs; give mass_kg above that")
    }
}
