//! `sesc fit`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use sesc_codegen::{Model, Snapping};

use super::fit_outputs::Outputs;
use super::{Outcome, message, notes, print, print_json, progress};
use crate::Error;
use crate::identify::gather::Gathered;
use crate::identify::logs::{Logs, Watch};
use crate::identify::measurement::Measurement;
use crate::identify::part::{About, Part};
use crate::identify::prior::Prior;
use crate::identify::residuals::{self, Residual};
use crate::identify::robust::Loss;
use crate::identify::{Identification, Settings, identify_within};
use crate::output;
use crate::posture_log::{Angles, Options, Progress, Readings, Sidecar};
use crate::report;
use crate::report::fit::FitReport;
use crate::robot::Robot;

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
    inputs: Vec<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP); may be given several times
    #[arg(long, value_name = "FILE")]
    data: Vec<PathBuf>,
    /// Link whose parameters are meant, and on the ground wherever a log has no `support` column
    /// (it wins over the sidecar's); the first log's own unless given
    #[arg(long, value_name = "LINK")]
    support: Option<String>,
    /// Take decimals of right angles (1.5708) literally
    #[arg(long)]
    no_snap: bool,
    /// Turning joints are logged in degrees
    #[arg(long)]
    degrees: bool,
    /// What CAD is worth: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file:
    /// [default] mass = 0.1, com = 0.005 (m); [links.NAME] likewise, and mass_kg
    #[arg(long, value_name = "tight|cad|free|FILE", default_value = "cad")]
    prior: String,
    /// Standard deviation of a reading, m; from the log unless given
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Trust postures less that no noise explains, and name them
    #[arg(long, value_enum)]
    robust: Option<RobustLoss>,
    /// Folds of the cross-validation
    #[arg(long, default_value = "10", value_parser = clap::value_parser!(u64).range(2..=100))]
    folds: Option<u64>,
    /// State the expected error for joints within ±DEG; else for their limits
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
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
enum RobustLoss {
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
            part.gathered.replicates.groups
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
    output::check(&read, &written)
}

fn snapping(literal: bool) -> Snapping {
    match literal {
        true => Snapping::Off,
        false => Snapping::default(),
    }
}

/// The factors of all logs and parts.
fn gathered(arguments: &Arguments) -> Result<Part, Error> {
    let is_part = |path: &&PathBuf| path.extension().is_some_and(|e| e == "part");
    let (parts, robots): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.inputs.iter().partition(|path| is_part(path));
    if robots.len() > 1 {
        return Err(Error::Usage(format!(
            "{} and {} both stand where the URDF goes; logs are given with --data, \
             factor files end in .part",
            robots[0].display(),
            robots[1].display()
        )));
    }
    if parts.is_empty() && arguments.data.is_empty() {
        return Err(Error::Usage(
            "nothing to fit: add --data LOG, or factor files of `sesc fit --partial`".into(),
        ));
    }
    if !parts.is_empty() && arguments.robust.is_some() {
        return Err(Error::Usage(
            "--robust needs the postures themselves: give all logs with --data, \
             or use it when the parts are gathered"
                .into(),
        ));
    }
    let mut whole: Option<Part> = None;
    for path in parts {
        let part = Part::read(path)?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.merge(part, path)?,
        }
    }
    if !arguments.data.is_empty() {
        let part = from_logs(arguments, robots.first().copied(), whole.as_ref())?;
        match &mut whole {
            None => whole = Some(part),
            Some(whole) => whole.merge(part, Path::new("--data"))?,
        }
    } else if let (Some(path), Some(whole)) = (robots.first(), &whole) {
        let robot = Robot::read(path)?;
        if robot.description.hash != whole.hash {
            return Err(Error::Usage(format!(
                "{} (hash {}) is not the robot of the factor files ({}, hash {})",
                path.display(),
                robot.description.hash,
                whole.urdf_file,
                whole.hash
            )));
        }
    }
    whole.ok_or_else(|| Error::Usage("nothing to fit".into()))
}

fn from_logs(
    arguments: &Arguments,
    urdf: Option<&PathBuf>,
    parts: Option<&Part>,
) -> Result<Part, Error> {
    let robot = match (urdf, parts) {
        (Some(path), _) => Robot::read(path)?,
        (None, Some(part)) => Robot::parse(&part.urdf, &part.urdf_file)?,
        (None, None) => {
            return Err(Error::Usage("no robot: give the URDF before --data".into()));
        }
    };
    let support = arguments.support.clone();
    let support = support.or_else(|| parts.map(|part| part.support.clone()));
    let logs = logs(arguments, &robot, support);
    let loss = arguments.robust.map(|robust| match robust {
        RobustLoss::Huber => Loss::Huber,
        RobustLoss::Tukey => Loss::Tukey,
    });
    let mut bar = Bar(progress("reading"));
    let (measurement, gathered): (_, Gathered) = logs.gather(
        loss,
        &|model| Prior::named(&arguments.prior, model),
        &mut bar,
    )?;
    bar.0.finish_and_clear();
    notes(measurement.model());
    let about = About {
        hash: robot.description.hash.clone(),
        urdf_file: robot.description.file.clone(),
        urdf: robot.text().to_string(),
        support: measurement.supports()[0].to_string(),
        supports: measurement
            .supports()
            .iter()
            .map(|s| s.to_string())
            .collect(),
        snapped: !arguments.no_snap,
    };
    Ok(Part::new(about, gathered))
}

/// The logs of the command line.
fn logs<'r>(arguments: &'r Arguments, robot: &'r Robot, support: Option<String>) -> Logs<'r> {
    let links = robot.description.robot.links.iter();
    Logs {
        robot,
        files: &arguments.data,
        options: Options {
            angles: arguments.degrees.then_some(Angles::Deg),
            readings: Readings::Required,
            links: links.map(|link| link.name.clone()).collect(),
            support: arguments.support.clone(),
            ..Options::default()
        },
        support,
        snapping: snapping(arguments.no_snap),
        folds: arguments
            .folds
            .and_then(|k| usize::try_from(k).ok())
            .unwrap_or(10),
    }
}

/// A sample of readings beside their predictions; none of factor files.
fn residuals(
    arguments: &Arguments,
    robot: &Robot,
    support: &str,
    found: &Identification,
) -> Result<Vec<Residual>, Error> {
    let logs = logs(arguments, robot, Some(support.to_string()));
    let mut measurement = Measurement::new(robot, support, logs.snapping)?;
    let mut bar = Bar(progress("residuals"));
    let found = residuals::sample(&logs, &mut measurement, &found.estimate.params, &mut bar);
    bar.0.finish_and_clear();
    found
}

/// Progress on the terminal.
struct Bar(ProgressBar);

impl Watch for Bar {
    fn progress(&mut self, what: &str, progress: Progress) {
        self.0.set_message(what.to_string());
        self.0.set_length(progress.total.unwrap_or(progress.done));
        self.0.set_position(progress.done);
    }

    fn warning(&mut self, text: &str) {
        self.0.suspend(|| message(&format!("warning: {text}")));
    }
}
