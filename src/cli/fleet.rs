//! `sesc fleet`

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{ArgMatches, Args};

use super::defaults::refuse;
use super::outputs::{Files, Kind};
use super::values::{ONLY, one_of};
use super::{
    Bar, DiagnosisArguments, FeetArguments, Outcome, RobotArguments, message, outputs, print_found,
};
use crate::Error;
use crate::report::fleet::{ROBOTS, answer, page_of_robot, pages, skeleton, text};
use sesc_identify::feet::Feet;
use sesc_identify::files;
use sesc_identify::fit::MotionModel;
use sesc_identify::fleet::summary::{Summary, summary};
use sesc_identify::fleet::{self, Fleet, Only, Options, Row, Store};
use sesc_identify::skeleton::Skeleton;

const EXAMPLES: &str = "Examples:\n  \
    sesc fleet op2.urdf --data 'logs/robot=*/day=*/*.parquet' --by robot,day --out fleet.parquet\n  \
    sesc fleet op2.urdf --data logs/ --store rows/ --out fleet.csv --report fleet.html --json\n  \
    sesc fleet op2.urdf --data manifest.csv --out fleet.parquet\n  \
    sesc fleet op2.urdf --data logs/ --by robot,week --only parameters --store rows/ --out weeks.csv\n\n\
    Robot and day of a log come from the columns of a manifest, from folders such as \
    `robot=17/day=2031-05-01/`, or from the file's name, `<robot>_<day>.csv`. A manifest is a CSV \
    file with a column `path` and any of `robot`, `day`, `urdf`, `support`; a list is a .txt file \
    with a path a line. A file `robot.urdf` beside the logs of a robot, or in one of those folders, \
    takes the place of URDF for them.";

/// Diagnose a log per robot and day, and say what robots share and what changed
#[derive(Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{}", super::columns_text()))]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Logs: patterns in quotes, folders, files, a list or a manifest
    #[arg(long, value_name = "LOGS", required = true, num_args = 1..)]
    data: Vec<String>,
    /// What makes a group: the last key is the day, those before it the robot; `robot,week` puts
    /// the days of each ISO week together
    #[arg(
        long,
        value_name = "KEYS",
        value_delimiter = ',',
        default_value = "robot,day"
    )]
    by: Vec<String>,
    /// Folder that keeps rows, each in a file under the hash of what it was made from; what is
    /// there is not made again
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    #[command(flatten)]
    how: DiagnosisArguments,
    #[command(flatten)]
    feet: FeetArguments,
    /// Make these alone: `parameters` fits without a diagnosis, in a thirtieth of the time; rows
    /// then have parameters and health, and no verdict or effects
    #[arg(long, value_parser = one_of(ONLY), value_name = "WHAT")]
    only: Option<Only>,
    /// Threads; as many as there are cores unless given
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<usize>,
    /// What is known of the next robot: mean and covariance of the parameters between robots, for
    /// `fit --prior FILE` and `diagnose --prior FILE`. Rows of `--only parameters` are then kept
    /// with their covariances, as those of diagnoses are, 19 kB each
    #[arg(long, value_name = "FILE")]
    prior_out: Option<PathBuf>,
    /// Table to write, a row for each robot and day (.parquet or .csv)
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Page to write: what robots share, what changed, what to look at first, every row
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Robots that get a page beside the report, at most: those to look at first before others
    #[arg(long, value_name = "N", default_value_t = ROBOTS, requires = "report")]
    pages: usize,
    /// Lists of more than eight lines in full
    #[arg(long, conflicts_with = "json")]
    long: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A number of threads.
fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("no thread does no work; give 1 or more, or leave --threads away".to_string()),
        Ok(count) => Ok(count),
        Err(_) => Err("it is no whole number; give 1 or more".to_string()),
    }
}

pub(super) fn run(arguments: &Arguments, typed: &ArgMatches) -> Outcome {
    if arguments.only.is_some() {
        let why = "is for diagnoses, and --only parameters makes none; leave one of them out";
        refuse(typed, &["floor"], why)?;
    }
    let outputs = [&arguments.out].into_iter().chain(&arguments.report);
    let outputs = outputs.chain(&arguments.prior_out).map(PathBuf::as_path);
    let data = arguments.data.iter().map(Path::new);
    if data.chain(outputs).any(outputs::is_standard) {
        let sentence = "`-`: a fleet reads and writes files; give their names (`./-` is one)";
        return Err(Error::Usage(sentence.to_string()));
    }
    fleet::check_table(&arguments.out)?;
    let inputs = fleet::inputs(&arguments.data, &arguments.by)?;
    let logs: Vec<PathBuf> = inputs.iter().flat_map(|input| input.logs.clone()).collect();
    let urdfs = inputs.iter().filter_map(|input| input.urdf.as_ref());
    let names: BTreeSet<&str> = inputs.iter().map(|input| input.robot.as_str()).collect();
    let of_robots = arguments.report.iter();
    let of_robots = of_robots.flat_map(|page| names.iter().map(|robot| page_of_robot(page, robot)));
    let of_robots: Vec<PathBuf> = of_robots.collect();
    Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(urdfs)
        // Lists and manifests; patterns name no file.
        .may_read(&arguments.data)
        .may_read(&arguments.how.reading.prior)
        .reads_logs(&logs)
        .writes(Kind::Fleet, [&arguments.out])
        .writes(Kind::Page, &arguments.report)
        .makes(Kind::Page, &of_robots)
        .writes(Kind::Population, &arguments.prior_out)
        .check_writable()?;
    let bar = &mut Bar::or_lines("diagnosing");
    let request = request(arguments, &inputs)?;
    if arguments.prior_out.is_some() {
        fleet::check_population(&request.groups)?;
    }
    let found = fleet::run(&request, bar)?;
    bar.clear();
    // What cannot be known is said before anything is written.
    let population = arguments.prior_out.as_ref();
    let population =
        population.map(|_| fleet::population(&found.rows, &request.robot, &request.options));
    let population = population.transpose()?;
    fleet::write(&arguments.out, &found.rows)?;
    message(&format!("wrote {}", arguments.out.display()));
    if let (Some(path), Some(known)) = (&arguments.prior_out, &population) {
        outputs::write(path, &known.to_toml()?)?;
    }
    let summary = summary(&found.rows, population);
    if let Some(path) = &arguments.report {
        let folder = arguments.robot.urdf.parent();
        let drawn = skeleton(&found, &request.robot, &request.options, folder);
        write_pages((path, arguments.pages), &found, &summary, drawn.as_ref())?;
    }
    let answer = answer(&found, &summary);
    print_found(arguments.json, &answer, false, || {
        text(&found, &summary, arguments.long)
    })?;
    Ok(found.rows.iter().any(Row::has_result))
}

/// The page of the fleet, and beside it a folder of its name with one for each robot, or for as
/// many as are wanted.
fn write_pages(
    (path, robots): (&Path, usize),
    found: &Fleet,
    summary: &Summary,
    drawn: Option<&Skeleton>,
) -> Result<(), Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let command = super::command_line();
    let pages = pages(found, summary, drawn, (&command, &name), robots)?;
    let folder = path.with_file_name(&pages.folder);
    std::fs::create_dir_all(&folder).map_err(|error| files::failed(&folder, error))?;
    for (robot, text) in &pages.robots {
        files::write(&folder.join(robot), text)?;
    }
    files::write(path, &pages.fleet)?;
    message(&format!(
        "wrote {}, and {} pages of robots in {}",
        path.display(),
        pages.robots.len(),
        folder.display()
    ));
    Ok(())
}

fn request(arguments: &Arguments, inputs: &[fleet::Group]) -> Result<fleet::Request, Error> {
    let feet = Feet::from(&arguments.feet);
    let mut options = Options::default();
    let (standing, reading) = (&arguments.robot.standing, &arguments.how.reading);
    options.support = standing.support()?;
    options.snap = !standing.no_snap;
    options.angles = reading.angles();
    options.prior = reading.prior.clone();
    options.noise = reading.noise;
    options.floor = arguments.how.floor;
    options.motion = reading.motion == MotionModel::Auto;
    options.both_feet = feet.both;
    options.other_foot = feet.other;
    options.information = arguments.prior_out.is_some();
    options.only = arguments.only;
    let robot = Arc::new(arguments.robot.standing.robot(&arguments.robot.urdf)?);
    let mut request = fleet::Request::new(robot, fleet::groups(inputs));
    request.options = options;
    request.store = arguments.store.as_ref().map(Store::new);
    request.threads = arguments.threads;
    Ok(request)
}
