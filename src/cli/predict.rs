//! `sesc predict`

use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::{Bar, Motion, Outcome, RobotArguments};
use crate::Error;
use sesc_identify::logs::{self, Angles};
use sesc_identify::predict::{Predictor, Request};

/// CoM and CoP of every posture in a log, as CSV on stdout
#[derive(Args)]
#[command(after_help = format!(
    "Example:\n  sesc predict robots/op2/op2.urdf --support r_sole --data poses.csv > predicted.csv\n\n{}",
    logs::columns_text()
))]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Identified parameters, and their support where neither --support nor the log says it; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP); its columns are listed below
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Revolute joints are logged in degrees
    #[arg(long)]
    degrees: bool,
    /// Predict the ZMP where a log with `t` knows accelerations, or the CoP of standing postures
    #[arg(long, value_enum, default_value_t)]
    motion: Motion,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let stance = arguments.robot.stance(arguments.model.as_deref())?;
    let mut request = Request::new(stance, &arguments.data);
    request.angles = arguments.degrees.then_some(Angles::Deg);
    request.motion = arguments.motion.into();
    let mut bar = Bar::new("predicting");
    let mut predictor = Predictor::open(&request, &mut bar)?;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut header = "pose,com_x,com_y,com_z,cop_x,cop_y\n";
    while let Some(found) = predictor.block(&mut bar)? {
        let rows = found.pose.iter().zip(&found.com_m).zip(&found.cop_m);
        for ((pose, [x, y, z]), [cop_x, cop_y]) in rows {
            writeln!(out, "{header}{pose},{x},{y},{z},{cop_x},{cop_y}").map_err(Error::Stdout)?;
            header = "";
        }
    }
    out.flush().map_err(Error::Stdout)?;
    Ok(Outcome::Ok)
}
