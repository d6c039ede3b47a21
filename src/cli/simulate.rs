//! `sesc simulate`

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::outputs::{Files, Kind};
use super::steps::About;
use super::values::{MOTION, number, one_of};
use super::{Bar, Outcome, RobotArguments, message, outputs, print_found};
use crate::Error;
use crate::report::next_steps::{self, Worded};
use sesc_identify::NextStep;
use sesc_identify::fit::MotionModel;
use sesc_identify::simulate::hide;
use sesc_identify::simulate::{self, Request};

/// Write a log of an ideal robot, in postures at rest or in motion, with CoP noise
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sesc simulate robots/op2/op2.urdf --support r_sole --poses 1000 --range 30 --noise 0.00493 --out log.csv\n  sesc simulate op2.urdf --support r_sole --poses 200 --noise 0.0005 --hide joint_offset:r_knee=1.5deg --hide backlash:all=0.5deg --out log.csv"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Number of postures
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    poses: u64,
    /// Draw revolute joints within ±DEG of zero (and their limits); else within their limits
    #[arg(long, value_name = "DEG", value_parser = number("range"))]
    range: Option<f64>,
    /// Standard deviation of the CoP noise, m
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = number("noise"))]
    noise: f64,
    /// Let the robot move through the ranges of its joints and log so many rows per second,
    /// with a column `t`; else postures are at rest
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = number("rate"))]
    rate: Option<f64>,
    /// Log the ZMP of a robot that moves, or the CoP of standing postures
    #[arg(long, value_parser = one_of(MOTION), default_value = MOTION[0].0)]
    motion: MotionModel,
    /// Seed of postures and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Parameters of the simulated robot, and their support unless --support is given; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Hidden effect of the robot, may be repeated; `sesc effects` lists them
    #[arg(long, value_name = "EFFECT[:TARGET]=VALUE")]
    hide: Vec<String>,
    /// Log to write (.csv, .csv.gz or .parquet); its sidecar is FILE.toml. `-` is standard output,
    /// as CSV and without a sidecar
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

/// What is told of a log that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Written<'a> {
    /// Name of the robot.
    robot: &'a str,
    /// The link on the ground.
    support: &'a str,
    /// Rows of the log.
    postures: usize,
    /// Seed of postures and noise.
    seed: u64,
    /// Standard deviation of a reading, m.
    noise: f64,
    /// Rows a second; of a robot that moves.
    rate: Option<f64>,
    /// The log that was written.
    log: String,
    /// Its sidecar.
    sidecar: String,
    /// What to do next.
    next_steps: &'a [Worded],
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    if arguments.motion == MotionModel::Off && arguments.rate.is_none() {
        let sentence = "--motion off is about a robot that moves; add --rate HZ, or leave it out \
                        (postures are at rest without it)";
        return Err(Error::Usage(sentence.to_string()));
    }
    Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(&arguments.model)
        .writes_logs(Kind::Readings, [&arguments.out])
        .prints(arguments.json)
        .check_writable()?;
    let (_, model) = arguments.robot.load(arguments.model.as_deref())?;
    let model = hide(model, &arguments.hide)?;
    let poses = usize::try_from(arguments.poses).unwrap_or(usize::MAX);
    let mut request = Request::new(model, poses);
    request.range = arguments.range.map(f64::to_radians);
    request.noise = arguments.noise;
    request.seed = arguments.seed;
    request.rate = arguments.rate;
    request.motion = arguments.motion;
    let bar = &mut Bar::new("simulating");
    let tree = &request.model.tree;
    let support = request.model.support();
    if outputs::is_standard(&arguments.out) {
        simulate::stream(&request, outputs::OUTPUT, outputs::output(), bar)?;
        bar.clear();
        message(&format!(
            "note: the robot stands on `{support}`; give --support to what reads this"
        ));
        return Ok(true);
    }
    let sidecar = simulate::write(&request, &arguments.out, bar)?;
    bar.clear();
    let (log, sidecar) = (arguments.out.display(), sidecar.display());
    message(&format!("wrote {log} and {sidecar}"));
    let about = About {
        log: Some(&arguments.out),
        ..About::new(&arguments.robot.urdf)
    };
    // The sidecar names the support link.
    let steps = about.worded([&NextStep::Fit { support: None }]);
    let written = Written {
        robot: &tree.robot,
        support,
        postures: request.poses,
        seed: request.seed,
        noise: request.noise,
        rate: request.rate,
        log: log.to_string(),
        sidecar: sidecar.to_string(),
        next_steps: &steps,
    };
    print_found(arguments.json, &written, true, || next_steps::text(&steps))?;
    Ok(true)
}
