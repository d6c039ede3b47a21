//! `sesc compare`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{ArgMatches, Args};
use sesc_identify::compare;
use sesc_identify::diagnose::{Verdict, diagnose};
use sesc_identify::logs::LogSource;
use sesc_identify::robot::Robot;
use sesc_model::ModelFile;

use super::defaults::refuse;
use super::outputs::{Files, Kind};
use super::steps::About;
use super::{
    Bar, DiagnosisArguments, FeetArguments, Outcome, StandingArguments, StaysArguments,
    command_line, message, outputs, print_found, print_json,
};
use crate::Error;
use crate::report::compare::{page, text};
use crate::report::fit::Unusable;
use crate::report::next_steps::{self, WithSteps};

/// Say what changed between two model files, or two logs, and whether it is more than chance
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    sesc compare monday.toml friday.toml\n  \
    sesc compare monday.toml friday.toml --urdf op2.urdf --report page.html\n  \
    sesc compare monday.csv friday.csv --urdf op2.urdf\n\n\
    Logs are diagnosed, both with the same options, and what `diagnose --out` would write of them \
    is compared.")]
pub(super) struct Arguments {
    /// Model file or log of the robot as it was
    #[arg(value_name = "MODEL|LOG")]
    before: PathBuf,
    /// Model file or log of the same robot on the same support as it is
    #[arg(value_name = "MODEL|LOG")]
    after: PathBuf,
    /// Robot description: logs are diagnosed with it, the page shows it, and a model file must be
    /// of it
    #[arg(long, value_name = "URDF")]
    urdf: Option<PathBuf>,
    #[command(flatten)]
    standing: StandingArguments,
    #[command(flatten)]
    how: DiagnosisArguments,
    #[command(flatten)]
    feet: FeetArguments,
    #[command(flatten)]
    stays: StaysArguments,
    /// Page to write: what changed, and whether it is more than chance
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Options of reading and diagnosing logs: model files say theirs.
const OF_LOGS: &[&str] = &[
    "support",
    "sole-height",
    "degrees",
    "prior",
    "noise",
    "floor",
    "motion",
    "both-feet",
    "other-foot",
    "settle",
];
/// Options of drawing the robot, beside.
const OF_ROBOTS: &[&str] = &["no-snap", "xacro"];

/// Endings of logs.
const LOGS: [&str; 4] = ["csv", "gz", "parquet", "mcap"];

pub(super) fn run(arguments: &Arguments, typed: &ArgMatches) -> Result<Outcome, Error> {
    let both = [&arguments.before, &arguments.after];
    refuse_ignored(arguments, typed)?;
    Files::default()
        .reads_robots(&arguments.urdf)
        .may_read(&arguments.how.reading.prior)
        .reads(both)
        .reads_logs(both)
        .writes(Kind::Page, &arguments.report)
        .prints(arguments.json)
        .check_writable()?;
    let urdf = arguments.urdf.as_deref();
    let robot = urdf
        .map(|urdf| arguments.standing.robot(urdf))
        .transpose()?;
    let robot = robot.map(Arc::new);
    let mut models = Vec::new();
    for path in both {
        match model(arguments, robot.as_ref(), path)? {
            Some(model) => models.push(model),
            None => return Ok(Outcome::Failed),
        }
    }
    if let Some(robot) = &robot {
        check_robot(robot, &models)?;
    }
    let comparison = compare::compare(&models[0], &models[1])?;
    let names = both.map(|path| path.display().to_string());
    let of_logs = is_log(&arguments.after);
    let steps = next_steps::of_comparison(
        &comparison,
        names.each_ref().map(|name| &**name),
        None,
        of_logs,
    );
    let about = About {
        urdf,
        ..About::default()
    };
    let next_steps = &about.worded(&steps)[..];
    if let Some(path) = &arguments.report {
        let standing = &arguments.standing;
        let drawn = robot.map(|robot| standing.skeleton(&robot, &comparison.support, urdf));
        let drawn = drawn.transpose()?;
        let files = [&models[0], &models[1]];
        let page = page(
            &comparison,
            files,
            next_steps,
            drawn.as_ref(),
            &command_line(),
        );
        outputs::write(path, &page?)?;
    }
    let found = &comparison;
    let found = WithSteps { found, next_steps };
    print_found(arguments.json, &found, false, || {
        let text = text(&comparison, &models[0].file, &models[1].file);
        format!("{text}\n{}", next_steps::text(next_steps))
    })?;
    Ok(Outcome::Ok)
}

/// One of the models at least is of this robot: the other may be of the URDF as it was before.
fn check_robot(robot: &Robot, models: &[ModelFile]) -> Result<(), Error> {
    let (hash, file) = (&robot.description.hash, &robot.description.file);
    let own = models.iter().map(|model| model.check_robot(hash, file));
    let mut refused = own.filter_map(Result::err);
    match (refused.next(), refused.next()) {
        (Some(error), Some(_)) => Err(error.into()),
        _ => Ok(()),
    }
}

fn is_log(path: &Path) -> bool {
    let end = path.extension().unwrap_or_default().to_string_lossy();
    LOGS.contains(&end.to_lowercase().as_str())
}

/// Options that two model files leave nothing to do are errors.
fn refuse_ignored(arguments: &Arguments, typed: &ArgMatches) -> Result<(), Error> {
    if is_log(&arguments.before) || is_log(&arguments.after) {
        return Ok(());
    }
    refuse(
        typed,
        OF_LOGS,
        "is for logs, and two model files are compared, which hold what was identified; leave it \
         out, or give the logs with --urdf",
    )?;
    let lacks = match (&arguments.urdf, &arguments.report) {
        (Some(_), Some(_)) => return Ok(()),
        (None, _) => "is for the URDF, and none is given; leave it out, or add --urdf",
        (Some(_), None) => {
            "is for the robot on the page, and none is written; leave it out, or add --report"
        }
    };
    refuse(typed, OF_ROBOTS, lacks)
}

/// The model that a file holds, or that the diagnosis of a log gives; none of a log that cannot
/// be used.
fn model(
    arguments: &Arguments,
    robot: Option<&Arc<Robot>>,
    path: &Path,
) -> Result<Option<ModelFile>, Error> {
    let is_log = is_log(path);
    let Some(robot) = robot.filter(|_| is_log) else {
        return match is_log {
            true => Err(Error::Usage(format!(
                "{} is a log, not a model file: give its robot with --urdf, or the model file that \
                 `sesc diagnose --out` writes of it",
                path.display()
            ))),
            false => Ok(Some(ModelFile::read(path)?)),
        };
    };
    let (robot, standing) = (Arc::clone(robot), &arguments.standing);
    let (feet, stays) = (&arguments.feet, &arguments.stays);
    let how = &arguments.how;
    let request = how.request(robot, LogSource::from(path), standing, feet, stays)?;
    let report = diagnose(&request, &mut Bar::new("reading"))?;
    let found = &report.diagnosis;
    if found.verdict == Verdict::Unusable {
        let log = path.display().to_string();
        message(&format!(
            "check failed: {log} cannot be used: {}",
            found.sentence
        ));
        if arguments.json {
            let next_steps = &About::default().worded(&found.next_steps());
            let unusable = Unusable::new(&found.health, next_steps);
            print_json(&Unusable {
                log: Some(&log),
                ..unusable
            })?;
        }
        return Ok(None);
    }
    let mut model = report.model_file;
    model.file = path.display().to_string();
    Ok(Some(model))
}
