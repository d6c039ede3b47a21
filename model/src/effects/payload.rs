#![doc = include_str!("pages/payload.md")]

use super::remedy::{grams, point};
use super::{
    Effect, EffectContext, Instance, Measured, Parameter, Reason, Target, UrdfEdit, plausible,
};
use crate::expr::Id;
use crate::urdf::Load;

/// A known weight on the heaviest link, which carries it without bending an arm:
/// `mass_kg` at `x_m` ahead of its origin, as an instance with its unknowns.
pub fn known_weight(
    context: &EffectContext,
    mass_kg: f64,
    x_m: f64,
) -> Option<(Instance, Vec<f64>)> {
    let mass_of = |target: &Target| match target {
        Target::Link(link) => context.mass_of(*link),
        _ => 0.0,
    };
    let links = context.links().into_iter();
    let target = links.max_by(|a, b| mass_of(a).total_cmp(&mass_of(b)))?;
    let unknowns = Payload.unknowns(context, &target, &[mass_kg, x_m, 0.0, 0.0]);
    let effect: &'static dyn Effect = &Payload;
    Some((Instance { effect, target }, unknowns))
}

/// So many lever arms from its link a load is on no robot.
const FAR: f64 = 10.0;

pub(super) struct Payload;

impl Effect for Payload {
    kind!("payload", Loads, links);

    fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
        const PARAMETERS: &[Parameter] = &[
            Parameter::new("mass_kg", 0.03),
            Parameter::new("x_m", 0.002),
            Parameter::new("y_m", 0.002),
            Parameter::new("z_m", 0.002),
        ];
        PARAMETERS
    }

    fn phrase(&self, _: &Target, name: &str) -> String {
        format!("an unknown mass on {name}")
    }

    fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
        let (name, at) = (context.name_of(target), point(&values[1..]));
        let mass = grams(values[0].abs());
        match values[0] < 0.0 {
            true => format!(
                "true mass of {name} = CAD − {mass}, missing at {at} in the frame of the link"
            ),
            false => format!(
                "true mass of {name} = CAD + {mass}, at {at} in the frame of the link; add it to \
                 the description or take it off the robot"
            ),
        }
    }

    fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
        if let Target::Link(link) = *target {
            at.load(link, unknowns[0], [unknowns[1], unknowns[2], unknowns[3]]);
        }
    }

    fn load_share(&self, unknowns: &[f64], _: f64) -> f64 {
        unknowns[0]
    }

    fn urdf_edit(&self, target: &str, value: &dyn Fn(&str) -> f64) -> Option<UrdfEdit> {
        Some(UrdfEdit::Mass(Load {
            link: target.to_string(),
            mass_kg: value("mass_kg"),
            at_m: [value("x_m"), value("y_m"), value("z_m")],
        }))
    }

    fn values(&self, context: &EffectContext, _: &Target, unknowns: &[f64]) -> Vec<f64> {
        let share = unknowns[0];
        let mass = context.mass() * share / (1.0 - share);
        let at = |k: usize| unknowns[k] / share;
        vec![mass, at(1), at(2), at(3)]
    }

    fn unknowns(&self, context: &EffectContext, _: &Target, values: &[f64]) -> Vec<f64> {
        let share = values[0] / (context.mass() + values[0]);
        let moment = |k: usize| share * values[k];
        vec![share, moment(1), moment(2), moment(3)]
    }

    fn bound_violation(
        &self,
        context: &EffectContext,
        target: &Target,
        unknowns: &[f64],
    ) -> Vec<f64> {
        let Target::Link(link) = *target else {
            return Vec::new();
        };
        let share = unknowns[0];
        let moment = unknowns[1..4].iter().map(|x| x * x).sum::<f64>();
        let lever = context.lever_of(link);
        // |μ p| ≤ lever |μ|: an arm too long, in shares of a tenth of a percent.
        let long = (libm::sqrt(moment) - lever * libm::fabs(share)).max(0.0) / lever;
        let missing = context.mass_of(link) / context.mass();
        let lacking = (-share - missing / (1.0 - missing).max(1e-3)).max(0.0);
        let heavy = (share - 0.5).max(0.0);
        vec![long / 1e-3, lacking / 1e-3, heavy / 0.02]
    }

    fn invalid_reason(&self, context: &EffectContext, _: &Target, values: &[f64]) -> Reason {
        let gone = values[0] <= -context.mass();
        gone.then_some("more is missing than the robot weighs; give mass_kg above that")
    }

    fn implausible_reason(
        &self,
        context: &EffectContext,
        target: &Target,
        values: &[f64],
    ) -> Reason {
        let Target::Link(link) = *target else {
            return None;
        };
        // A missing mass is taken from the body that the link is part of.
        let (lacks, lacking) = plausible::LACKING;
        let lacks = lacks * context.mass_of(link);
        let (part, on_the_foot) = plausible::ON_THE_FOOT;
        let on_the_foot = (part * context.mass(), on_the_foot);
        let stands = context.robot.chain.bodies[0].links.contains(&link);
        let far = libm::hypot(libm::hypot(values[1], values[2]), values[3]);
        match values[0] < 0.0 {
            _ if far > FAR * context.lever_of(link) => Some(plausible::PAYLOAD_FARTHER),
            true => plausible::above((lacks, lacking), -values[0]),
            false if stands => plausible::above(on_the_foot, values[0]),
            false => plausible::above((context.mass(), plausible::PAYLOAD_HEAVIER), values[0]),
        }
    }
}
