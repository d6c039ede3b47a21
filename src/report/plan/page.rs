//! The page of `sesc plan --report`.

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};

use crate::report::figures::plan as figures;
use crate::report::html::render;
use sesc_identify::plan::Plan;

/// The page of a plan, alone in one file; `command` makes it again, `file` holds the
/// postures.
pub fn page(plan: &Plan, file: &str, command: &str) -> Result<String, Error> {
    let figure = Value::from_safe_string;
    let errors = plan.expected_error.zip(plan.expected_error_random);
    // Little of its range tells little of what a joint carries.
    let idle = plan.joints.iter().filter(|joint| {
        let [used, allowed] = [joint.used, joint.limits].map(|[low, high]| high - low);
        used < 0.2 * allowed
    });
    let idle: Vec<String> = idle.map(|joint| joint.joint.clone()).collect();
    let context = context! {
        plan => Serde(plan),
        less => errors.map(|(planned, random)| (100.0 * (1.0 - planned / random)).round()),
        idle,
        file,
        command,
        figures => context! {
            region => figure(figures::region(plan)),
            efficiency => figure(figures::efficiency(&plan.curve)),
            joints => figure(figures::joints(&plan.joints)),
        },
    };
    render("plan.html", context)
}
