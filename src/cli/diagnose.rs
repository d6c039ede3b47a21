//! `sesc diagnose`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use super::outputs::{Files, Kind, Together};
use super::steps::About;
use super::{
    Bar, DiagnosisArguments, FeetArguments, OffsetArguments, Outcome, RobotArguments,
    StaysArguments, check_mass, command_line, judged, message, not_written, notes, outputs,
    print_found, steps,
};
use crate::Error;
use crate::report::diagnose::{DiagnoseReport, ModelUse, page, text};
use crate::report::origin::Origin;
use crate::report::unusable;
use crate::servos;
use sesc_identify::NextStep;
use sesc_identify::diagnose::{self, Report, Request, Verdict};

const EXAMPLES: &str = "Examples:\n  \
    sesc diagnose robots/op2/op2.urdf --data log.csv\n  \
    sesc diagnose op2.urdf --data log.csv --out model.toml --urdf corrected.urdf --report report.html\n  \
    sesc diagnose op2.urdf --data log.csv --next next.csv\n  \
    sesc diagnose op2.urdf --data log.csv --then next_log.csv\n  \
    sesc diagnose op2.urdf --data log.csv --healthy before.csv\n  \
    sesc diagnose op2.urdf --data log.csv --prior cad --json";

/// Find where simulation and measurement disagree, and name the missing effect
#[derive(Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{}", super::columns_text()))]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Posture log (CSV, gzip, Parquet, MCAP; `-` is standard input) with CoP or foot cells
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Log of an experiment that --next asked for: every hypothesis is fitted
    /// to both logs
    #[arg(long, value_name = "FILE")]
    then: Vec<PathBuf>,
    /// Log of the same robot when it was healthy, may be repeated: the masses that it tells take
    /// the place of CAD's. Its own prior is cad, or the file that --prior names, never tight
    #[arg(long, value_name = "FILE")]
    healthy: Vec<PathBuf>,
    #[command(flatten)]
    how: DiagnosisArguments,
    /// TOML file of effects of your own, each a site and a formula, to be tried beside the others
    #[arg(long, value_name = "FILE")]
    effects: Option<PathBuf>,
    #[command(flatten)]
    shift: OffsetArguments,
    #[command(flatten)]
    feet: FeetArguments,
    #[command(flatten)]
    stays: StaysArguments,
    /// Model file to write: parameters and effects, for `generate`, `predict`, `simulate`; `-` is
    /// standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// URDF to write: joint origins turned by what encoders are off, payloads as links of
    /// their own, masses as re-identified. What no URDF can hold is named and left out
    #[arg(long = "urdf", value_name = "FILE")]
    corrected: Option<PathBuf>,
    /// What the robot without its loads weighs in that URDF, kg; as in CAD unless given
    #[arg(
        long,
        value_name = "KG",
        requires = "corrected",
        allow_negative_numbers = true
    )]
    total_mass: Option<f64>,
    /// TOML file of the servos, as for `generate`: zeros before and after are in its ticks.
    /// Zero 2048, 4096 ticks a turn, sign 1 unless given
    #[arg(long, value_name = "FILE")]
    servos: Option<PathBuf>,
    /// Posture file to write: the experiment that would tell most (.csv, .csv.gz or .parquet)
    #[arg(long, value_name = "FILE")]
    next: Option<PathBuf>,
    /// Page to write: where the gap is, what closes it, what these data cannot tell apart
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Exit with 1 if the error of the robot as its URDF says, masses of CAD and no effect, exceeds
    /// K noise floors, whatever explains it
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = super::positive)]
    fail_above: Option<f64>,
    /// Lists of more than eight lines in full
    #[arg(long, conflicts_with = "json")]
    long: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    if arguments.next.as_deref().is_some_and(outputs::is_standard) {
        let sentence = "--next -: the postures have a sidecar; give a file (`./-` is one)";
        return Err(Error::Usage(sentence.to_string()));
    }
    Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(&arguments.servos)
        .reads(&arguments.effects)
        .may_read(&arguments.how.reading.prior)
        .reads_logs([&arguments.data])
        .reads_logs(&arguments.then)
        .reads_logs(&arguments.healthy)
        .writes(Kind::Model, &arguments.out)
        .writes(Kind::Urdf, &arguments.corrected)
        .writes_logs(Kind::Postures, &arguments.next)
        .writes(Kind::Page, &arguments.report)
        .prints(arguments.json)
        .check_writable()?;
    let bar = &mut Bar::new("reading");
    let request = request(arguments)?;
    let report = diagnose::diagnose(&request, bar)?;
    let found = &report.diagnosis;
    bar.clear();
    notes(&report.notes);
    let usable = found.verdict != Verdict::Unusable;
    let steps = found.next_steps();
    // Who asked for a file needs no such step.
    let steps = steps.iter().filter(|step| match step {
        NextStep::KeepModel => arguments.out.is_none(),
        NextStep::LookAtPage => arguments.report.is_none(),
        _ => true,
    });
    let about = About {
        urdf: Some(&arguments.robot.urdf),
        log: Some(&arguments.data),
        support: request.support.as_deref(),
    };
    let printed = DiagnoseReport {
        found,
        next_steps: &about.worded(steps),
        model_use: model_use(arguments, &report),
    };
    if usable {
        write(arguments, &report, &printed)?;
    } else {
        let named = [&arguments.out, &arguments.corrected, &arguments.next];
        named
            .into_iter()
            .flatten()
            .for_each(|path| not_written(path));
        if let Some(path) = &arguments.report {
            let RobotArguments { urdf, standing } = &arguments.robot;
            let drawn = standing.skeleton(&request.robot, &found.support, Some(urdf))?;
            let line = command_line();
            let page = unusable::page(
                &Origin::of_diagnosis(found, &report.model_file, &line),
                &found.support,
                (&found.samples, found.postures as u64),
                &found.health,
                printed.next_steps,
                &drawn,
            );
            outputs::write(path, &page?)?;
        }
    }
    let streamed = arguments.out.as_deref().is_some_and(outputs::is_standard);
    print_found(arguments.json, &printed, streamed, || {
        text(&printed, arguments.long)
    })?;
    let (error, floor) = (found.baseline.rmse, found.noise_floor);
    // A robot whose gap an effect explains still is not as simulated.
    let what = "the error of the uncorrected model";
    Ok(usable && judged(what, error, floor, arguments.fail_above))
}

/// How the model file is used, where one is written to a path.
fn model_use(arguments: &Arguments, report: &Report) -> Option<ModelUse> {
    let found = &report.diagnosis;
    let written = found.verdict != Verdict::Unusable && found.model_on_log.agrees;
    let path = arguments.out.as_ref().filter(|_| written);
    let model = path.filter(|path| !outputs::is_standard(path))?;
    let model = model.display().to_string();
    let urdf = arguments.robot.urdf.display().to_string();
    let words = ["generate", &urdf, "--support", &found.support];
    let more = ["--lang", "c", "--model", &model];
    Some(ModelUse {
        build_rs: format!(".model({model:?})"),
        generate: steps::line(words.into_iter().chain(more)),
        c: "NAME_model_com(q, com);",
        model,
    })
}

fn request(arguments: &Arguments) -> Result<Request, Error> {
    let robot = Arc::new(arguments.robot.standing.robot(&arguments.robot.urdf)?);
    check_mass(arguments.total_mass, &robot)?;
    let (log, standing) = (outputs::log(&arguments.data)?, &arguments.robot.standing);
    let how = &arguments.how;
    let mut request = how.request(robot, log, standing, &arguments.feet, &arguments.stays)?;
    request.offset = arguments.shift.offset;
    request.then = outputs::logs(&arguments.then)?;
    request.healthy = outputs::logs(&arguments.healthy)?;
    request.meshes = arguments.robot.urdf.parent().map(Path::to_path_buf);
    request.next_file = arguments.next.clone();
    if let Some(file) = &arguments.servos {
        request.servos = servos::read(file, &request.robot)?;
    }
    if let Some(file) = &arguments.effects {
        request.effects = request.effects.with_file(file)?;
    }
    request.corrected_urdf = arguments.corrected.is_some();
    request.total_mass = arguments.total_mass;
    request.view = arguments.report.is_some();
    Ok(request)
}

fn write(
    arguments: &Arguments,
    report: &Report,
    printed: &DiagnoseReport<'_>,
) -> Result<(), Error> {
    match (&arguments.next, &report.next) {
        (Some(path), Some(next)) => {
            next.write(path)?;
            message(&format!("wrote {}", path.display()));
        }
        (Some(path), None) => message(&format!(
            "{} is not written. {}",
            path.display(),
            report.diagnosis.next_postures.why
        )),
        (None, _) => {}
    }
    let mut files = Together::default();
    let on_log = &report.diagnosis.model_on_log;
    if let Some(path) = arguments.out.as_ref().filter(|_| !on_log.agrees) {
        message(&format!(
            "{} is not written: it would predict this log to {:.3} mm RMS, the diagnosis states \
             {:.3} mm; record more postures, or give tolerances of the masses with --prior",
            path.display(),
            1e3 * on_log.predicted_rmse,
            1e3 * on_log.stated_rmse
        ));
    } else if let Some(path) = &arguments.out {
        files.add(path, &report.model_file.to_toml()?)?;
    }
    if let (Some(path), Some(corrected)) = (&arguments.corrected, &report.corrected_urdf) {
        let left_out = corrected.left_out.iter();
        left_out.for_each(|sentence| message(sentence));
        files.add(path, &corrected.text)?;
    }
    if let (Some(path), Some(view)) = (&arguments.report, &report.view) {
        let text = page(printed, view, &report.model_file, &command_line());
        files.add(path, &text?)?;
    }
    files.finish()
}
