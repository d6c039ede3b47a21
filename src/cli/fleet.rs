//! `sesc fleet`

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;

use super::outputs::Files;
use super::{Bar, FeetArguments, Motion, Outcome, RobotArguments, message, print, print_json};
use crate::Error;
use crate::report::fleet::{answer, page, text};
use sesc_identify::feet::Feet;
use sesc_identify::fleet::summary::summary;
use sesc_identify::fleet::{self, Options, Store};
use sesc_identify::logs::{self, Angles};
use sesc_identify::robot::Robot;
use sesc_model::files;

const EXAMPLES: &str = "Examples:\n  \
    sesc fleet op2.urdf --data 'logs/robot=*/day=*/*.parquet' --by robot,day --out fleet.parquet\n  \
    sesc fleet op2.urdf --data logs/ --store parts/ --out fleet.csv --report fleet.html --json\n  \
    sesc fleet op2.urdf --data manifest.csv --out fleet.parquet\n\n\
    Robot and day of a log come from the columns of a manifest, from folders such as \
    `robot=17/day=2031-05-01/`, or from the file's name, `<robot>_<day>.csv`. A manifest is a CSV \
    file with a column `path` and any of `robot`, `day`, `urdf`, `support`; a list is a .txt file \
    with a path a line. A file `robot.urdf` beside the logs of a robot, or in one of those folders, \
    takes the place of URDF for them.";

/// Diagnose a log per robot and day, and say what robots share and what changed
#[derive(Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{}", logs::columns_text()))]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Logs: patterns in quotes, folders, files, a list or a manifest
    #[arg(long, value_name = "LOGS", required = true, num_args = 1..)]
    data: Vec<String>,
    /// What makes a group: the last key is the day, those before it the robot
    #[arg(
        long,
        value_name = "KEYS",
        value_delimiter = ',',
        default_value = "robot,day"
    )]
    by: Vec<String>,
    /// Folder that keeps rows under the hash of what they were made from; what is there is not
    /// made again
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// Revolute joints are logged in degrees
    #[arg(long)]
    degrees: bool,
    /// Tolerances of CAD: tight, cad, free, or a TOML file, as for `diagnose`; unless given,
    /// tight for diagnoses and cad for parameters
    #[arg(long, value_name = "tight|cad|free|FILE")]
    prior: Option<String>,
    /// Standard deviation of a single reading on one axis, m; from the logs unless given
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = super::units::deviation_m)]
    noise: Option<f64>,
    /// Added to the noise in quadrature, m: what encoder ticks do
    #[arg(
        long,
        value_name = "M",
        default_value = "0.0001",
        allow_negative_numbers = true, value_parser = super::units::deviation_m
    )]
    floor: f64,
    /// Compare readings with the ZMP where a log with `t` knows accelerations, or take all as
    /// those of standing postures
    #[arg(long, value_enum, default_value_t)]
    motion: Motion,
    #[command(flatten)]
    feet: FeetArguments,
    /// Threads; as many as there are cores unless given
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Table to write, a row for each robot and day (.parquet or .csv)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Page to write: what robots share, what changed, what to look at first, every row
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    fleet::check_table(&arguments.out)?;
    let inputs = fleet::inputs(&arguments.data, &arguments.by)?;
    let logs: Vec<PathBuf> = inputs.iter().map(|input| input.path.clone()).collect();
    let urdfs = inputs.iter().filter_map(|input| input.urdf.as_ref());
    Files::default()
        .reads([&arguments.robot.urdf])
        .reads(urdfs)
        .may_read(&arguments.prior)
        .reads_logs(&logs)
        .writes([&arguments.out])
        .writes(&arguments.report)
        .check_writable()?;
    let bar = &mut Bar::new("diagnosing");
    let found = fleet::run(&request(arguments, &inputs)?, bar)?;
    bar.0.finish_and_clear();
    fleet::write(&arguments.out, &found.rows)?;
    message(&format!("wrote {}", arguments.out.display()));
    let summary = summary(&found.rows, &found.names);
    if let Some(path) = &arguments.report {
        let text = page(&found, &summary, &super::command_line());
        files::write(path, &text.map_err(|error| Error::Report(Box::new(error)))?)?;
        message(&format!("wrote {}", path.display()));
    }
    match arguments.json {
        true => print_json(&answer(&found, &summary))?,
        false => print(&text(&found, &summary))?,
    }
    let none = found.rows.iter().all(|row| row.verdict.is_empty());
    Ok(if none { Outcome::Failed } else { Outcome::Ok })
}

fn request(arguments: &Arguments, inputs: &[fleet::Input]) -> Result<fleet::Request, Error> {
    let feet = Feet::from(&arguments.feet);
    let mut options = Options::default();
    options.support = arguments.robot.support.clone();
    options.snap = !arguments.robot.no_snap;
    options.angles = arguments.degrees.then_some(Angles::Deg);
    options.prior = arguments.prior.clone();
    options.noise = arguments.noise;
    options.floor = arguments.floor;
    options.motion = matches!(arguments.motion, Motion::Auto);
    options.both_feet = feet.both;
    options.other_foot = feet.other;
    let robot = Arc::new(Robot::read(&arguments.robot.urdf)?);
    let mut request = fleet::Request::new(robot, fleet::groups(inputs));
    request.options = options;
    request.store = arguments.store.as_ref().map(Store::new);
    request.threads = arguments.threads;
    Ok(request)
}
