//! The corrected model as a file: parameters and effects.

use std::collections::BTreeMap;

use sesc_model::effects::Stage;
use sesc_model::{EffectRecord, ModelFile, Quantity};

use super::problem::{ALL, Fit, Problem};
use super::words;
use crate::lsq::solve::information;

/// Parameters as the masses' prior and the data have them, and every effect of
/// the explanation `best` that a model can hold; the logs are added by the caller.
pub fn model_file(problem: &Problem, best: &Fit) -> ModelFile {
    let model = problem.first().context.robot;
    let identified = best.frees_masses();
    let prior = problem.prior(&best.terms);
    let values = problem.params_of(best);
    let weighting = problem.weighting(&best.terms, best.outliers.as_ref(), ALL);
    let spread = &prior.factor * weighting.masses.covariance() * prior.factor.transpose();
    let std: Vec<f64> = (0..values.len())
        .map(|k| spread[(k, k)].max(0.0).sqrt())
        .collect();
    let mut rows = problem.whitened_rows();
    weighting.weigh(&mut rows);
    let source = if identified { "data" } else { "prior" };
    let mut file = ModelFile::from_values(model, &values, Some(&std), source);
    file.inform(information(&rows, &prior.factor, prior.beyond));
    file.noise_floor = Some(problem.first().data.noise_floor);
    let quantities = words::values(problem, best);
    for (term, values) in best.terms.iter().zip(&quantities) {
        let Some(instance) = term.effect() else {
            continue;
        };
        if instance.effect.stage() == Stage::Cells {
            file.cells = problem.first().data.cells.clone();
        }
        let of = |v: &words::NamedValue| {
            let quantity = Quantity {
                value: v.value,
                std: v.std.is_finite().then_some(v.std),
            };
            (v.name.to_string(), quantity)
        };
        file.effects.push(EffectRecord {
            effect: term.name().to_string(),
            target: problem.first().context.name_of(&instance.target),
            parameters: values.iter().map(of).collect::<BTreeMap<_, _>>(),
        });
    }
    file
}
