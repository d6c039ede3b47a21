//! A plan: on the console, and as a page with figures.

#[cfg(test)]
mod tests;

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use crate::report::figures;
use crate::report::html::render;
use crate::report::next_steps::{self, Worded};
use crate::report::origin::Origin;
use crate::report::robot::{Card, Shown};
use crate::report::table::{lines, mm};
use sesc_identify::plan::{Lesson, Plan};
use sesc_identify::skeleton::Skeleton;
use sesc_model::text::listed;

/// Postures on the contact sheet, at most.
const SHEET: usize = 120;
/// Pairs of links that are named, at most.
const EXEMPT: usize = 8;

/// What is not checked.
const WAY: &str = "only the postures are checked, not the way from one to the next";

/// Where the CoP may be.
fn cop(plan: &Plan) -> String {
    format!(
        "{}, with {} standard deviations to spare ({} mm each on average)",
        plan.cop_region,
        plan.sigmas,
        mm(plan.draws.cop_std)
    )
}

/// By how much the planned postures are better than random ones, whole percents.
fn less(plan: &Plan) -> Option<f64> {
    let (planned, random) = plan.expected_error.zip(plan.expected_error_random)?;
    Some((100.0 * (1.0 - planned / random)).round())
}

/// What a posture teaches.
fn lesson(own: &Lesson) -> Value {
    let number = |x: f64| match own.unit {
        "m" => mm(x),
        _ => format!("{:.2}", 1e3 * x),
    };
    context! {
        name => &own.parameter,
        before => number(own.before),
        after => number(own.after),
        unit => if own.unit == "m" { "mm" } else { "‰" },
    }
}

/// The page of a plan, alone in one file; `command` makes it again, `file` holds the
/// postures.
pub fn page(
    plan: &Plan,
    next: &[Worded],
    skeleton: &Skeleton,
    file: &str,
    command: &str,
) -> Result<String, Error> {
    let figure = Value::from_safe_string;
    // Little of its range tells little of what a joint carries.
    let idle = plan.joints.iter().filter(|joint| {
        let [used, allowed] = [joint.used, joint.limits].map(|[low, high]| high - low);
        used < 0.2 * allowed
    });
    let idle: Vec<String> = idle.map(|joint| joint.joint.clone()).collect();
    let postures: Vec<&[f64]> = plan.postures().collect();
    let shown = postures.iter().zip(&plan.cop).zip(1..);
    let shown = shown.map(|((q, cop), pose)| Shown {
        pose,
        q: q.to_vec(),
        planned: Some(*cop),
        ..Shown::default()
    });
    let caption = "Quartered disc: centre of mass, with its plumb line. Right, the CoP that is \
                   expected of each posture, in their order, with what CAD does not know kept from \
                   the edge.";
    let beside = Some(figures::plan::region(plan));
    let card = Card {
        beside,
        ..Card::new(skeleton, shown.collect(), caption.to_string())
    };
    let sheet = figures::robot::sheet(skeleton, &postures[..postures.len().min(SHEET)]);
    let context = context! {
        robot => card.context(),
        sheet => sheet.into_iter().map(Value::from_safe_string).collect::<Vec<Value>>(),
        lessons => plan.lessons.iter().take(SHEET).map(lesson).collect::<Vec<Value>>(),
        more => postures.len().saturating_sub(SHEET),
        plan => Serde(plan),
        drawn => plan.drawn(),
        cop => cop(plan),
        way => WAY,
        less => less(plan),
        next => next_steps::context(next),
        idle,
        file,
        origin => Origin {
            robot: [&plan.robot, &plan.hash],
            command,
            ..Origin::default()
        }
        .context(),
        figures => context! {
            efficiency => figure(figures::plan::efficiency(&plan.curve)),
            joints => figure(figures::plan::joints(&plan.joints)),
        },
    };
    render("plan.html", context)
}

// The console's account of a plan.

/// What was drawn, what was chosen, and what it will be good for.
pub fn text(plan: &Plan, next: &[Worded]) -> String {
    let (poses, candidates) = (plan.poses, plan.candidates);
    let about = format!(
        "{} on {}: {poses} postures of {candidates} candidates",
        plan.robot, plan.support
    );
    let mut facts = vec![("drawn", plan.drawn()), ("CoP", cop(plan))];
    facts.extend(plan.both_feet.iter().map(|feet| ("soles", feet.sentence())));
    facts.push(("revisits", plan.revisits.sentence.clone()));
    facts.push(("ground", plan.clearance.clone()));
    facts.push(("collisions", plan.collision.clone()));
    if !plan.collision_exempt.is_empty() {
        let pairs = plan.collision_exempt.iter().map(|pair| pair.join("–"));
        let pairs = listed(pairs, EXEMPT);
        facts.push(("", format!("touching at rest, not watched: {pairs}")));
    }
    facts.push(("prior", plan.prior.clone()));
    if let (Some(error), Some(random)) = (plan.expected_error, plan.expected_error_random) {
        let less = match less(plan) {
            Some(less) if less > 0.0 => format!("{less} % less"),
            _ => "here any postures do".to_string(),
        };
        let [error, random, noise] = [error, random, plan.noise].map(mm);
        let text = format!("{error} mm over all candidates, from readings to {noise} mm");
        facts.push(("expected error", text));
        let text = format!("{random} mm with postures chosen at random: {less}");
        facts.push(("", text));
    }
    let (rank, condition) = (plan.rank, plan.condition_number);
    let conditioning = format!("{rank} directions told, condition number {condition:.0}");
    let gain = plan.log_det[plan.log_det.len() - 1] - plan.log_det[0];
    let exchanges = plan.exchanges;
    let choice = format!("greedy, then {exchanges} exchanges: log det + {gain:.2}");
    let [ordered, chosen] = [plan.motion.ordered, plan.motion.as_chosen].map(f64::to_degrees);
    let motion =
        format!("{ordered:.0}° in this order, {chosen:.0}° as chosen (largest joint, summed)");
    facts.extend([
        ("conditioning", conditioning),
        ("choice", choice),
        ("motion", motion),
    ]);
    facts.extend(plan.notes.iter().map(|note| ("note", note.clone())));
    facts.push(("note", WAY.to_string()));
    format!("{about}\n\n{}{}", lines(facts), next_steps::text(next))
}
