//! Wiring faults, fitted by full evaluation: signs, swaps, units, axes. None of them is
//! near linear, so each is computed, alone and beside the best linear effect.

use std::borrow::Cow;

use nalgebra::DVector;
use sesc_model::tape::Tape;

use super::criteria;
use super::dictionary::{Candidate, Dictionary};
use super::hypothesis::Term;
use super::problem::{Fit, Problem, Proposal, run_alone, stacked_residual, stacked_slopes};
use crate::lsq::factor_normal;
use crate::threads::each_long;

pub fn proposals(problem: &Problem, dictionary: &Dictionary, faults: &[Term]) -> Vec<Proposal> {
    let contexts = problem.posture_contexts(None);
    let with_best = each_long(faults, |fault| {
        let own = std::slice::from_ref(fault);
        let residual = residual(problem, (&[], &[]), &contexts, fault);
        let left = problem.project_out_one(problem.masses(&[]), &residual);
        let penalty = problem.penalty(own);
        let predicted_score = residual.dot(&left) + penalty;
        if !predicted_score.is_finite() {
            return None;
        }
        let gains = dictionary.gains_of(&left);
        let proposal = |terms: &[&Term], predicted_score: f64| Proposal {
            terms: terms.iter().map(|term| (*term).clone()).collect(),
            predicted_score,
            parent: None,
        };
        let beside = dictionary.candidates.iter().zip(gains);
        let beside = beside.map(|(Candidate { term, .. }, gain)| {
            let penalty = problem.penalty(std::slice::from_ref(term));
            proposal(&[fault, term], predicted_score - gain + penalty)
        });
        let beside = beside.min_by(Proposal::order);
        Some((proposal(&[fault], predicted_score), beside))
    });
    let (mut alone, beside): (Vec<_>, Vec<_>) = with_best.into_iter().flatten().unzip();
    let mut beside: Vec<Proposal> = beside.into_iter().flatten().collect();
    for list in [&mut alone, &mut beside] {
        list.sort_by(Proposal::order);
        list.truncate(criteria::TRIED);
    }
    alone.extend(beside);
    alone
}

/// Further faults beside a hypothesis that leaves a large gap: its unknowns stay,
/// but for what a linear step of theirs takes.
pub fn beside(problem: &Problem, parent: &Fit, faults: &[Term]) -> Vec<Proposal> {
    let contexts = problem.posture_contexts(Some(parent));
    let further = faults.iter().filter(|fault| !parent.terms.contains(fault));
    let known = (&parent.terms[..], &parent.unknowns[..]);
    let masses = problem.masses(&parent.terms);
    let predicted = problem.predict(&parent.terms, &parent.unknowns, &contexts, None);
    let own = stacked_slopes(&predicted, parent.unknowns.len());
    let left = problem.project_out(masses, &own);
    let factor = factor_normal(own.tr_mul(&left));
    let proposals = each_long(further, |fault| {
        let residual = residual(problem, known, &contexts, fault);
        let pull = left.tr_mul(&residual);
        let gain = factor.as_ref().map_or(0.0, |f| pull.dot(&f.solve(&pull)));
        let score = residual.dot(&problem.project_out_one(masses, &residual)) - gain;
        let change = score - parent.objective;
        score
            .is_finite()
            .then(|| problem.propose(parent, fault, change))
    });
    let mut proposals: Vec<Proposal> = proposals.into_iter().flatten().collect();
    proposals.sort_by(Proposal::order);
    proposals.truncate(criteria::WIRING_BESIDE.1);
    proposals
}

/// Whitened residuals of all rows under a fault beside a hypothesis.
fn residual(
    problem: &Problem,
    (terms, unknowns): (&[Term], &[f64]),
    contexts: &[Cow<[f64]>],
    fault: &Term,
) -> DVector<f64> {
    let rewired = problem.blocks.iter().map(|block| {
        let own = problem.carried(block, std::slice::from_ref(fault), &[]);
        block.rewired(&own.terms)
    });
    let (q, rewires): (Vec<Vec<f64>>, Vec<Option<Tape>>) = rewired.unzip();
    let mut predicted = problem.predict(terms, unknowns, contexts, Some(&q));
    for ((on, block), rewire) in predicted.iter_mut().zip(&problem.blocks).zip(&rewires) {
        if let Some(tape) = rewire {
            let readings = run_alone(tape, &block.predicted(on), block.data.len());
            block.put_readings(&readings, on);
        }
    }
    stacked_residual(&predicted)
}
