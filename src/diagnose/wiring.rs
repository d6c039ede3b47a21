//! Wiring faults by full evaluation: signs, swaps, units, axes. None of them is
//! near linear, so each is computed, alone and beside the best linear effect.

use nalgebra::DVector;
use sesc_codegen::effects::{self, Instance};

use super::dictionary::Dictionary;
use super::problem::Problem;
use super::search::Proposal;

/// Faults that are fitted, alone and with an effect beside them.
const ALONE: usize = 8;
const BESIDE: usize = 8;

pub fn proposals(problem: &Problem, dictionary: &Dictionary) -> Vec<Proposal> {
    let setting = &problem.setting;
    let faults = effects::instances(setting)
        .into_iter()
        .filter(|i| i.unknowns(setting) == 0 && i.effect.stage() != effects::Stage::Whole);
    let mut alone = Vec::new();
    let mut beside = Vec::new();
    for fault in faults {
        let own = std::slice::from_ref(&fault);
        let residual = residual(problem, &fault);
        let left = problem.nuisance.beyond_one(&residual);
        let price = problem.price(own);
        let promise = residual.dot(&left) + price;
        if !promise.is_finite() {
            continue;
        }
        let gains = dictionary.gains_of(&residual);
        let best = dictionary
            .candidates
            .iter()
            .zip(gains)
            .map(|(c, gain)| {
                (
                    promise - gain + problem.price(std::slice::from_ref(&c.instance)),
                    &c.instance,
                )
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        alone.push(Proposal {
            instances: vec![fault.clone()],
            promise,
            parent: None,
        });
        if let Some((promise, more)) = best {
            beside.push(Proposal {
                instances: super::search::sorted(&[fault.clone(), more.clone()]),
                promise,
                parent: None,
            });
        }
    }
    for (list, most) in [(&mut alone, ALONE), (&mut beside, BESIDE)] {
        list.sort_by(|a, b| a.promise.total_cmp(&b.promise));
        list.truncate(most);
    }
    alone.extend(beside);
    alone
}

/// Whitened residuals under a fault.
fn residual(problem: &Problem, fault: &Instance) -> DVector<f64> {
    let data = &problem.data;
    let rows = 2 * data.len();
    let (q, map) = problem.rewired(fault);
    let out = problem.evaluate(&[], &[], &q, &data.circumstances);
    DVector::from_fn(rows, |row, _| {
        let pair = [out[row - row % 2], out[row - row % 2 + 1]];
        (data.reading[row] - map(pair)[row % 2]) * problem.weight[row]
    })
}
