//! `sesc simulate`

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use sesc_codegen::{Function, Model};

use super::{Outcome, RobotArguments, message, progress};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::output::{self, NewFile};
use crate::posture_log::Sidecar;
use crate::simulate::Simulator;

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
    /// Parameters of the simulated robot; CAD unless given
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Log to write; its sidecar gets the same name with .toml
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
    if arguments.out.extension().is_some_and(|e| e == "toml") {
        return Err(Error::Usage(
            "--out ends in .toml, which is the sidecar's; use .csv".into(),
        ));
    }
    let (_, model) = arguments.robot.load(arguments.model.as_deref())?;
    write_log(arguments, &model)?;
    let sidecar = Sidecar {
        robot: Some(model.tree.robot.clone()),
        support: Some(model.tree.links[model.tree.support].name.clone()),
        ..Sidecar::default()
    };
    let text = toml::to_string(&sidecar).map_err(|error| Error::Report(Box::new(error)))?;
    let path = Sidecar::path(&arguments.out);
    output::write(&path, &text)?;
    message(&format!(
        "wrote {} and {}",
        arguments.out.display(),
        path.display()
    ));
    Ok(Outcome::Ok)
}

fn write_log(arguments: &Arguments, model: &Model) -> Result<(), Error> {
    let range = arguments.range.map(f64::to_radians);
    let mut simulator = Simulator::new(&model.tree.dofs, range, arguments.seed);
    let cop = Evaluator::new(model, Function::Cop);
    let mut log = NewFile::create(&arguments.out)?;
    let failed = |source| output::failed(Path::new(&arguments.out), source);
    let noisy = arguments.noise > 0.0;
    let mut header = vec!["pose".to_string()];
    header.extend(model.tree.dofs.iter().map(|dof| quoted(&dof.joint)));
    header.extend(["cop_x".to_string(), "cop_y".to_string()]);
    if noisy {
        header.extend(["cop_x_std".to_string(), "cop_y_std".to_string()]);
    }
    writeln!(log, "{}", header.join(",")).map_err(failed)?;
    let poses = usize::try_from(arguments.poses).unwrap_or(usize::MAX);
    let bar = progress("simulating");
    bar.set_length(arguments.poses);
    for start in (0..poses).step_by(BLOCK) {
        let n = BLOCK.min(poses - start);
        let q = simulator.batch(n);
        let readings = cop.run(&q, n);
        for k in 0..n {
            let mut line = format!("{}", start + k);
            for x in &q[k * model.dof()..(k + 1) * model.dof()] {
                line.push_str(&format!(",{x}"));
            }
            for x in &readings[2 * k..2 * k + 2] {
                line.push_str(&format!(",{}", x + simulator.gauss(arguments.noise)));
            }
            if noisy {
                line.push_str(&format!(",{0},{0}", arguments.noise));
            }
            writeln!(log, "{line}").map_err(failed)?;
        }
        bar.inc(n as u64);
    }
    bar.finish_and_clear();
    log.finish()
}

/// A CSV field; names may hold commas and quotes.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) || name.trim() != name {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_string()
    }
}
