//! `sesc predict`

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::outputs::{Files, Kind};
use super::steps::{About, named};
use super::values::{MOTION, one_of};
use super::{Bar, Outcome, RobotArguments, message, outputs, print_found, print_json, steps};
use crate::Error;
use crate::report::next_steps::{self, WithSteps, Worded};
use sesc_identify::fit::MotionModel;
use sesc_identify::logs::{Angles, PREDICTED, PostureWriter, Row, Sidecar};
use sesc_identify::predict::{Predictor, Request, predict};
use sesc_identify::{Functions, NextStep};

/// CoM and CoP of every posture in a log
#[derive(Args)]
#[command(after_help = format!(
    "Examples:\n  sesc predict robots/op2/op2.urdf --support r_sole --data poses.csv > predicted.csv\n  \
    sesc predict op2.urdf --model model.toml --data log.parquet --out predicted.parquet\n\n{}",
    super::columns_text()
))]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Identified parameters, and their support where neither --support nor the log says it; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP; `-` is standard input); its columns are listed below
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Revolute joints are logged in degrees
    #[arg(long)]
    degrees: bool,
    /// Predict the ZMP where a log with `t` knows accelerations, or the CoP of standing postures
    #[arg(long, value_parser = one_of(MOTION), default_value = MOTION[0].0)]
    motion: MotionModel,
    /// Table to write (.csv, .csv.gz or .parquet); else CSV on standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the predictions as JSON; with --out, what was written
    #[arg(long)]
    json: bool,
}

/// What is told of a table that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Written<'a> {
    /// Its path.
    file: String,
    /// Its rows.
    postures: u64,
    /// What to do next.
    next_steps: &'a [Worded],
}

pub(super) fn run(arguments: &Arguments) -> Outcome {
    Files::default()
        .reads_robots([&arguments.robot.urdf])
        .reads(&arguments.model)
        .reads_logs([&arguments.data])
        .writes(Kind::Predictions, &arguments.out)
        .prints(arguments.json)
        .check_writable()?;
    let stance = arguments.robot.stance(arguments.model.as_deref())?;
    let sidecar = || Sidecar::of(&arguments.data).ok()?.0.support;
    let support = stance.support.clone().or_else(sidecar);
    // It computes the same on the robot.
    let generate = NextStep::Generate {
        support: Some(support.unwrap_or("LINK".to_string())),
        model: named(&arguments.model),
        of: Functions::Predicted,
    };
    let next_steps = About::new(&arguments.robot.urdf).worded([&generate]);
    let mut request = Request::new(stance, outputs::log(&arguments.data)?);
    request.angles = arguments.degrees.then_some(Angles::Deg);
    request.motion = arguments.motion;
    let bar = &mut Bar::new("predicting");
    let file = arguments.out.as_deref();
    let file = file.filter(|path| !outputs::is_standard(path));
    match (file, arguments.json) {
        (Some(path), json) => {
            let mut table = PostureWriter::predictions(path)?;
            let mut postures = 0;
            each(&request, bar, |pose, com_m, cop_m| {
                postures += 1;
                Ok(table.row(&Row {
                    pose,
                    q: com_m,
                    cop: cop_m,
                    ..Row::default()
                })?)
            })?;
            table.finish_alone()?;
            bar.clear();
            let file = path.display().to_string();
            message(&format!("wrote {file}"));
            let next_steps = &next_steps;
            let written = Written {
                file,
                postures,
                next_steps,
            };
            print_found(json, &written, true, || next_steps::text(next_steps))?;
        }
        (None, true) => print_json(&WithSteps {
            found: &predict(&request, bar)?,
            next_steps: &next_steps,
        })?,
        (None, false) => {
            let mut out = outputs::output();
            let mut begun = false;
            each(&request, bar, |pose, [x, y, z], [cop_x, cop_y]| {
                if !std::mem::replace(&mut begun, true) {
                    writeln!(out, "{}", PREDICTED.join(",")).map_err(Error::Stdout)?;
                }
                writeln!(out, "{pose},{x},{y},{z},{cop_x},{cop_y}").map_err(Error::Stdout)
            })?;
            out.flush().map_err(Error::Stdout)?;
            bar.clear();
            steps::say(&next_steps);
        }
    }
    Ok(true)
}

/// Give the pose, CoM and CoP of every row to `take`.
fn each(
    request: &Request,
    bar: &mut Bar,
    mut take: impl FnMut(i64, &[f64; 3], [f64; 2]) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut predictor = Predictor::open(request, bar)?;
    while let Some(found) = predictor.block(bar)? {
        let rows = found.pose.iter().zip(&found.com_m).zip(&found.cop_m);
        for ((pose, com_m), cop_m) in rows {
            take(*pose, com_m, *cop_m)?;
        }
    }
    Ok(())
}
