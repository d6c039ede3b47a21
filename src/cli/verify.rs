//! `sesc verify`

use std::path::PathBuf;

use clap::Args;

use super::outputs::Files;
use super::steps::{About, named};
use super::{Bar, Outcome, RobotArguments, print_with_steps};
use crate::report::next_steps;
use crate::report::table::Table;
use crate::verify::{Verification, holds, samples, verify};
use sesc_model::Model;

/// Compare the generated functions with the independent reference
///
/// With a model file, every function is compared with a virtual robot that has the file's
/// effects: those of the body in all functions, those of ground and sensor in the CoP.
/// Allowed is twice the proven rounding bound, what snapped right angles move, and what
/// rounds of the model's springs leave out (stated below the table). Where a joint has
/// a dead band, postures in which gravity does not decide its side are left out and counted.
/// A function whose allowed error is more than a thousandth of the robot's reach fails:
/// keeping so wide a bound says nothing.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    sesc verify robots/op2/op2.urdf --support r_sole --samples 10000\n  \
    sesc verify robots/op2/op2.urdf --model model.toml --samples 500")]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Model file whose effects the functions have
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Random postures to compare, besides the corners of the joint limits [default: 10000;
    /// beyond 100 joints a million joint angles in all]
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    samples: Option<u64>,
    /// Seed of the postures
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machine-readable output
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    Files::default().reads(&arguments.model).check()?;
    let (robot, model) = arguments.robot.load(arguments.model.as_deref())?;
    let samples = match arguments.samples {
        Some(given) => usize::try_from(given).unwrap_or(usize::MAX),
        None => samples(model.dof()),
    };
    let bar = &mut Bar::new("comparing");
    let found = verify(&robot, &model, samples, arguments.seed, bar)?;
    let file = named(&arguments.model);
    let step = next_steps::of_verification(model.support(), file, found.pass);
    let steps = About::new(&arguments.robot.urdf).worded([&step]);
    print_with_steps(arguments.json, &found, &steps, || text(&found, &model))?;
    Ok(found.pass)
}

/// The worst errors beside what is allowed, and what is said of them.
fn text(found: &Verification, model: &Model) -> String {
    let mut table = Table::new(&["function", "worst error", "allowed", "unit", ""]);
    for (name, error) in &found.worst_error {
        let bound = found.bound[name];
        let verdict = if holds(*error, bound) { "ok" } else { "FAIL" };
        let [worst, allowed] = [*error, bound].map(|x| format!("{x:.2e}"));
        table.row(&[name, &worst, &allowed, found.units[name], verdict]);
    }
    let mut text = format!("{table}\n");
    if !model.tree.snaps.is_empty() {
        text += "allowed: what rounding makes, and what the snapped right angles move; with \
                 --no-snap rounding alone\n";
    }
    if found.springs_left_out > 0.0 {
        text += &format!(
            "springs: {} rounds leave out up to {:.1e} m\n",
            model.rounds, found.springs_left_out
        );
    }
    if !found.beyond_use.is_empty() {
        text += &format!(
            "{}: what is proven of rounding and snapped angles is more than {:.1e} m, a \
             thousandth of the robot's reach, so that keeping it verifies nothing; allowed is a \
             billionth of the reach instead. Long chains have such bounds, mimic joints with \
             large factors, and angles that are nearly right (--no-snap)\n",
            found.beyond_use.join(", "),
            found.widest_of_use
        );
    }
    if found.undecided > 0 {
        text += &format!(
            "{} postures left out: a joint rests on either side of its dead band, or the \
             CoP is off the cells\n",
            found.undecided
        );
    }
    let verdict = if found.pass { "pass" } else { "FAIL" };
    format!("{text}{verdict} on {} postures\n", found.samples)
}
