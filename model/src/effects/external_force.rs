#![doc = include_str!("pages/external_force.md")]

use super::remedy::signed;
use super::{
    Carry, Effect, EffectContext, Experiment, Measured, Parameter, Reason, Target, plausible,
};
use crate::expr::Id;
use crate::inertia::GRAVITY;

pub(super) struct ExternalForce;

impl Effect for ExternalForce {
    kind!("external_force", Loads, links);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("force_x_n", 0.02),
            Parameter::new("force_y_n", 0.02),
            Parameter::new("force_z_n", 0.02),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("a force that pulls at {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let name = context.name_of(target);
        let of = |k: usize| signed(format!("{:.3} N", values[k]));
        format!(
            "a force of x {}, y {}, z {} acts at {name}; take away what pulls there and take the \
             log again",
            of(0),
            of(1),
            of(2)
        )
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Link(link) = *target {
            at.pull(link, [unknowns[0], unknowns[1]], unknowns[2]);
        }
    }

    fn changes_body(&self, _: &Target) -> bool {
        // The body is the same in the next room, where nothing pulls.
        false
    }

    fn load_share(&self, unknowns: &[f64], _: f64) -> f64 {
        unknowns[2]
    }

    fn in_experiment(&self, experiment: Experiment, _: &Target) -> Carry {
        match experiment {
            // The tether stays in the room while the robot turns.
            Experiment::Turned => Carry::Scaled(vec![-1.0, -1.0, 1.0]),
            Experiment::Untouched => Carry::Gone,
            _ => Carry::Same,
        }
    }

    fn values(&self, context: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        // Unknowns: F_xy / N, and the load's share μ = −F_z / N.
        let share = unknowns[2];
        let ground = context.weight() / (1.0 - share);
        vec![ground * unknowns[0], ground * unknowns[1], -ground * share]
    }

    fn unknowns(&self, context: &EffectContext, _: &Target, values: &[f64]) -> Vec<f64> {
        let ground = context.mass() * GRAVITY - values[2];
        vec![values[0] / ground, values[1] / ground, -values[2] / ground]
    }

    fn bound_violation(&self, _: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let beyond = |x: &f64| (x.abs() - 0.5).max(0.0) / 0.02;
        let mut violation: Vec<f64> = unknowns.iter().map(beyond).collect();
        // A pull straight down is a load in every reading, and is called one.
        violation.push(unknowns[2].max(0.0) / 0.002);
        violation
    }

    fn invalid_reason(&self, context: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let lifted = values[2] >= context.weight();
        lifted.then_some("it lifts the robot off the ground; give force_z_n below its weight")
    }

    fn implausible_reason(&self, context: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let pull = libm::sqrt(values.iter().map(|force| force * force).sum());
        plausible::above(plausible::LARGEST_PULL, pull / context.weight())
    }
}
