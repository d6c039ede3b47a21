//! `sesc predict`

use std::collections::HashMap;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;
use sesc_codegen::{Function, Model};

use super::{Outcome, RobotArguments, message, notes, progress};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::posture_log::{Angles, PostureReader, Row, Sidecar};
use crate::robot::Robot;

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
    /// Identified parameters; CAD unless given
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Posture log: a column per joint, rows in rad and m
    #[arg(long, value_name = "FILE")]
    data: PathBuf,
    /// Turning joints are logged in degrees
    #[arg(long)]
    degrees: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Outcome, Error> {
    let robot = Robot::read(&arguments.robot.urdf)?;
    let sidecar = Sidecar::of(&arguments.data)?;
    let mut predictor = Predictor::new(arguments, &robot, &sidecar);
    // Joints are the same on every support: any model can match the header.
    let first = first_support(arguments, &robot, &sidecar)?;
    let dofs = robot
        .model(&first, arguments.robot.snapping(), None)?
        .tree
        .dofs;
    let angles = match (arguments.degrees, sidecar.angles) {
        (true, _) => Angles::Deg,
        (false, angles) => angles.unwrap_or(Angles::Rad),
    };
    let mut reader = PostureReader::open(&arguments.data, &dofs, angles)?;
    for column in &reader.ignored {
        message(&format!(
            "warning: column `{column}` is no joint of {} and is ignored",
            robot.description.name
        ));
    }
    let bar = progress("predicting");
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut written = 0;
    loop {
        let (rows, q) = reader.block(BLOCK)?;
        if rows.is_empty() {
            break;
        }
        let predictions = predictor.block(&rows, &q)?;
        if written == 0 {
            writeln!(out, "pose,com_x,com_y,com_z,cop_x,cop_y").map_err(Error::Stdout)?;
        }
        for (row, [x, y, z, cop_x, cop_y]) in rows.iter().zip(predictions) {
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return Err(Error::Log {
                    file: arguments.data.display().to_string(),
                    line: Some(row.line),
                    message: "an angle is beyond 2^20 rad, where sines mean nothing; \
                              reduce it by whole turns"
                        .into(),
                });
            }
            writeln!(out, "{},{x},{y},{z},{cop_x},{cop_y}", row.pose).map_err(Error::Stdout)?;
        }
        written += rows.len();
        bar.set_length(written as u64);
        bar.set_position(written as u64);
    }
    bar.finish_and_clear();
    out.flush().map_err(Error::Stdout)?;
    if written == 0 {
        return Err(Error::Log {
            file: arguments.data.display().to_string(),
            line: None,
            message: "no postures below the header".into(),
        });
    }
    Ok(Outcome::Ok)
}

/// A support to match joints with: any link does.
fn first_support(arguments: &Arguments, robot: &Robot, sidecar: &Sidecar) -> Result<String, Error> {
    arguments
        .robot
        .support(robot, sidecar.support.as_deref())
        .or_else(|error| match robot.description.robot.links.first() {
            // The log may name its support row by row.
            Some(link) => Ok(link.name.clone()),
            None => Err(error),
        })
}

/// Predictions on whatever support a row stands on.
struct Predictor<'a> {
    arguments: &'a Arguments,
    robot: &'a Robot,
    sidecar: &'a Sidecar,
    evaluators: HashMap<String, (Evaluator, usize)>,
}

impl<'a> Predictor<'a> {
    fn new(arguments: &'a Arguments, robot: &'a Robot, sidecar: &'a Sidecar) -> Self {
        Predictor {
            arguments,
            robot,
            sidecar,
            evaluators: HashMap::new(),
        }
    }

    /// CoM and CoP of each row: runs of rows on one support are evaluated together.
    fn block(&mut self, rows: &[Row], q: &[f64]) -> Result<Vec<[f64; 5]>, Error> {
        let dof = q.len() / rows.len();
        let mut predictions = Vec::with_capacity(rows.len());
        let mut start = 0;
        while start < rows.len() {
            let same = |row: &Row| row.support == rows[start].support;
            let n = rows[start..].iter().take_while(|row| same(row)).count();
            let support = self.support(&rows[start])?;
            let gravity = self.sidecar.gravity.unwrap_or([0.0, 0.0, -1.0]);
            let evaluator = self.evaluator(&support)?;
            let com = evaluator.run(&q[start * dof..(start + n) * dof], n);
            predictions.extend(com.chunks(3).map(|com| projected(com, gravity)));
            start += n;
        }
        Ok(predictions)
    }

    /// The flag wins, then the row's own column, then the sidecar.
    fn support(&self, row: &Row) -> Result<String, Error> {
        let fallback = row
            .support
            .as_deref()
            .filter(|support| !support.is_empty())
            .or(self.sidecar.support.as_deref());
        self.arguments.robot.support(self.robot, fallback)
    }

    fn evaluator(&mut self, support: &str) -> Result<&Evaluator, Error> {
        if !self.evaluators.contains_key(support) {
            let file = self.arguments.model.as_deref();
            let model: Model = self
                .robot
                .model(support, self.arguments.robot.snapping(), file)?;
            if self.evaluators.is_empty() {
                notes(&model);
            }
            let evaluator = Evaluator::new(&model, Function::Com);
            self.evaluators
                .insert(support.to_string(), (evaluator, model.dof()));
        }
        Ok(&self.evaluators[support].0)
    }
}

/// CoM, and its projection along gravity on the sole plane z = 0.
fn projected(com: &[f64], gravity: [f64; 3]) -> [f64; 5] {
    let [x, y, z] = [com[0], com[1], com[2]];
    let down = z / gravity[2];
    [x, y, z, x - gravity[0] * down, y - gravity[1] * down]
}
