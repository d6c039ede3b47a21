//! `sesc plan`

use std::path::{Path, PathBuf};

use clap::Args;
use sesc_model::Model;

use super::{Outcome, RobotArguments, command_line, message, print, print_json, progress};
use crate::Error;
use crate::report;
use sesc_identify::fit::prior::Prior;
use sesc_identify::logs::{PostureWriter, Row, Sidecar, Written};
use sesc_identify::output;
use sesc_identify::plan::balance::Region;
use sesc_identify::plan::limits::Limits;
use sesc_identify::plan::{self, Plan, Request};

/// |CoP| unless a sole is given: the seed paper's, m.
const COP_BOX: f64 = 0.023;

/// Choose postures that tell most about the parameters, balanced and clear, in a short order
#[derive(Args)]
#[command(after_help = "Example:\n  \
    sesc plan robots/op2/op2.urdf --support r_sole --poses 38 --limits robots/op2/limits_paper.csv \
    --out poses.csv --report plan.html\n\n\
    Only the postures are checked, not the way from one to the next.")]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Number of postures
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=2000))]
    poses: u64,
    /// Keep |x| and |y| of the CoP within this, m [default: 0.023 unless --sole]
    #[arg(long, value_name = "M", conflicts_with = "sole")]
    cop_box: Option<f64>,
    /// Keep the CoP within the hull of these points of the sole, m
    #[arg(long, value_name = "FILE|x,y;…", allow_hyphen_values = true)]
    sole: Option<String>,
    /// Keep the CoP so far from the edge of box or sole, m
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    margin: f64,
    /// Keep it so many of its standard deviations from there
    #[arg(long, value_name = "K", default_value_t = 2.0)]
    sigmas: f64,
    /// Narrower joint limits: CSV `joint,lower_deg,upper_deg` (or _rad, _m)
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
    /// Candidates to choose from [default: 20 per posture, 2000 to 20000]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    candidates: Option<u64>,
    /// What CAD is worth to the later fit: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file
    #[arg(long, value_name = "tight|cad|free|FILE", default_value = Prior::DEFAULT)]
    prior: String,
    /// Standard deviation of a single reading on one axis, m; one is taken in each posture
    #[arg(long, value_name = "M", default_value_t = 0.0005)]
    noise: f64,
    /// Least height of everything but the support body, m
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.005,
        allow_hyphen_values = true
    )]
    clearance: f64,
    /// Seed of the candidates
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Parameters to balance with, and their support unless --support is given; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture file to write (.csv, .csv.gz or .parquet); its sidecar gets the same name with .toml
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Page to write: where the CoP is, what the postures are worth, what joints do
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    check(arguments)?;
    check_files(arguments)?;
    let (robot, model) = arguments.robot.load(arguments.model.as_deref())?;
    let dofs = &model.tree.dofs;
    let request = Request {
        poses: usize::try_from(arguments.poses).unwrap_or(usize::MAX),
        candidates: arguments
            .candidates
            .map(|k| usize::try_from(k).unwrap_or(usize::MAX)),
        region: match &arguments.sole {
            Some(sole) => Region::sole(sole, arguments.margin)?,
            None => Region::square(arguments.cop_box.unwrap_or(COP_BOX), arguments.margin)?,
        },
        sigmas: arguments.sigmas,
        limits: match &arguments.limits {
            Some(path) => Limits::read(path, dofs)?,
            None => Limits::of_urdf(dofs),
        },
        prior: Prior::named(&arguments.prior, &model)?,
        noise: arguments.noise,
        clearance: arguments.clearance,
        seed: arguments.seed,
        folder: arguments.robot.urdf.parent(),
    };
    // A file that cannot be written is better known before than after.
    let log = PostureWriter::create(&arguments.out, dofs, Written::default())?;
    let bar = progress("planning");
    let found = plan::plan(&robot, &model, &request, &|what, done, of| {
        bar.set_message(what);
        bar.set_length(of);
        bar.set_position(done);
    });
    bar.finish_and_clear();
    let found = found?;
    write(log, &arguments.out, &model, &found)?;
    if let Some(path) = &arguments.report {
        let file = arguments.out.display().to_string();
        let page = report::plan::page(&found, &file, &command_line());
        let page = page.map_err(|error| Error::Report(Box::new(error)))?;
        output::write(path, &page)?;
        message(&format!("wrote {}", path.display()));
    }
    if arguments.json {
        print_json(&found)?;
    } else {
        print(&report::plan::text(&found))?;
    }
    Ok(Outcome::Ok)
}

fn check(arguments: &Arguments) -> Result<(), Error> {
    let positive = |name: &str, value: f64| match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{name} {value}: give a number above zero"
        ))),
    };
    let not_negative = |name: &str, value: f64| match value.is_finite() && value >= 0.0 {
        true => Ok(()),
        false => Err(Error::Usage(format!(
            "{name} {value}: give a number, zero or more"
        ))),
    };
    positive("--cop-box", arguments.cop_box.unwrap_or(COP_BOX))?;
    positive("--noise", arguments.noise)?;
    not_negative("--margin", arguments.margin)?;
    not_negative("--sigmas", arguments.sigmas)?;
    not_negative("--clearance", arguments.clearance)?;
    if arguments.candidates.is_some_and(|k| k < arguments.poses) {
        return Err(Error::Usage(format!(
            "--candidates {} for --poses {}: give at least as many, twenty times as many choose well",
            arguments.candidates.unwrap_or(0),
            arguments.poses
        )));
    }
    Ok(())
}

/// Nothing that is read is written, and nothing is written twice.
fn check_files(arguments: &Arguments) -> Result<(), Error> {
    let optional = [&arguments.limits, &arguments.model];
    let mut read: Vec<PathBuf> = optional.into_iter().flatten().cloned().collect();
    read.push(arguments.robot.urdf.clone());
    read.extend(arguments.sole.iter().map(PathBuf::from));
    read.push(PathBuf::from(&arguments.prior));
    let sidecar = Sidecar::path(&arguments.out);
    let mut written = vec![&arguments.out];
    // A posture file that ends like one is refused when it is begun.
    written.extend(Some(&sidecar).filter(|path| **path != arguments.out));
    written.extend(&arguments.report);
    Ok(output::check(&read, &written)?)
}

fn write(mut log: PostureWriter, out: &Path, model: &Model, found: &Plan) -> Result<(), Error> {
    for (pose, q) in found.postures().enumerate() {
        log.row(&Row {
            pose: pose as i64 + 1,
            q,
            ..Row::default()
        })?;
    }
    let sidecar = log.finish(&Sidecar {
        robot: Some(model.tree.robot.clone()),
        support: Some(found.support.clone()),
        ..Sidecar::default()
    })?;
    message(&format!(
        "wrote {} and {}",
        out.display(),
        sidecar.display()
    ));
    Ok(())
}
