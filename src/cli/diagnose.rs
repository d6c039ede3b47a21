//! `sesc diagnose`

use std::path::{Path, PathBuf};

use clap::Args;
use sesc_model::{DataUsed, Model};

use super::{Outcome, RobotArguments, message, notes, print, print_json, progress, words};
use crate::Error;
use crate::report::diagnose::{self as report, Asked};
use sesc_identify::diagnose::corrected_urdf::{self, CorrectedUrdf};
use sesc_identify::diagnose::experiment;
use sesc_identify::diagnose::further::Further;
use sesc_identify::diagnose::model_file::model_file;
use sesc_identify::diagnose::problem::Problem;
use sesc_identify::diagnose::view::DiagnosisView;
use sesc_identify::diagnose::{self, About, next_postures};
use sesc_identify::fit::prior::Prior;
use sesc_identify::logs::{Angles, Options, Readings, Sidecar};
use sesc_identify::observations::postures::{Postures, Taking};
use sesc_identify::output;
use sesc_identify::robot::Robot;
use sesc_model::effects::Experiment;

/// Find where simulation and measurement disagree, and name the missing effect
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    sesc diagnose robots/op2/op2.urdf --data log.csv\n  \
    sesc diagnose op2.urdf --data log.csv --out model.toml --urdf corrected.urdf --report report.html\n  \
    sesc diagnose op2.urdf --data log.csv --next next.csv\n  \
    sesc diagnose op2.urdf --data log.csv --then next_log.csv\n  \
    sesc diagnose op2.urdf --data log.csv --prior tight --json")]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Posture log (CSV, gzip, Parquet, MCAP) with CoP or foot cells
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Log of an experiment that --next asked for: explanations of the first log are
    /// judged by it, too
    #[arg(long, value_name = "FILE")]
    then: Vec<PathBuf>,
    /// Turning joints are logged in degrees
    #[arg(long)]
    degrees: bool,
    /// What CAD is worth: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file:
    /// [default] mass = 0.1, com = 0.005 (m); [links.NAME] likewise
    #[arg(long, value_name = "tight|cad|free|FILE", default_value = Prior::DEFAULT)]
    prior: String,
    /// Standard deviation of a single reading on one axis, m; from the log unless given
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    noise: Option<f64>,
    /// Added to the noise in quadrature, m: what encoder ticks do
    #[arg(
        long,
        value_name = "M",
        default_value = "0.0001",
        allow_negative_numbers = true
    )]
    floor: f64,
    /// Model file to write: parameters and effects, for `generate`, `predict`, `simulate`
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// URDF to write: joint origins turned by what encoders are off, payloads as links of
    /// their own, masses as re-identified. What no URDF can hold is named and left out
    #[arg(long = "urdf", value_name = "FILE")]
    corrected: Option<PathBuf>,
    /// Posture file to write: the experiment that would tell most (.csv, .csv.gz or .parquet)
    #[arg(long, value_name = "FILE")]
    next: Option<PathBuf>,
    /// Page to write: where the gap is, what closes it, what these data cannot tell apart
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    for (name, value) in [
        ("--noise", arguments.noise),
        ("--floor", Some(arguments.floor)),
    ] {
        let least = if name == "--floor" { 0.0 } else { 1e-9 };
        if let Some(x) = value.filter(|x| !(least..=1.0).contains(x)) {
            return Err(Error::Usage(format!(
                "{name} {x:e}: give metres, {least:e} to 1"
            )));
        }
    }
    let written: Vec<&PathBuf> = [
        &arguments.out,
        &arguments.corrected,
        &arguments.next,
        &arguments.report,
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut read = vec![arguments.robot.urdf.clone(), arguments.data.clone()];
    read.extend(arguments.then.iter().cloned());
    output::check(&read, &written)?;
    let robot = Robot::read(&arguments.robot.urdf)?;
    let (sidecar, _) = Sidecar::of(&arguments.data)?;
    let support = arguments
        .robot
        .support(&robot, sidecar.support.as_deref(), None)?;
    let model = robot.model(&support, arguments.robot.snapping(), None)?;
    notes(&model);
    let data = take(arguments, &robot, &model, &arguments.data)?;
    let prior = Prior::named(&arguments.prior, &model)?;
    let mut problem = Problem::new(&model, data, &prior)?;
    let stands: Vec<(Experiment, Model)> = arguments
        .then
        .iter()
        .map(|log| stand(arguments, &robot, &support, log))
        .collect::<Result<_, _>>()?;
    let logs = arguments.then.iter().zip(&stands);
    let further: Vec<Further> = logs
        .map(|(log, (experiment, model))| {
            Ok(Further {
                experiment: *experiment,
                problem: Problem::new(model, take(arguments, &robot, model, log)?, &prior)?,
            })
        })
        .collect::<Result<_, Error>>()?;
    let bar = progress("hypotheses");
    let about = About {
        robot: sidecar.robot.as_deref().unwrap_or(&model.tree.robot),
        support: &support,
        log: &name_of(&arguments.data),
        prior: prior.sentence(),
    };
    let mut found = diagnose::diagnose_all(&mut problem, &further, &about, &mut |count| {
        bar.set_position(count as u64);
    });
    bar.finish_and_clear();
    let folder = arguments.robot.urdf.parent();
    let next = next_postures::next(&problem, &found, &robot, arguments.robot.snapping(), folder);
    found.diagnosis.next_postures.why = next_postures::why(&next, found.class.len());
    found.diagnosis.next_postures.experiments = next.proposals.clone();
    if let Some(path) = &arguments.next {
        if next_postures::write(&next, &model, about.robot, path)? {
            found.diagnosis.next_postures.file = Some(path.display().to_string());
            message(&format!("wrote {}", path.display()));
        } else {
            message(&format!(
                "{} is not written: nothing is left to tell apart",
                path.display()
            ));
        }
    }
    if let Some(path) = &arguments.out {
        let mut file = model_file(&problem, &found);
        let logs = arguments.then.iter().zip(&further);
        file.data.extend(logs.filter_map(|(log, further)| {
            let summary = further.problem.data.summary.as_ref()?;
            Some(DataUsed {
                file: name_of(log),
                hash: summary.hash.clone(),
                rows: summary.rows,
            })
        }));
        let text = toml::to_string(&file).map_err(|error| Error::Report(Box::new(error)))?;
        output::write(path, &text)?;
        message(&format!("wrote {}", path.display()));
    }
    for log in &arguments.then {
        found.diagnosis.log += &format!(" + {}", name_of(log));
    }
    if let Some(path) = &arguments.corrected {
        let snapping = arguments.robot.snapping();
        let CorrectedUrdf { text, left_out } =
            corrected_urdf::of(&problem, &found, &robot, snapping, &prior)?;
        for sentence in &left_out {
            message(sentence);
        }
        output::write(path, &text)?;
        message(&format!("wrote {}", path.display()));
    }
    if let Some(path) = &arguments.report {
        let view = DiagnosisView::of(&problem, &found);
        let text = report::page(&found.diagnosis, &view)
            .map_err(|error| Error::Report(Box::new(error)))?;
        output::write(path, &text)?;
        message(&format!("wrote {}", path.display()));
    }
    let asked = Asked {
        model: arguments.out.is_some(),
        next: arguments.next.is_some(),
        page: arguments.report.is_some(),
    };
    match arguments.json {
        true => print_json(&found.diagnosis)?,
        false => print(&report::text(&found.diagnosis, asked))?,
    }
    Ok(Outcome::Ok)
}

/// A log on the model's support, its oddities on stderr.
fn take(
    arguments: &Arguments,
    robot: &Robot,
    model: &Model,
    log: &Path,
) -> Result<Postures, Error> {
    let taking = Taking {
        options: options(arguments, robot, &model.tree.links[model.tree.support].name),
        noise: arguments.noise,
        floor: arguments.floor,
    };
    let data = Postures::read(log, model, &taking)?;
    data.warnings.iter().for_each(words::warn);
    Ok(data)
}

/// What a further log is of, and the robot as it stands there.
fn stand(
    arguments: &Arguments,
    robot: &Robot,
    first: &str,
    log: &Path,
) -> Result<(Experiment, Model), Error> {
    let (sidecar, _) = Sidecar::of(log)?;
    let support = sidecar.support.as_deref().unwrap_or(first);
    let experiment = match &sidecar.experiment {
        Some(name) => experiment::of_log(name).ok_or_else(|| {
            sesc_identify::Error::log(
                Sidecar::path(log).display().to_string(),
                None,
                format!(
                    "experiment `{name}` cannot be taken together with another log; known are \
                 postures, turned, other_foot, raw_cells, untouched. Diagnose it alone with --data"
                ),
            )
        })?,
        None if support != first => Experiment::OtherFoot,
        None => Experiment::Postures,
    };
    if (experiment == Experiment::OtherFoot) == (support == first) {
        return Err(sesc_identify::Error::log(
            Sidecar::path(log).display().to_string(),
            None,
            format!(
                "experiment `{}` on `{support}`, and the first log is on `{first}`; mend \
                 `experiment` or `support`",
                experiment.name()
            ),
        )
        .into());
    }
    let model = robot.model(support, arguments.robot.snapping(), None)?;
    Ok((experiment, model))
}

fn options(arguments: &Arguments, robot: &Robot, support: &str) -> Options {
    let links = robot.description.robot.links.iter();
    Options {
        angles: arguments.degrees.then_some(Angles::Deg),
        readings: Readings::Required,
        links: links.map(|link| link.name.clone()).collect(),
        support: Some(support.to_string()),
        any_unit: true,
        ..Options::default()
    }
}

fn name_of(path: &Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
