//! `sesc predict`

use std::collections::HashMap;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use sesc_model::{Function, ModelFile};

use super::{Outcome, RobotArguments, left_out, notes, progress, read_model, words};
use crate::Error;
use sesc_identify::evaluate::{Evaluator, Foretelling};
use sesc_identify::logs::{Angles, Block, Options, PostureReader, Readings};
use sesc_identify::robot::Robot;

/// Rows read, evaluated and printed together.
const BLOCK: usize = 4096;

/// CoM and CoP of every posture in a log, as CSV on stdout
#[derive(Args)]
#[command(
    after_help = "Example:\n  sesc predict robots/op2/op2.urdf --support r_sole --data poses.csv > predicted.csv"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: RobotArguments,
    /// Identified parameters, and their support where neither --support nor the log says it; else CAD
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture log (CSV, gzip, Parquet, MCAP): a column per joint, rad and m
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Turning joints are logged in degrees
    #[arg(long)]
    degrees: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let robot = Robot::read(&arguments.robot.urdf)?;
    let file = read_model(&robot, arguments.model.as_deref())?;
    let dofs = robot.description.dofs();
    // With a support from the flag, what the log says about it is not looked at.
    let links = match arguments.robot.support {
        Some(_) => Vec::new(),
        None => names(&robot),
    };
    let options = Options {
        angles: arguments.degrees.then_some(Angles::Deg),
        readings: Readings::Ignored,
        links,
        ..Options::default()
    };
    let mut reader = PostureReader::open(&arguments.data, &dofs, &options)?;
    warn(&mut reader);
    let mut predictor = Predictor {
        arguments,
        robot: &robot,
        file: file.as_ref(),
        evaluators: HashMap::new(),
    };
    let bar = progress("predicting");
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut started = false;
    loop {
        let block = reader.block(BLOCK)?;
        if block.is_empty() {
            break;
        }
        let predictions = predictor.block(&block)?;
        if !started {
            writeln!(out, "pose,com_x,com_y,com_z,cop_x,cop_y").map_err(Error::Stdout)?;
            started = true;
        }
        let rows = block.pose.iter().zip(&block.line);
        for ((pose, line), [x, y, z, cop_x, cop_y]) in rows.zip(predictions) {
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return Err(sesc_identify::Error::log(
                    arguments.data.display().to_string(),
                    Some(*line),
                    "an angle is beyond 2^20 rad, where sines mean nothing; \
                              reduce it by whole turns",
                )
                .into());
            }
            writeln!(out, "{pose},{x},{y},{z},{cop_x},{cop_y}").map_err(Error::Stdout)?;
        }
        let (done, total) = reader.progress();
        bar.set_length(total.unwrap_or(done));
        bar.set_position(done);
    }
    bar.finish_and_clear();
    out.flush().map_err(Error::Stdout)?;
    warn(&mut reader);
    Ok(Outcome::Ok)
}

/// Names of the robot's links.
fn names(robot: &Robot) -> Vec<String> {
    let links = robot.description.links.iter();
    links.map(|link| link.name.clone()).collect()
}

/// What the reader noticed and has not yet been told, on stderr.
fn warn(reader: &mut PostureReader) {
    reader
        .warnings
        .drain(..)
        .for_each(|warning| words::warn(&warning));
}

/// Predictions on whatever support a row stands on.
struct Predictor<'a> {
    arguments: &'a Arguments,
    robot: &'a Robot,
    /// Identified parameters.
    file: Option<&'a ModelFile>,
    evaluators: HashMap<String, (Evaluator, Option<Foretelling>)>,
}

impl Predictor<'_> {
    /// CoM and CoP of each row: runs of rows on one support are evaluated together.
    fn block(&mut self, block: &Block) -> Result<Vec<[f64; 5]>, Error> {
        let dof = block.q.len() / block.len();
        let on = |row: usize| block.support.as_ref().map(|all| &*all[row]);
        let mut predictions = Vec::with_capacity(block.len());
        let mut start = 0;
        while start < block.len() {
            let n = (start..block.len())
                .take_while(|row| on(*row) == on(start))
                .count();
            let logged = on(start).filter(|support| !support.is_empty());
            let arguments = &self.arguments.robot;
            let support = arguments.support(self.robot, logged, self.file)?;
            let (evaluator, foretelling) = self.evaluator(&support)?;
            let q = &block.q[start * dof..(start + n) * dof];
            let com = evaluator.run(q, n);
            for (row, com) in (start..).zip(com.chunks_exact(3)) {
                let gravity = block.gravity.as_ref().map(|all| all[row]);
                predictions.push(projected(com, gravity.unwrap_or([0.0, 0.0, -1.0])));
            }
            if let Some(foretelling) = foretelling {
                let gravity = block.gravity.as_ref().map(|all| &all[start..start + n]);
                let readings = foretelling.run(q, n, gravity);
                for (row, cop) in predictions[start..]
                    .iter_mut()
                    .zip(readings.chunks_exact(2))
                {
                    row[3..].copy_from_slice(cop);
                }
            }
            start += n;
        }
        Ok(predictions)
    }

    fn evaluator(&mut self, support: &str) -> Result<&(Evaluator, Option<Foretelling>), Error> {
        if !self.evaluators.contains_key(support) {
            let snapping = self.arguments.robot.snapping();
            let model = self.robot.model(support, snapping, self.file)?;
            if self.evaluators.is_empty() {
                notes(&model);
                left_out(&model);
            }
            let evaluator = Evaluator::new(&model, Function::Com);
            let both = (evaluator, Foretelling::new(&model));
            self.evaluators.insert(support.to_string(), both);
        }
        Ok(&self.evaluators[support])
    }
}

/// CoM, and its projection along gravity on the sole plane z = 0.
fn projected(com: &[f64], gravity: [f64; 3]) -> [f64; 5] {
    let [x, y, z] = [com[0], com[1], com[2]];
    let down = z / gravity[2];
    [x, y, z, x - gravity[0] * down, y - gravity[1] * down]
}
