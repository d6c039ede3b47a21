//! `sesc fit`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{ArgMatches, Args};

use super::defaults::refuse;
use super::outputs::{Files, Kind, Together};
use super::steps::About;
use super::values::{DUPLICATES, LOSSES, number, one_of};
use super::{
    Bar, FeetArguments, OffsetArguments, Outcome, ReadingArguments, StandingArguments,
    StaysArguments, check_mass, command_line, judged, message, not_written, notes, outputs,
    print_found, print_json,
};
use crate::Error;
use crate::report::fit::{self as report, FitReport, Shown, Unusable, page};
use crate::report::origin::Origin;
use crate::report::unusable;
use sesc_identify::NextStep;
use sesc_identify::fit::part::Part;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::{self, Duplicates, Loss, Request};
use sesc_identify::skeleton::Skeleton;

const EXAMPLES: &str = "Examples:\n  \
    sesc fit robots/op2/op2.urdf --data log.csv --out model.toml\n  \
    sesc fit op2.urdf --data monday.csv --partial monday.part\n  \
    sesc fit monday.part tuesday.part --out model.toml\n  \
    sesc fit op2.urdf --data log.csv --urdf corrected.urdf --total-mass 2.93\n  \
    sesc fit op2.urdf --data log.csv --prior free --physical --report report.html";

/// Identify the parameters of a robot from posture logs, with uncertainties, observability
/// and held-out error
#[derive(Args)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{}", super::columns_text()))]
pub(super) struct Arguments {
    /// Robot description (`-` is standard input), or factor files of `--partial` to combine
    #[arg(value_name = "URDF|PART", required = true)]
    inputs: Vec<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP; `-` is standard input); may be given several times
    #[arg(long, value_name = "FILE")]
    data: Vec<PathBuf>,
    #[command(flatten)]
    standing: StandingArguments,
    #[command(flatten)]
    reading: ReadingArguments,
    #[command(flatten)]
    shift: OffsetArguments,
    #[command(flatten)]
    stays: StaysArguments,
    #[command(flatten)]
    feet: FeetArguments,
    /// Trust postures less that no noise explains, and name them
    #[arg(long, value_parser = one_of(LOSSES))]
    robust: Option<Loss>,
    /// Folds of the cross-validation, settled when factor files are gathered [default: 10]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(2..=100))]
    folds: Option<u64>,
    /// State the expected error for joints within ±DEG; else for their limits
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        value_parser = number("range"),
        conflicts_with = "partial"
    )]
    range: Option<f64>,
    /// Only gather: write the factors of these logs, to combine them later
    #[arg(long, value_name = "FILE", conflicts_with = "noise")]
    partial: Option<PathBuf>,
    /// Name of the robot that the logs are of, such as its serial number: factor files keep it,
    /// and those of another one are refused
    #[arg(long, value_name = "NAME")]
    unit: Option<String>,
    /// Factor files whose logs are all in another one: refuse them, or leave them out
    #[arg(long, value_parser = one_of(DUPLICATES), default_value = DUPLICATES[0].0)]
    duplicates: Duplicates,
    /// Model file to write; `-` is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    out: Option<PathBuf>,
    /// Exit with 1 if the held-out error of the fitted parameters exceeds K noise floors
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = super::positive, conflicts_with = "partial")]
    fail_above: Option<f64>,
    /// URDF to write: masses and CoMs nearest to CAD that give the identified parameters;
    /// nothing else in the file changes but inertia, scaled with the mass of its link
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    urdf: Option<PathBuf>,
    /// What the robot weighs in that URDF, kg; as in CAD unless given
    #[arg(
        long,
        value_name = "KG",
        requires = "urdf",
        allow_negative_numbers = true
    )]
    total_mass: Option<f64>,
    /// Fit physical masses only: none negative, CoMs inside the collision geometry (boxes,
    /// cylinders, spheres) where the URDF gives it, else near the joints of the link
    #[arg(long, conflicts_with = "partial")]
    physical: bool,
    /// Page to write: figures, tables, what cannot be seen
    #[arg(long, value_name = "FILE", conflicts_with = "partial")]
    report: Option<PathBuf>,
    /// Every parameter, and lists of more than eight lines in full
    #[arg(long, conflicts_with = "json")]
    long: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Options that nothing would come of are errors.
fn refuse_ignored(arguments: &Arguments, typed: &ArgMatches) -> Result<(), Error> {
    if !arguments.inputs.iter().any(|path| is_part(path)) {
        let of_parts = "is about factor files (.part), and none is";
        let unread = format!("{of_parts} read; leave it out, or give those to combine");
        let unused = format!("{of_parts} written or read; leave it out, or add --partial FILE");
        match (&arguments.unit, &arguments.partial) {
            (Some(_), Some(_)) => {}
            (Some(_), None) => refuse(typed, &["unit"], &unused)?,
            (None, _) => refuse(typed, &["duplicates"], &unread)?,
        }
    }
    // The fit itself refuses others beside factor files alone.
    let of_logs: &[_] = match arguments.data.is_empty() {
        true => &["both-feet", "other-foot"],
        false => &[],
    };
    let why = "is about reading logs, and none is given: factor files were gathered as their \
               options said; leave it out, or add --data";
    refuse(typed, of_logs, why)
}

pub(super) fn run(arguments: &Arguments, typed: &ArgMatches) -> Outcome {
    refuse_ignored(arguments, typed)?;
    let files = Files::default()
        .reads_robots(&arguments.inputs)
        .may_read(&arguments.reading.prior)
        .reads_logs(&arguments.data)
        .writes(Kind::Model, &arguments.out)
        .writes(Kind::Part, &arguments.partial)
        .writes(Kind::Urdf, &arguments.urdf)
        .writes(Kind::Page, &arguments.report)
        .prints(arguments.json);
    files.check_writable()?;
    let request = request(arguments)?;
    // The description that a factor file was made from is not written either.
    let parts = request.parts.iter();
    let robots = parts.map(|(_, part)| part.urdf_file.as_str());
    files
        .keeps(robots, "the robot of a factor file")
        .check_writable()?;
    let bar = &mut Bar::new("reading");
    if let Some(path) = &arguments.partial {
        let part = fit::gather(&request, bar)?;
        bar.clear();
        if let Some(broken) = part.unusable() {
            message(&broken.sentence);
            not_written(path);
            if arguments.json {
                let next_steps = &About::default().worded([&NextStep::Repair]);
                print_json(&Unusable::new(part.health(), next_steps))?;
            }
            return Ok(false);
        }
        part.write(path)?;
        let (part, postures) = (path.display().to_string(), part.postures());
        message(&format!("wrote {part}: {postures} postures as factors"));
        if arguments.json {
            print_json(&Gathered { part, postures })?;
        }
        return Ok(true);
    }
    let urdf = request.robot.as_ref().and(arguments.inputs.first());
    let folder = urdf.and_then(|path| path.parent());
    let report = fit::fit(&request, bar)?;
    let found = &report.identification;
    let corrected = arguments.urdf.as_ref();
    let corrected = corrected.map(|_| report.corrected_urdf(arguments.total_mass));
    let corrected = corrected.transpose()?;
    bar.clear();
    notes(&report.notes);
    let about = About {
        urdf: urdf.map(PathBuf::as_path),
        log: match &arguments.data[..] {
            [log] => Some(log),
            _ => None,
        },
        support: request.support.as_deref(),
    };
    let next_steps = &about.worded(&found.next_steps())[..];
    let text = || report::text(found, next_steps, arguments.long);
    if !found.is_usable() {
        let named = arguments.out.iter().chain(&arguments.urdf);
        named.for_each(|path| not_written(path));
        if let Some(path) = &arguments.report {
            let drawn = Skeleton::of(&report.model, &report.robot.description, folder);
            let line = command_line();
            let page = unusable::page(
                &Origin::of_fit(found, &line),
                &found.support,
                (&found.samples, found.postures),
                &found.health,
                next_steps,
                &drawn,
            );
            outputs::write(path, &page?)?;
        }
        let unusable = Unusable::new(&found.health, next_steps);
        print_found(arguments.json, &unusable, false, text)?;
        return Ok(false);
    }
    let mut files = Together::default();
    if let Some(path) = &arguments.out {
        files.add(path, &report.model_file.to_toml()?)?;
    }
    let shown = arguments.report.as_ref();
    let shown = shown.map(|_| Shown::of(&report, report.residuals.clone(), command_line(), folder));
    let printed = FitReport {
        found,
        next_steps,
        corrected: corrected.as_ref(),
        shown: shown.as_ref(),
    };
    if let (Some(path), Some(corrected)) = (&arguments.urdf, &corrected) {
        files.add(path, &corrected.text)?;
    }
    if let Some(path) = &arguments.report {
        files.add(path, &page(&printed)?)?;
    }
    files.finish()?;
    let streamed = arguments.out.as_deref().is_some_and(outputs::is_standard);
    print_found(arguments.json, &printed, streamed, || {
        let corrected = corrected.iter();
        let corrected = corrected.map(|own| report::corrections(own, arguments.long));
        text() + &corrected.collect::<String>()
    })?;
    let (error, floor) = (found.held_out_rmse, found.noise_floor);
    let what = "the held-out error of the fit";
    Ok(judged(what, error, floor, arguments.fail_above))
}

/// What `--partial` prints as JSON.
#[derive(serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Gathered {
    /// The factor file.
    part: String,
    /// Postures that it holds.
    postures: u64,
}

fn is_part(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "part")
}

/// What is asked for.
fn request(arguments: &Arguments) -> Result<Request, Error> {
    let (parts, robots): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.inputs.iter().partition(|path| is_part(path));
    if let [first, second, ..] = robots[..] {
        return Err(Error::Usage(format!(
            "{} and {} both stand where the URDF goes; logs are given with --data, \
             factor files end in .part",
            first.display(),
            second.display()
        )));
    }
    let mut request = Request::default();
    for path in parts {
        let part = (path.display().to_string(), Part::read(path)?);
        request.parts.push(part);
    }
    if let Some(path) = robots.first() {
        let robot = arguments.standing.robot(path)?;
        check_mass(arguments.total_mass, &robot)?;
        request.robot = Some(Arc::new(robot));
    }
    request.logs = outputs::logs(&arguments.data)?;
    request.support = arguments.standing.support()?;
    request.snapping = arguments.standing.snapping();
    request.angles = arguments.reading.angles();
    request.prior = arguments.reading.prior_or(Prior::DEFAULT);
    request.noise = arguments.reading.noise;
    request.offset = arguments.shift.offset;
    request.robust = arguments.robust;
    request.motion = arguments.reading.motion;
    request.stays = (&arguments.stays).into();
    request.feet = (&arguments.feet).into();
    request.folds = arguments.folds.and_then(|k| usize::try_from(k).ok());
    request.range = arguments.range.map(f64::to_radians);
    request.unit = arguments.unit.clone();
    request.duplicates = arguments.duplicates;
    request.physical = arguments.physical;
    request.residuals = arguments.report.is_some();
    Ok(request)
}
