//! Something pulls at a link: a tether, a cable, a hand.
//!
//! ```text
//! N = M g − F_z        p = (M g c_xy − F_z x + F_xy z) / N          F in N, at the
//!                      origin (x, z) of the link, in the support frame
//! ```
//!
//! The vertical part is a load of mass −F_z/g there, and can never be told from
//! it: what pulls down is called a payload, a force pulls sideways or up. The horizontal part is imitated by a slope, an offset, an ankle: whatever
//! shifts the CoP alike in all postures. Repeat the log without the tether.

use super::setting::GRAVITY;
use super::{Effect, Measured, Setting, Stage, Target, Value};
use crate::expr::Id;

pub(super) struct ExternalForce;

impl Effect for ExternalForce {
    fn name(&self) -> &'static str {
        "external_force"
    }

    fn stage(&self) -> Stage {
        Stage::Loads
    }

    fn targets(&self, setting: &Setting) -> Vec<Target> {
        setting.links()
    }

    fn scales(&self, _: &Setting, _: &Target) -> Vec<f64> {
        vec![0.02; 3]
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Link(link) = *target {
            at.pull(link, [unknowns[0], unknowns[1]], unknowns[2]);
        }
    }

    fn values(&self, setting: &Setting, _: &Target, unknowns: &[f64]) -> Vec<Value> {
        // Unknowns: F_xy / N, and the load's share μ = −F_z / N.
        let share = unknowns[2];
        let ground = setting.weight() / (1.0 - share);
        let forces = [ground * unknowns[0], ground * unknowns[1], -ground * share];
        super::plain(&["force_x_n", "force_y_n", "force_z_n"], &forces)
    }

    fn unknowns(&self, setting: &Setting, _: &Target, values: &[f64]) -> Vec<f64> {
        let ground = setting.mass() * GRAVITY - values[2];
        vec![values[0] / ground, values[1] / ground, -values[2] / ground]
    }

    fn excess(&self, _: &Setting, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let beyond = |x: &f64| (x.abs() - 0.5).max(0.0) / 0.02;
        let mut excess: Vec<f64> = unknowns.iter().map(beyond).collect();
        // A pull straight down is a load in every reading, and is called one.
        excess.push(unknowns[2].max(0.0) / 0.002);
        excess
    }

    fn fault(&self, setting: &Setting, _: &Target, values: &[f64]) -> Option<&'static str> {
        let lifted = values[2] >= setting.weight();
        lifted.then_some("it lifts the robot off the ground; give force_z_n below its weight")
    }
}
