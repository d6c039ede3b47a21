//! The page of `sesc plan --report`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use crate::report::figures;
use crate::report::figures::robot::Marks;
use crate::report::html::render;
use crate::report::next_steps::{self, Worded};
use crate::report::origin::Origin;
use crate::report::robot::{Card, Correction, Shown};
use crate::report::table::mm;
use sesc_identify::plan::{Lesson, Plan};
use sesc_identify::skeleton::Skeleton;
use sesc_model::text::shortened;

/// Postures on the contact sheet, at most.
const SHEET: usize = 120;
/// Letters of a parameter under a posture.
const LETTERS: usize = 17;

/// What a posture teaches.
fn lesson(own: &Lesson) -> Value {
    let number = |x: f64| match own.unit {
        "m" => mm(x),
        _ => format!("{:.2}", 1e3 * x),
    };
    context! {
        name => &own.parameter,
        short => shortened(&own.parameter, LETTERS),
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
    let errors = plan.expected_error.zip(plan.expected_error_random);
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
    let card = Card {
        skeleton,
        postures: shown.collect(),
        apart: Vec::new(),
        beside: Some(figures::plan::region(plan)),
        caption: "Quartered disc: centre of mass, with its plumb line. Right, the CoP that is \
                  expected of each posture, in their order, with what CAD does not know kept \
                  from the edge."
            .to_string(),
        marks: Marks::default(),
        correction: Correction::default(),
    };
    let sheet = figures::robot::sheet(skeleton, &postures[..postures.len().min(SHEET)]);
    let context = context! {
        robot => card.context(),
        sheet => sheet.into_iter().map(Value::from_safe_string).collect::<Vec<Value>>(),
        lessons => plan.lessons.iter().take(SHEET).map(lesson).collect::<Vec<Value>>(),
        more => postures.len().saturating_sub(SHEET),
        plan => Serde(plan),
        drawn => plan.drawn(),
        less => errors.map(|(planned, random)| (100.0 * (1.0 - planned / random)).round()),
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
