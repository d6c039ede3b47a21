//! Wiring faults, fitted by full evaluation: signs, swaps, units, axes. None of them is
//! near linear, so each is computed, alone and beside the best linear effect.

use std::borrow::Cow;

use nalgebra::DVector;
use sesc_model::tape::Tape;

use super::criteria;
use super::dictionary::{Candidate, Dictionary};
use super::hypothesis::Term;
use super::problem::{Fit, Problem, Proposal, run_alone, stacked_residual, stacked_slopes};
use crate::health::wirings;
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
    let scores = scores(problem, known, &contexts, further).into_iter();
    let proposals =
        scores.map(|(fault, score)| problem.propose(parent, fault, score - parent.objective));
    let mut proposals: Vec<Proposal> = proposals.collect();
    proposals.sort_by(Proposal::order);
    proposals.truncate(criteria::WIRING_BESIDE.1);
    proposals
}

/// Effects without unknowns; of very many in a long log those that come first on some of its
/// postures: a chain of 100 joints has 5000 pairs of encoders that may be exchanged.
pub fn faults(problem: &Problem) -> Vec<Term> {
    let all = wirings::faults(problem.context()).into_iter();
    let all: Vec<Term> = all.map(Term::Effect).collect();
    let postures: usize = problem.blocks.iter().map(|block| block.data.len()).sum();
    let every = (all.len() * postures).div_ceil(criteria::WIRING_WORK);
    if every < 2 {
        return all;
    }
    let some = problem.thinned(every);
    let mut scored = scores(&some, (&[], &[]), &some.posture_contexts(None), &all);
    scored.sort_by(|a, b| a.1.total_cmp(&b.1));
    scored.truncate(criteria::WIRING_WORK / postures);
    scored.into_iter().map(|(fault, _)| fault.clone()).collect()
}

/// χ² of each fault beside a hypothesis: its unknowns stay, but for what a linear step of theirs
/// takes.
fn scores<'f>(
    problem: &Problem,
    (terms, unknowns): (&[Term], &[f64]),
    contexts: &[Cow<[f64]>],
    faults: impl IntoIterator<Item = &'f Term>,
) -> Vec<(&'f Term, f64)> {
    let masses = problem.masses(terms);
    let predicted = problem.predict(terms, unknowns, contexts, None);
    let own = stacked_slopes(&predicted, unknowns.len());
    let left = problem.project_out(masses, &own);
    let factor = factor_normal(own.tr_mul(&left));
    let scores = each_long(faults, |fault| {
        let residual = residual(problem, (terms, unknowns), contexts, fault);
        let pull = left.tr_mul(&residual);
        let gain = factor.as_ref().map_or(0.0, |f| pull.dot(&f.solve(&pull)));
        let score = problem.chi2(masses, &residual) - gain;
        score.is_finite().then_some((fault, score))
    });
    scores.into_iter().flatten().collect()
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
