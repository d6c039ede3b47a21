//! `sesc simulate`

use std::path::PathBuf;

use clap::Args;
use sesc_model::{Function, Model};

use super::{Outcome, RobotArguments, message, progress};
use crate::Error;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::logs::{PostureWriter, Row, Sidecar, Written};
use sesc_identify::simulate::Simulator;

/// Rows written together.
const BLOCK: usize = 4096;

/// Write a posture log of an ideal robot, with CoP noise
#[derive(Args)]
#[command(
    after_help = "Example:\n  sesc simulate robots/op2/op2.urdf --support r_sole --poses 1000 --range 30 --noise 0.00493 --out log.csv"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Number of postures
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..=10_000_000))]
    poses: u64,
    /// Draw turning joints within ±DEG of zero (and their limits); else within their limits
    #[arg(long, value_name = "DEG")]
    range: Option<f64>,
    /// Standard deviation of the CoP noise, m
    #[arg(long, value_name = "M", default_value_t = 0.0)]
    noise: f64,
    /// Seed of postures and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Parameters of the simulated robot, and their support unless --support is given; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Log to write (.csv, .csv.gz or .parquet); its sidecar gets the same name with .toml
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    if let Some(range) = arguments.range.filter(|r| !(r.is_finite() && *r > 0.0)) {
        return Err(Error::Usage(format!(
            "--range {range}: give a positive number of degrees"
        )));
    }
    let noise = arguments.noise;
    if !(noise.is_finite() && noise >= 0.0) {
        return Err(Error::Usage(format!(
            "--noise {noise}: give metres, zero or more"
        )));
    }
    let (_, model) = arguments.robot.load(arguments.model.as_deref())?;
    let sidecar = write_log(arguments, &model)?;
    message(&format!(
        "wrote {} and {}",
        arguments.out.display(),
        sidecar.display()
    ));
    Ok(Outcome::Ok)
}

/// Write log and sidecar, whose path is given back.
fn write_log(arguments: &Arguments, model: &Model) -> Result<PathBuf, Error> {
    let range = arguments.range.map(f64::to_radians);
    let mut simulator = Simulator::new(&model.tree.dofs, range, arguments.seed);
    let evaluator = Evaluator::new(model, Function::Cop);
    let columns = Written {
        cop: true,
        cop_std: arguments.noise > 0.0,
        ..Written::default()
    };
    let mut log = PostureWriter::create(&arguments.out, &model.tree.dofs, columns)?;
    let poses = usize::try_from(arguments.poses).unwrap_or(usize::MAX);
    let dof = model.dof();
    let bar = progress("simulating");
    bar.set_length(arguments.poses);
    for start in (0..poses).step_by(BLOCK) {
        let n = BLOCK.min(poses - start);
        let q = simulator.batch(n);
        let readings = evaluator.run(&q, n);
        for (k, cop) in readings.chunks_exact(2).enumerate() {
            let [x, y] = [cop[0], cop[1]].map(|x| x + simulator.gauss(arguments.noise));
            log.row(&Row {
                pose: (start + k) as i64,
                q: &q[k * dof..(k + 1) * dof],
                cop: [x, y],
                cop_std: [arguments.noise; 2],
                ..Row::default()
            })?;
        }
        bar.inc(n as u64);
    }
    bar.finish_and_clear();
    Ok(log.finish(&Sidecar {
        robot: Some(model.tree.robot.clone()),
        support: Some(model.tree.links[model.tree.support].name.clone()),
        ..Sidecar::default()
    })?)
}
