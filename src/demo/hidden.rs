//! The demo's second act: something is wrong with the robot, and is found.
//!
//! The reference's virtual robot hides backlash in every joint: its joints rest
//! where gravity puts them, not where their encoders say. 100 balanced postures
//! and their CoP go into the diagnosis; the CoP and the CoM of the model it gives
//! are judged on postures that were not fitted.

use std::sync::Arc;

use nalgebra::Vector3;
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::{Function, Model, Snapping};
use sesc_reference::World;

use crate::Error;
use crate::report::HiddenAct;
use sesc_identify::diagnose::{self, Request};
use sesc_identify::evaluate::{Evaluator, InLog, ReadingPredictor};
use sesc_identify::logs::Table;
use sesc_identify::observations::rms;
use sesc_identify::plan::Geometry;
use sesc_identify::plan::Limits;
use sesc_identify::plan::Region;
use sesc_identify::plan::Scene;
use sesc_identify::plan::sample;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::threads::both;

/// Width of the hidden dead bands: 0.9°.
pub const WIDTH_RAD: f64 = 0.9 * std::f64::consts::PI / 180.0;
/// Postures that are read, and further ones that judge.
pub const POSTURES: usize = 100;
/// Postures never fitted, on which the corrected model is judged.
pub const JUDGED: usize = 1000;
/// Noise of the mean of 100 readings as in the paper, and of encoder ticks, m.
const NOISE: f64 = super::NOISE / 10.0;
const FLOOR: f64 = 1e-4;
/// CoP of the seed paper's stable postures, m.
const BOX: f64 = 0.023;

/// Hide dead bands in all joints, diagnose them from simulated readings, and judge the
/// corrected model.
///
/// # Errors
/// Where the robot cannot be read, diagnosed or generated.
pub fn run(robot: &Robot, model: &Model, seed: u64) -> Result<HiddenAct, Error> {
    let virtual_robot = sesc_reference::Robot::from_urdf(robot.text())?;
    let rigid = World::new(&virtual_robot, "r_sole")?;
    let loose = rigid.clone().backlash_all(WIDTH_RAD)?;
    let q = balanced(robot, model, POSTURES + JUDGED, seed)?;
    let dof = model.dof();
    let (taken, judged) = q.split_at(POSTURES * dof);
    let mut simulator = Simulator::new(&model.tree.dofs, None, seed);
    let readings: Vec<f64> = taken
        .chunks_exact(dof)
        .flat_map(|q| loose.cop(q))
        .map(|y| y + simulator.gauss(NOISE))
        .collect();
    let request = request(robot, model, taken, &readings)?;
    let repair = || -> Result<_, Error> {
        let report = diagnose::diagnose(&request, &mut ())?;
        let corrected = robot.model("r_sole", Snapping::default(), Some(&report.model_file))?;
        let code = rust::module(&Facts::of(&corrected), "op2_r_sole")?;
        Ok((report, corrected, code))
    };
    let truths = || -> (Vec<_>, Vec<_>) {
        let postures = judged.chunks_exact(dof);
        let at_rest = postures.map(|q| loose.true_posture(q));
        at_rest.map(|q| (rigid.cop(&q), rigid.com(&q))).unzip()
    };
    let (repaired, (cop, com)) = both(repair, truths);
    let (report, corrected, code) = repaired?;
    let cad = Evaluator::new(model, Function::Cop).run(judged, JUDGED);
    let better = ReadingPredictor::new(&corrected);
    let better = better.run((judged, JUDGED), &InLog::default(), &[], &[]).1;
    let error = |found: &[f64]| rms(found.iter().zip(cop.as_flattened()).map(|(a, b)| a - b));
    let distance = |model: &Model| {
        let found = Evaluator::new(model, Function::Com).run(judged, JUDGED);
        let gaps = found.chunks_exact(3).zip(&com);
        rms(gaps.map(|(found, truth)| (Vector3::from_column_slice(found) - truth).norm()))
    };
    Ok(HiddenAct {
        sentence: report.diagnosis.sentence.clone(),
        postures: POSTURES,
        judged: JUDGED,
        before: error(&cad),
        after: error(&better),
        com_before: distance(model),
        com_after: distance(&corrected),
        lines: code.lines().count(),
        view: report.view.expect("the request asks for a view"),
        diagnosis: report.diagnosis,
    })
}

/// Readings (m) of postures `q`, by a robot that weighs what CAD says.
fn request(robot: &Robot, model: &Model, q: &[f64], readings: &[f64]) -> Result<Request, Error> {
    let dof = model.dof();
    let column = |values: &[f64], from: usize, step: usize| -> Vec<f64> {
        values.iter().skip(from).step_by(step).copied().collect()
    };
    let mut log = Table::new(format!("{POSTURES} balanced postures"))
        .numbers("cop_x", column(readings, 0, 2))
        .numbers("cop_y", column(readings, 1, 2));
    for (joint, own) in model.tree.dofs.iter().enumerate() {
        log = log.numbers(&own.joint, column(q, joint, dof));
    }
    let robot = Robot::parse(robot.text(), &robot.description.file)?;
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("r_sole".into());
    request.prior = "tight".into();
    request.noise = Some(NOISE);
    request.floor = FLOOR;
    request.view = true;
    Ok(request)
}

/// Postures within ±30° that stand.
fn balanced(robot: &Robot, model: &Model, count: usize, seed: u64) -> Result<Vec<f64>, Error> {
    let mut limits = Limits::of_urdf(&model.tree.dofs);
    let range = super::RANGE_DEG.to_radians();
    for (low, high) in &mut limits.ranges {
        (*low, *high) = (low.max(-range), high.min(range));
    }
    let region = Region::square(BOX, 0.0)?;
    let geometry = Geometry::read(&robot.description, None);
    let scene = Scene::new(model, &geometry, &limits, &region, 0.005, None);
    let (found, _) = sample(&scene, seed, count, 100 * count, |_| Ok(()))?;
    match found.len() == count * model.dof() {
        true => Ok(found),
        false => Err(Error::Usage(
            "too few balanced postures for the demo".into(),
        )),
    }
}
