//! `sesc compare`

use std::path::PathBuf;

use clap::Args;
use sesc_identify::compare;
use sesc_model::ModelFile;

use super::outputs::Files;
use super::{Outcome, print_json, show};
use crate::Error;
use crate::report::compare::text;

/// Say what changed between two model files, and whether it is more than chance
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sesc compare monday.toml friday.toml\n  sesc compare monday.toml friday.toml --json"
)]
pub(super) struct Arguments {
    /// Model file of the robot as it was
    #[arg(value_name = "MODEL")]
    before: PathBuf,
    /// Model file of the same robot on the same support as it is
    #[arg(value_name = "MODEL")]
    after: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    Files::default()
        .reads([&arguments.before, &arguments.after])
        .check()?;
    let before = ModelFile::read(&arguments.before)?;
    let after = ModelFile::read(&arguments.after)?;
    let comparison = compare::compare(&before, &after)?;
    match arguments.json {
        true => print_json(&comparison)?,
        false => show(&text(&comparison, &before.file, &after.file))?,
    }
    Ok(Outcome::Ok)
}
