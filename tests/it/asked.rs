//! Questions to the library about logs of virtual robots, and what is read of the answers.

use std::sync::Arc;

use sesc_identify::diagnose::{self, Diagnosis};
use sesc_identify::fit::{self, Identification};
use sesc_identify::health::Finding;
use sesc_identify::logs::LogSource;
use sesc_identify::robot::Robot;
pub(crate) use sesc_test_support::recording::table;
use sesc_test_support::recording::{Kind, Noise, Recording};
use sesc_test_support::stage::Stage;

/// White noise of `std` m.
pub(crate) fn white(std: f64) -> Noise {
    Noise::new(Kind::White, std)
}

/// The robot of a stage as CAD has it.
pub(crate) fn robot(stage: &Stage) -> Arc<Robot> {
    Arc::new(Robot::read(&stage.urdf).unwrap())
}

/// A question for a diagnosis of a log of the robot of `stage`.
pub(crate) fn request(stage: &Stage, log: impl Into<LogSource>) -> diagnose::Request {
    let mut request = diagnose::Request::new(robot(stage), log);
    request.support = Some(stage.support.into());
    request
}

/// The same for a fit.
pub(crate) fn fit_request(stage: &Stage, log: impl Into<LogSource>) -> fit::Request {
    let mut request = fit::Request::default();
    request.robot = Some(robot(stage));
    request.logs = vec![log.into()];
    request.support = Some(stage.support.into());
    request
}

/// The same for a diagnosis of a recording.
pub(crate) fn of_recording(stage: &Stage, recording: &Recording) -> diagnose::Request {
    request(stage, recording.table(true))
}

/// The answer of a diagnosis.
pub(crate) fn diagnosed(request: &diagnose::Request) -> Diagnosis {
    let found = diagnose::diagnose(request, &mut ()).unwrap().diagnosis;
    println!("{:?} {}", found.verdict, found.sentence);
    found
}

/// The answer of a fit.
pub(crate) fn fitted(request: &fit::Request) -> Identification {
    fit::fit(request, &mut ()).unwrap().identification
}

/// Effects that a diagnosis names, with their targets, sorted.
pub(crate) fn labels(found: &Diagnosis) -> Vec<String> {
    let steps = found.steps.iter();
    let mut labels: Vec<String> = steps
        .map(|step| format!("{}:{}", step.effect, step.target))
        .collect();
    labels.sort();
    labels
}

/// Whether an explanation of the class is this, in any order.
pub(crate) fn is_listed(found: &Diagnosis, truth: &[&str]) -> bool {
    let same = |all: &Vec<String>| {
        all.len() == truth.len() && truth.iter().all(|one| all.iter().any(|x| x == one))
    };
    found.indistinguishable.iter().any(same)
}

/// Fails where it is not.
#[track_caller]
pub(crate) fn lists(found: &Diagnosis, truth: &[&str]) {
    let class = &found.indistinguishable;
    assert!(is_listed(found, truth), "{truth:?} is not in {class:?}");
}

/// Kinds of findings about the data, and what each is of.
pub(crate) fn kinds(health: &[Finding]) -> Vec<(&str, &str)> {
    let health = health.iter();
    health.map(|h| (h.kind.name(), &*h.target)).collect()
}
