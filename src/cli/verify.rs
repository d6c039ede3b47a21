//! `sesc verify`

use clap::Args;

use super::{Bar, Outcome, RobotArguments, print, print_json};
use crate::Error;
use crate::report::table::Table;
use crate::verify::verify;

/// Compare the generated functions with the independent reference
#[derive(Args)]
#[command(
    after_help = "Example:\n  sesc verify robots/op2/op2.urdf --support r_sole --samples 10000"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Random postures to compare, besides the corners of the joint limits
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    samples: u64,
    /// Seed of the postures
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Machine-readable output
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let (robot, model) = arguments.robot.load(None)?;
    let samples = usize::try_from(arguments.samples).unwrap_or(usize::MAX);
    let bar = &mut Bar::new("comparing");
    let found = verify(&robot, &model, samples, arguments.seed, bar)?;
    if arguments.json {
        print_json(&found)?;
    } else {
        let mut table = Table::new(&["function", "worst error, m", "allowed, m", ""]);
        for (name, error) in &found.worst_error {
            let bound = found.bound[name];
            let verdict = if *error <= bound { "ok" } else { "FAIL" };
            table.row(&[
                name.to_string(),
                format!("{error:.2e}"),
                format!("{bound:.2e}"),
                verdict.to_string(),
            ]);
        }
        print(&format!(
            "{table}\n{} on {} postures\n",
            if found.pass { "pass" } else { "FAIL" },
            found.samples
        ))?;
    }
    Ok(if found.pass {
        Outcome::Ok
    } else {
        Outcome::Failed
    })
}
