//! What is stated of an explanation: its steps, the members of its class, what it leaves, and what
//! the log hardly shows.

use std::f64::consts::FRAC_PI_2;

use sesc_model::effects::Unit;

use super::criteria;
use super::findings::{ActsOn, Blind, Last, Leftover, Member, Quantity, Step, Suspect};
use super::held_out::HeldOut;
use super::hypothesis::Term;
use super::leftover::{self, Misfit};
use super::problem::{Fit, Problem};
use super::remedy::Remedy;
use super::words::{self, capital};

/// The steps in the order in which they close the gap, each with its place among the terms.
pub(super) fn told(
    problem: &Problem,
    best: &Fit,
    steps: &[Fit],
    start: &HeldOut,
    held: &[HeldOut],
    evidence: &[f64],
) -> Vec<(usize, Step)> {
    let values = words::values(problem, best);
    let mut before: Vec<Term> = Vec::new();
    let mut told = Vec::new();
    for (k, step) in steps.iter().enumerate() {
        let Some(at) = best
            .terms
            .iter()
            .position(|i| step.terms.contains(i) && !before.contains(i))
        else {
            continue;
        };
        let term = &best.terms[at];
        before.push(term.clone());
        let rmse_before = if k == 0 { start.rmse } else { held[k - 1].rmse };
        let step = Step {
            effect: term.name(),
            target: term.target_name(&problem.first().context),
            acts_on: ActsOn::of(term, &problem.first().context),
            parameters: values[at]
                .iter()
                .map(|v| {
                    (
                        v.name,
                        Quantity {
                            value: v.value,
                            std: v.std,
                        },
                    )
                })
                .collect(),
            fitted: term.fitted(&problem.first().context),
            rmse_before,
            rmse_after: held[k].rmse,
            evidence: evidence[at],
            sentence: format!(
                "{}: the held-out gap {} from {:.2} mm to {:.2} mm.",
                capital(&words::clause(&problem.first().context, term, &values[at])),
                if held[k].rmse > rmse_before {
                    "rises"
                } else {
                    "falls"
                },
                1e3 * rmse_before,
                1e3 * held[k].rmse
            ),
            remedy: Remedy::default(),
        };
        told.push((at, step));
    }
    told
}

/// The held-out errors of the last step.
pub(super) fn last(held: &HeldOut) -> Last {
    Last {
        rmse: held.rmse,
        rmse_x: held.rmse_x,
        rmse_y: held.rmse_y,
        left_out: held.left_out,
    }
}

/// The effects of an explanation as people call them, each with its label.
fn subjects(problem: &Problem, fit: &Fit) -> String {
    let each = fit
        .terms
        .iter()
        .map(|term| term.subject(&problem.first().context));
    each.collect::<Vec<_>>().join(" with ")
}

/// The explanations of a class, as they are listed.
pub(super) fn members(problem: &Problem, class: &[Fit]) -> Vec<Member> {
    let first = class.first().map_or(0.0, Fit::score);
    class
        .iter()
        .filter(|f| !f.terms.is_empty())
        .map(|fit| {
            let values = words::values(problem, fit);
            let clauses = fit.terms.iter().zip(&values);
            let clauses = clauses.map(|(i, v)| words::clause(&problem.first().context, i, v));
            Member {
                effects: fit
                    .terms
                    .iter()
                    .map(|i| i.label(&problem.first().context))
                    .collect(),
                score_difference: fit.score() - first,
                sentence: capital(&clauses.collect::<Vec<_>>().join(", with ")),
                subjects: subjects(problem, fit),
                com_apart: None,
            }
        })
        .collect()
}

/// What the best explanation leaves, and what that goes with where it is unexplained.
pub(super) fn rest(problem: &Problem, best: &Fit, unexplained: bool) -> (Leftover, Vec<Suspect>) {
    let now = Misfit::of(problem, best);
    let suspects = match unexplained && now.is_clear() {
        true => leftover::suspects(problem, best),
        false => Vec::new(),
    };
    let leftover = Leftover {
        chi2: now.chi2,
        expected: now.expected,
        suspect_share: suspects.first().map_or(0.0, |first| first.1),
    };
    let suspects = suspects.into_iter().map(|(suspect, _)| suspect);
    (leftover, suspects.collect())
}

/// Postures that are put aside as outliers.
pub(super) fn outliers(problem: &Problem, best: &Fit) -> Vec<i64> {
    let named = best.outliers.as_ref().map_or_else(Vec::new, |o| o.named());
    named
        .into_iter()
        .map(|k| problem.first().data.pose[k])
        .collect()
}

/// Joint offsets with the size from which this log shows them: those that it hardly shows, the
/// largest first, and those of the joints that carry most of the mass, the smallest first.
pub(super) fn detectable(problem: &Problem, visible: &[(Term, f64)]) -> (Vec<Blind>, Vec<Blind>) {
    let context = &problem.first().context;
    let reach = context.robot.reach();
    let mut spots = Vec::new();
    for (term, chi2) in visible {
        let Some(instance) = term.effect() else {
            continue;
        };
        if !instance.effect.reports_smallest_detectable() {
            continue;
        }
        let scales = term.scales(context);
        let from = scales[0] * (criteria::VISIBLE / chi2.max(1e-9)).sqrt();
        let parameters = instance.effect.parameters(context, &instance.target);
        let unit = parameters.first().map_or(Unit::One, |p| p.unit);
        spots.push(Blind {
            effect: term.label(context),
            target: context.name_of(&instance.target),
            from,
            size: match unit.shown() {
                _ if unit == Unit::Radian && from > FRAC_PI_2 => "over 90°".to_string(),
                // More than the whole robot reaches.
                _ if unit == Unit::Metre && from > reach => {
                    format!("over {:.0} mm", 1e3 * reach)
                }
                (factor, symbol) => {
                    let digits = (1.0 - (factor * from).log10().floor()).clamp(0.0, 3.0) as usize;
                    let gap = if symbol == "°" { "" } else { " " };
                    format!("{:.digits$}{gap}{symbol}", factor * from)
                }
            },
        });
    }
    spots.sort_by(|a, b| a.from.total_cmp(&b.from));
    let bodies = &context.robot.chain.bodies;
    let carried = |spot: &Blind| {
        let body = bodies
            .iter()
            .find(|body| body.joint.as_ref() == Some(&spot.target));
        body.map_or(0.0, |body| body.carried)
    };
    let most = spots.iter().map(carried).fold(0.0, f64::max);
    let half = most.min(0.5 * bodies[0].carried);
    let bearing = spots.iter().filter(|spot| carried(spot) >= half).cloned();
    let bearing = bearing.collect();
    // A smaller offset than this is no gap in what the log shows.
    spots.retain(|spot| spot.from >= criteria::SMALLEST_REPORTED);
    spots.reverse();
    (spots, bearing)
}
