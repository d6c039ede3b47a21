//! How far apart the CoMs of explanations are that the readings cannot tell apart.
//!
//! A sensor that is off and a payload may leave the same readings: with the first the CoM
//! is where CAD has it, with the second it is not. Who uses the corrected CoM must know.

use sesc_model::Function;

use super::criteria;
use super::findings::Explained;
use super::model_file::model_file;
use super::problem::{Fit, Problem};
use crate::evaluate::Evaluator;

/// State for every member of the class how far its CoM is from the first one's, m RMS over
/// the postures of the log; unknown where an effect is no part of model files.
pub(super) fn state(problem: &Problem, found: &mut Explained) {
    let first = coms(problem, &found.best);
    let others = found.class.iter().filter(|fit| !fit.terms.is_empty());
    let apart = others.map(|fit| {
        let other = coms(problem, fit);
        first.as_ref().zip(other).map(|(a, b)| distance(a, &b))
    });
    let apart: Vec<Option<f64>> = apart.collect();
    for (member, apart) in found.diagnosis.class.iter_mut().zip(apart) {
        member.com_apart = apart;
    }
}

/// The sentence where CoMs differ by more than a controller may overlook.
pub(super) fn sentence(found: &Explained) -> Option<String> {
    let members = found.diagnosis.class.iter().skip(1);
    let far = members.filter_map(|member| Some((member.com_apart?, member)));
    let (apart, member) = far.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (apart > criteria::COM_APART_M).then(|| {
        format!(
            "These explanations do not agree on the CoM: with {} it lies {:.1} mm RMS away; \
             take the next postures before a controller relies on it.",
            member.subjects,
            1e3 * apart
        )
    })
}

/// CoM (x, y, z) of every posture under an explanation, m.
fn coms(problem: &Problem, fit: &Fit) -> Option<Vec<f64>> {
    let model = problem.first().model.clone();
    let model = model.with_file(model_file(problem, fit)).ok()?;
    let n = problem.data().len();
    Some(Evaluator::new(&model, Function::Com).run(&problem.data().q, n))
}

/// RMS distance of points, x, y, z after each other.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (3.0 * squares / a.len().max(1) as f64).sqrt()
}
