//! Wiring faults, fitted by full evaluation: signs, swaps, units, axes. None of them is
//! near linear, so each is computed, alone and beside the best linear effect.

use std::borrow::Cow;
use std::sync::Arc;

use nalgebra::DVector;

use super::criteria;
use super::dictionary::Dictionary;
use super::hypothesis::{Term, sorted};
use super::problem::{Fit, Problem, Proposal, Rewire, stacked_residual, stacked_slopes};
use crate::health::wirings;
use crate::lsq::factor_normal;
use crate::threads::each_long;

pub fn proposals(problem: &Problem, dictionary: &Dictionary, faults: &[Term]) -> Vec<Proposal> {
    let context = &problem.first.context;
    let contexts = problem.posture_contexts(None);
    let with_best = each_long(faults, |fault| {
        let own = std::slice::from_ref(fault);
        let residual = residual(problem, (&[], &[]), &contexts, fault);
        let left = problem.project_out_one(&problem.nuisance, &residual);
        let penalty = problem.penalty(own);
        let predicted_score = residual.dot(&left) + penalty;
        if !predicted_score.is_finite() {
            return None;
        }
        let gains = dictionary.gains_of(&left);
        let best = dictionary
            .candidates
            .iter()
            .zip(gains)
            .map(|(c, gain)| {
                (
                    predicted_score - gain + problem.penalty(std::slice::from_ref(&c.term)),
                    &c.term,
                )
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let beside = best.map(|(predicted_score, more)| Proposal {
            terms: sorted(context, &[fault.clone(), more.clone()]),
            predicted_score,
            parent: None,
        });
        let alone = Proposal {
            terms: vec![fault.clone()],
            predicted_score,
            parent: None,
        };
        Some((alone, beside))
    });
    let (mut alone, beside): (Vec<_>, Vec<_>) = with_best.into_iter().flatten().unzip();
    let mut beside: Vec<Proposal> = beside.into_iter().flatten().collect();
    for (list, most) in [
        (&mut alone, criteria::WIRING_ALONE),
        (&mut beside, criteria::WIRING_PAIRS),
    ] {
        list.sort_by(|a, b| a.predicted_score.total_cmp(&b.predicted_score));
        list.truncate(most);
    }
    alone.extend(beside);
    alone
}

/// Further faults beside a hypothesis that leaves a large gap: its unknowns stay,
/// but for what a linear step of theirs takes.
pub fn beside(problem: &Problem, parent: &Fit, faults: &[Term]) -> Vec<Proposal> {
    let context = &problem.first.context;
    let contexts = problem.posture_contexts(Some(parent));
    let further = faults.iter().filter(|fault| !parent.terms.contains(fault));
    let known = (&parent.terms[..], &parent.unknowns[..]);
    let scores = scores(problem, known, &contexts, further);
    let proposals = scores.into_iter().map(|(fault, score)| Proposal {
        predicted_score: score + parent.penalty + problem.penalty(std::slice::from_ref(fault)),
        terms: sorted(
            context,
            &[&parent.terms[..], std::slice::from_ref(fault)].concat(),
        ),
        parent: Some(parent.clone()),
    });
    let mut proposals: Vec<Proposal> = proposals.collect();
    proposals.sort_by(|a, b| a.predicted_score.total_cmp(&b.predicted_score));
    proposals.truncate(criteria::WIRING_BESIDE_PARENT);
    proposals
}

/// Effects without unknowns; of very many in a long log those that come first on some of its
/// postures.
pub fn faults(problem: &Problem) -> Vec<Term> {
    let context = &problem.first.context;
    let all: Vec<Term> = wirings::faults(context)
        .into_iter()
        .map(Term::Effect)
        .collect();
    let postures: usize = problem.blocks().map(|block| block.data.len()).sum();
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
    let own = stacked_slopes(
        problem.predict(terms, unknowns, contexts, None).iter(),
        unknowns.len(),
    );
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
    let rewired = problem.blocks().map(|block| {
        let own = problem.carried(block, std::slice::from_ref(fault));
        block.rewired(&own.terms)
    });
    let (q, rewires): (Vec<Vec<f64>>, Vec<Rewire>) = rewired.unzip();
    let mut predicted = problem.predict(terms, unknowns, contexts, Some(&q));
    for ((on, block), rewire) in predicted.iter_mut().zip(problem.blocks()).zip(&rewires) {
        on.residual = Arc::new(block.residual(&rewire.readings(&on.predicted)));
    }
    stacked_residual(predicted.iter())
}
