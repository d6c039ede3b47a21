//! Questions to the library about recordings of virtual robots.

use std::sync::Arc;

use sesc_identify::logs::{LogSource, Table};
use sesc_identify::robot::Robot;
use sesc_identify::{diagnose, fit};
use sesc_test_support::recording::{Kind, Noise, Recording};
use sesc_test_support::stage::Stage;

/// White noise of `std` m.
pub fn white(std: f64) -> Noise {
    Noise::new(Kind::White, std)
}

/// A log of these columns.
pub fn table(columns: Vec<(String, Vec<f64>)>) -> Table {
    let add = |table: Table, (name, values): (String, Vec<f64>)| table.numbers(&name, values);
    columns.into_iter().fold(Table::new("log"), add)
}

/// The robot of a stage as CAD has it.
pub fn robot(stage: &Stage) -> Arc<Robot> {
    Arc::new(Robot::read(&stage.urdf).unwrap())
}

/// A question for a diagnosis of a log of the robot of `stage`.
pub fn request(stage: &Stage, log: impl Into<LogSource>) -> diagnose::Request {
    let mut request = diagnose::Request::new(robot(stage), log);
    request.support = Some(stage.support.into());
    request
}

/// The same for a fit.
pub fn fit_request(stage: &Stage, log: impl Into<LogSource>) -> fit::Request {
    let mut request = fit::Request::default();
    request.robot = Some(robot(stage));
    request.logs = vec![log.into()];
    request.support = Some(stage.support.into());
    request
}

/// The same for a diagnosis of a recording.
pub fn of_recording(stage: &Stage, recording: &Recording) -> diagnose::Request {
    request(stage, table(recording.columns(true)))
}
