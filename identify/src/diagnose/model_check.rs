//! The model file as those who use it will read it, on the log that it came from.
//!
//! A file that predicts another error than was stated is not what was diagnosed. It is
//! written out, read back, given to the code of `sesc predict`, and compared.

use sesc_model::effects::{Catalog, Instance, PostureContext};
use sesc_model::{EffectRecord, Function, Model, ModelFile};

use super::criteria::model_file::{AGREES, BENEATH_NOISE, MOST_LEFT_OUT, OTHER_SIDE};
use super::findings::{Explained, ModelOnLog};
use super::held_out;
use super::hypothesis::Term;
use super::problem::Problem;
use super::stated::FileModel;
use crate::Error;
use crate::evaluate::{EffectPredictor, Evaluator};
use crate::observations::postures::rms;

/// Compare `file` with what was found.
///
/// # Errors
/// When the file is one that `sesc` refuses.
pub(super) fn check(
    problem: &Problem,
    found: &Explained,
    file: &ModelFile,
) -> Result<ModelOnLog, Error> {
    let refused = |reason: String| Error::request(reason);
    let mut apart = held_out::apart(problem, &found.best);
    let stated = held_out::errors_of(problem, &found.best, None);
    let error = |errors: &[f64], apart: &[bool]| {
        let rows = (0..errors.len()).filter(|row| !apart[row / 2]);
        rms(rows.map(|row| errors[row]))
    };
    // Effects of a caller's own are no part of files.
    let standard = Catalog::standard();
    let is_known = |record: &EffectRecord| standard.named(&record.effect).is_some();
    if !file.effects.iter().all(is_known) {
        let stated_rmse = error(&stated, &apart);
        return Ok(ModelOnLog {
            stated_rmse,
            predicted_rmse: stated_rmse,
            left_out: 0,
            agrees: true,
        });
    }
    let text = toml::to_string(file).map_err(|error| refused(error.to_string()))?;
    let read = ModelFile::parse(&text, "model.toml")?;
    let model = problem.first().model.clone().with_file(read)?;
    let predicted = readings(problem, &model);
    let readings = problem.first().data.reading.iter().zip(&predicted);
    let predicted: Vec<f64> = readings.map(|(y, p)| y - p).collect();
    // On which side of its dead band a joint rests near no moment, the log knows and a
    // posture alone does not.
    let loose = found
        .best
        .terms
        .iter()
        .any(|term| term.dead_band().is_some());
    let before = apart.iter().filter(|apart| **apart).count();
    for k in (0..apart.len()).filter(|_| loose) {
        let off = |row: usize| (predicted[row] - stated[row]).abs() * problem.first().weight[row];
        apart[k] |= off(2 * k).max(off(2 * k + 1)) > OTHER_SIDE;
    }
    let left_out = apart.iter().filter(|apart| **apart).count() - before;
    let (stated_rmse, predicted_rmse) = (error(&stated, &apart), error(&predicted, &apart));
    let slack = (AGREES * stated_rmse).max(BENEATH_NOISE * problem.first().data.noise_floor);
    let few = (left_out as f64) <= MOST_LEFT_OUT * apart.len() as f64;
    Ok(ModelOnLog {
        stated_rmse,
        predicted_rmse,
        left_out,
        agrees: few && (stated_rmse - predicted_rmse).abs() <= slack,
    })
}

/// Readings of the log's postures by the model, m.
fn readings(problem: &Problem, model: &Model) -> Vec<f64> {
    let (data, n) = (&problem.first().data, problem.first().data.len());
    let layout = PostureContext::of(model);
    let of_log = |(i, _): &(Instance, Vec<f64>)| !i.effect.is_static();
    let of_contacts = !data.other_contact.is_empty();
    if of_contacts || data.moved.is_some() || model.effects.iter().any(of_log) {
        // Drift, delay and motion need the log around a posture, and contacts where encoders have
        // them, which predictions lack.
        let terms = model.effects.iter().map(|(i, _)| Term::Effect(i.clone()));
        let terms: Vec<Term> = terms.collect();
        let unknowns: Vec<f64> = model.effects.iter().flat_map(|(_, x)| x.clone()).collect();
        return FileModel::new(problem, &terms).readings(problem, &unknowns, &model.params());
    }
    let tilt = |k: usize, axis: usize| data.posture_context[k * layout.len() + layout.tilt(axis)];
    let gravity: Vec<[f64; 3]> = (0..n).map(|k| [tilt(k, 0), tilt(k, 1), -1.0]).collect();
    match EffectPredictor::new(model) {
        Some(predictor) => predictor.run(&data.q, n, Some(&gravity)).1,
        None => {
            let com = Evaluator::new(model, Function::Com).run(&data.q, n);
            let shadow =
                |k: usize| [0, 1].map(|axis| com[3 * k + axis] + tilt(k, axis) * com[3 * k + 2]);
            (0..n).flat_map(shadow).collect()
        }
    }
}
