//! `sesc plan`

use std::path::PathBuf;

use clap::Args;

use super::outputs::{Files, Kind};
use super::steps::About;
use super::values::number;
use super::{
    Bar, FeetArguments, Outcome, RobotArguments, command_line, message, outputs, print_found,
};
use crate::report::{self, next_steps::WithSteps};
use sesc_identify::feet::Feet;
use sesc_identify::fit::prior::Prior;
use sesc_identify::logs::{PostureWriter, Written};
use sesc_identify::plan::{Limits, Region, Request, plan};
use sesc_identify::skeleton::Skeleton;

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
    /// Keep |x| and |y| of the CoP within this, m [default: the inner part of the sole where the
    /// URDF has collision shapes of the support, else of a box with its inertia]
    #[arg(long, value_name = "M", conflicts_with = "sole", value_parser = number("cop_box"))]
    cop_box: Option<f64>,
    /// Keep the CoP within the hull of these points of the sole, m
    #[arg(long, value_name = "FILE|x,y;…", allow_hyphen_values = true)]
    sole: Option<String>,
    /// Keep the CoP at least so far from the edge of box or sole, m; of a sole by collision shapes
    /// three tenths of half its narrower side are kept in any case
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = number("margin"))]
    margin: f64,
    /// Safety margin of the CoP in standard deviations of its prediction
    #[arg(long, value_name = "K", default_value_t = 2.0)]
    sigmas: f64,
    /// Narrower joint limits: CSV `joint,lower_deg,upper_deg` (or _rad, _m)
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
    /// Candidates to choose from [default: 20 per posture, 2000 to 20000]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    candidates: Option<u64>,
    /// How far the later fit trusts CAD: tight (mass 0.2 %, CoM 0.1 mm), cad (10 %, 5 mm), free, or a TOML file
    #[arg(long, value_name = "tight|cad|free|FILE", default_value = Prior::DEFAULT)]
    prior: String,
    /// Standard deviation of a single reading on one axis, m; one is taken in each posture
    #[arg(long, value_name = "M", default_value_t = 0.0005, value_parser = number("noise"))]
    noise: f64,
    /// Least height of everything but the support body, m
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.005,
        allow_hyphen_values = true, value_parser = number("clearance")
    )]
    clearance: f64,
    #[command(flatten)]
    feet: FeetArguments,
    /// Write so many rows more at the end, which reach postures once again under their own
    /// `pose`: what visits of one posture differ by shows in them. Without it, five are named
    /// unless --data knows it, and none is written
    #[arg(long, value_name = "N")]
    revisits: Option<usize>,
    /// Log of this robot (`-` is standard input): its noise and what its visits differ by are taken for those to come
    #[arg(long, value_name = "FILE", conflicts_with = "noise")]
    data: Option<PathBuf>,
    /// Seed of the candidates
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Parameters to balance with, and their support unless --support is given; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture file to write (.csv, .csv.gz or .parquet); its sidecar is FILE.toml. `-` is standard
    /// output, as CSV and without a sidecar
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Page to write: where the CoP is, the error to expect, what joints do
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(&arguments.limits)
        .reads(&arguments.model)
        .reads_logs(&arguments.data)
        .may_read(&arguments.sole)
        .may_read([&arguments.prior])
        .writes_logs(Kind::Postures, [&arguments.out])
        .writes(Kind::Page, &arguments.report)
        .prints(arguments.json)
        .check_writable()?;
    let (robot, model) = arguments.robot.load(arguments.model.as_deref())?;
    let folder = arguments.robot.urdf.parent();
    let region = match (&arguments.sole, arguments.cop_box) {
        (Some(sole), _) => Region::sole(sole, arguments.margin)?,
        (None, Some(half)) => Region::square(half, arguments.margin)?,
        (None, None) => Region::of_support(&model, &robot.description, folder, arguments.margin)?,
    };
    let count = |k: u64| usize::try_from(k).unwrap_or(usize::MAX);
    let mut request = Request::new(robot, model, count(arguments.poses), region);
    request.candidates = arguments.candidates.map(count);
    request.sigmas = arguments.sigmas;
    if let Some(path) = &arguments.limits {
        request.limits = Limits::read(path, &request.model.tree.dofs)?;
    }
    request.prior = Prior::named(&arguments.prior, &request.model)?;
    request.noise = arguments.noise;
    request.clearance = arguments.clearance;
    request.seed = arguments.seed;
    request.revisits = arguments.revisits;
    let log = arguments.data.as_deref().map(outputs::log);
    request.log = log.transpose()?;
    request.feet = Feet::from(&arguments.feet);
    request.folder = folder.map(PathBuf::from);
    // A file that cannot be written is better known before than after.
    let dofs = &request.model.tree.dofs;
    let streamed = outputs::is_standard(&arguments.out);
    let log = (!streamed)
        .then(|| PostureWriter::create(&arguments.out, dofs, Written::default()))
        .transpose()?;
    let found = &plan(&request, &mut Bar::new("planning"))?;
    let (name, to) = (outputs::OUTPUT, outputs::output());
    let stream = || PostureWriter::stream(name, to, dofs, Written::default());
    let log = log.map_or_else(stream, Ok)?;
    let next_steps = &About::new(&arguments.robot.urdf).worded(&found.next_steps())[..];
    let out = arguments.out.display().to_string();
    if let Some(sidecar) = found.write(log)? {
        message(&format!("wrote {out} and {}", sidecar.display()));
    }
    if let Some(path) = &arguments.report {
        let (description, folder) = (&request.robot.description, request.folder.as_deref());
        let skeleton = Skeleton::of(&request.model, description, folder);
        let page = report::plan::page(found, next_steps, &skeleton, &out, &command_line());
        outputs::write(path, &page?)?;
    }
    let answer = WithSteps { found, next_steps };
    print_found(arguments.json, &answer, streamed, || {
        report::plan::text(found, next_steps)
    })?;
    Ok(true)
}
