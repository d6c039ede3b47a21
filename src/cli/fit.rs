//! `sesc fit`

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use sesc_model::Model;

use super::fit_inputs::{gathered, residuals, snapping};
use super::fit_outputs::Outputs;
use super::{Outcome, message, print, print_json};
use crate::Error;
use crate::report;
use crate::report::fit::FitReport;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{Identification, Settings, identify_within};
use sesc_identify::logs::Sidecar;
use sesc_identify::output;
use sesc_identify::robot::Robot;

/// Identify the parameters of a robot from posture logs, with all that must be said of them
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    sesc fit robots/op2/op2.urdf --data log.csv --out model.toml\n  \
    sesc fit op2.urdf --data monday.csv --partial monday.part\n  \
    sesc fit monday.part tuesday.part --out model.toml\n  \
    sesc fit op2.urdf --data log.csv --urdf corrected.urdf --total-mass 2.93\n  \
    sesc fit op2.urdf --data log.csv --prior free --physical --report report.html")]
pub(super) struct Arguments {
    /// Robot description; or factor files of `--partial` to combine
    #[arg(value_name = "URDF|PART", required = true)]
    pub(super) inputs: Vec<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP); may be given several times
    #[arg(long, value_name = "FILE")]
    pub(super) data: Vec<PathBuf>,
    /// Link whose parameters are meant, and on the ground wherever a log has no `support` column
    /// (it wins over the sidecar's); the first log's own unless given
    #[arg(long, value_name = "LINK")]
    pub(super) support: Option<String>,
    /// Take decimals of right angles (1.5708) literally
    #[arg(long)]
    pub(super) no_snap: bool,
    /// Turning joints are logged in degrees
    #[arg(long)]
    pub(super) degrees: bool,
    /// What CAD is worth: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file:
    /// [default] mass = 0.1, com = 0.005 (m); [links.NAME] likewise, and mass_kg
    #[arg(long, value_name = "tight|cad|free|FILE", default_value = Prior::DEFAULT)]
    pub(super) prior: String,
    /// Standard deviation of a single reading on one axis, m; from the log unless given
    #[arg(
        long,
        value_name = "M",
        allow_negative_numbers = true,
        conflicts_with = "partial"
    )]
    noise: Option<f64>,
    /// Trust postures less that no noise explains, and name them
    #[arg(long, value_enum)]
    pub(super) robust: Option<RobustLoss>,
    /// Folds of the cross-validation, settled when factor files are gathered [default: 10]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(2..=100))]
    pub(super) folds: Option<u64>,
    /// State the expected error for joints within ±DEG; else for their limits
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        conflicts_with = "partial"
    )]
    range: Option<f64>,
    /// Only gather: write the factors of these logs, to combine them later
    #[arg(long, value_name = "FILE")]
    partial: Option<PathBuf>,
    /// Model file to write
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(super) enum RobustLoss {
    Huber,
    Tukey,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let numbers = [
        ("--noise", arguments.noise),
        ("--range", arguments.range),
        ("--total-mass", arguments.outputs.total_mass),
    ];
    for (name, value) in numbers {
        if let Some(x) = value.filter(|x| !(1e-9..=1e6).contains(x)) {
            return Err(Error::Usage(format!(
                "{name} {x:e}: give a number above zero that a robot can have"
            )));
        }
    }
    check_files(arguments)?;
    let mut part = gathered(arguments)?;
    if let Some(support) = &arguments.support {
        part.stand_on(support)?;
    }
    if let Some(path) = &arguments.partial {
        part.write(path)?;
        message(&format!(
            "wrote {}: {} postures as factors",
            path.display(),
            part.gathered.repeats.postures
        ));
        return Ok(Outcome::Ok);
    }
    let robot = Robot::parse(&part.urdf, &part.urdf_file)?;
    let snapping = snapping(!part.snapped);
    let model = robot.model(&part.support, snapping, None)?;
    let settings = Settings {
        prior: Prior::named(&arguments.prior, &model)?,
        noise: arguments.noise,
        range: arguments.range.map(f64::to_radians),
    };
    let supports: Vec<&str> = part.supports.iter().map(String::as_str).collect();
    let limits = arguments.outputs.limits(&robot)?;
    let found = identify_within(
        &model,
        &supports,
        &part.gathered,
        &settings,
        limits.as_ref(),
    );
    let corrected = arguments
        .outputs
        .correct(&robot, &model, snapping, &found, &settings.prior)?;
    let residuals = match arguments.outputs.page() {
        true => residuals(arguments, &robot, &part.support, &found)?,
        false => Vec::new(),
    };
    write(arguments, &model, &found)?;
    let shown = arguments.outputs.shown(&found, residuals);
    let report = FitReport {
        found: &found,
        corrected: corrected.as_ref(),
        shown: shown.as_ref(),
    };
    arguments.outputs.write(&report)?;
    if arguments.json {
        print_json(&report)?;
    } else {
        print(&report::fit::text(&found))?;
        if let Some(corrected) = &corrected {
            print(&report::fit::corrections(corrected))?;
        }
    }
    Ok(Outcome::Ok)
}

fn write(arguments: &Arguments, model: &Model, found: &Identification) -> Result<(), Error> {
    if let Some(path) = &arguments.out {
        let file = found.model_file(model);
        let text = toml::to_string(&file).map_err(|error| Error::Report(Box::new(error)))?;
        output::write(path, &text)?;
        message(&format!("wrote {}", path.display()));
    }
    Ok(())
}

/// Nothing that is read is written, nothing is written twice, and every folder
/// takes a file: before a long fit, not behind it.
fn check_files(arguments: &Arguments) -> Result<(), Error> {
    if let Some(path) = &arguments.partial
        && path.extension().is_none_or(|end| end != "part")
    {
        return Err(Error::Usage(format!(
            "--partial {}: factor files end in .part",
            path.display()
        )));
    }
    let mut read: Vec<PathBuf> = arguments.inputs.clone();
    for log in &arguments.data {
        read.push(log.clone());
        read.push(Sidecar::path(log));
    }
    let own = [&arguments.out, &arguments.partial].into_iter().flatten();
    let written: Vec<&PathBuf> = own.chain(arguments.outputs.files()).collect();
    Ok(output::check(&read, &written)?)
}
