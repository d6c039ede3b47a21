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
    command_line, message, outputs, print_json, print_with_steps,
};
use crate::Error;
use crate::report::compare::{page, text};
use crate::report::fit::Unusable;
use crate::report::next_steps;

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
/// Endings of logs.
const LOGS: [&str; 4] = ["csv", "gz", "parquet", "mcap"];

pub(super) fn run(arguments: &Arguments, typed: &ArgMatches) -> Outcome {
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
    let robot = urdf.map(|urdf| arguments.standing.robot(urdf));
    let robot = robot.transpose()?.map(Arc::new);
    let Some(before) = model(arguments, robot.as_ref(), &arguments.before)? else {
        return Ok(false);
    };
    let Some(after) = model(arguments, robot.as_ref(), &arguments.after)? else {
        return Ok(false);
    };
    if let Some(robot) = &robot {
        // One of them at least is of this robot: the other may be of the URDF as it was before.
        let (hash, file) = (&robot.description.hash, &robot.description.file);
        let own = before.check_robot(hash, file);
        own.or_else(|error| after.check_robot(hash, file).map_err(|_| error))?;
    }
    let found = compare::compare(&before, &after)?;
    let names = both.map(|path| path.display().to_string());
    let names = names.each_ref().map(String::as_str);
    let of_logs = is_log(&arguments.after);
    let steps = next_steps::of_comparison(&found, names, None, of_logs);
    let about = About {
        urdf,
        ..About::default()
    };
    let steps = &about.worded(&steps);
    if let Some(path) = &arguments.report {
        let standing = &arguments.standing;
        let drawn = robot.map(|robot| standing.skeleton(&robot, &found.support, urdf));
        let (drawn, line) = (drawn.transpose()?, command_line());
        let page = page(&found, [&before, &after], steps, drawn.as_ref(), &line);
        outputs::write(path, &page?)?;
    }
    print_with_steps(arguments.json, &found, steps, || {
        text(&found, &before.file, &after.file)
    })?;
    Ok(true)
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
    let why = "is for logs, and two model files are compared, which hold what was identified; \
               leave it out, or give the logs with --urdf";
    refuse(typed, OF_LOGS, why)?;
    let lacks = match (&arguments.urdf, &arguments.report) {
        (Some(_), Some(_)) => return Ok(()),
        (None, _) => "is for the URDF, and none is given; leave it out, or add --urdf",
        (Some(_), None) => {
            "is for the robot on the page, and none is written; leave it out, or add --report"
        }
    };
    refuse(typed, &["no-snap", "xacro"], lacks)
}

/// The model that a file holds, or that the diagnosis of a log gives; none of a log that cannot
/// be used.
fn model(
    arguments: &Arguments,
    robot: Option<&Arc<Robot>>,
    path: &Path,
) -> Result<Option<ModelFile>, Error> {
    if !is_log(path) {
        return Ok(Some(ModelFile::read(path)?));
    }
    let log = path.display().to_string();
    let Some(robot) = robot else {
        return Err(Error::Usage(format!(
            "{log} is a log, not a model file: give its robot with --urdf, or the model file that \
             `sesc diagnose --out` writes of it"
        )));
    };
    let (feet, stays) = (&arguments.feet, &arguments.stays);
    let (how, standing, source) = (&arguments.how, &arguments.standing, LogSource::from(path));
    let request = how.request(Arc::clone(robot), source, standing, feet, stays)?;
    let mut report = diagnose(&request, &mut Bar::new("reading"))?;
    let found = &report.diagnosis;
    if found.verdict == Verdict::Unusable {
        let sentence = &found.sentence;
        message(&format!("check failed: {log} cannot be used: {sentence}"));
        if arguments.json {
            let next_steps = &About::default().worded(&found.next_steps());
            let mut unusable = Unusable::new(&found.health, next_steps);
            unusable.log = Some(&log);
            print_json(&unusable)?;
        }
        return Ok(None);
    }
    report.model_file.file = log;
    Ok(Some(report.model_file))
}
