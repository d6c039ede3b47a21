//! Wiring faults, fitted by full evaluation: signs, swaps, units, axes. None of them is
//! near linear, so each is computed, alone and beside the best linear effect.

use std::sync::Arc;

use nalgebra::DVector;

use super::criteria;
use super::dictionary::Dictionary;
use super::hypothesis::{Term, effect_terms, sorted};
use super::problem::{Fit, Problem, Proposal, Rewire, stacked_residual};
use crate::lsq::factor_normal;
use crate::threads::each_long;

pub fn proposals(problem: &Problem, dictionary: &Dictionary) -> Vec<Proposal> {
    let context = &problem.first.context;
    let with_best = each_long(faults(problem), |fault| {
        let own = std::slice::from_ref(&fault);
        let residual = residual(problem, None, &fault);
        let left = problem.project_out_one(&problem.nuisance, &residual);
        let penalty = problem.penalty(own);
        let predicted_score = residual.dot(&left) + penalty;
        if !predicted_score.is_finite() {
            return None;
        }
        let gains = dictionary.gains_of(&residual);
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
            terms: vec![fault],
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
pub fn beside(problem: &Problem, parent: &Fit) -> Vec<Proposal> {
    let context = &problem.first.context;
    let masses = problem.masses(&parent.terms);
    let own = parent.slopes();
    let factor = factor_normal(own.tr_mul(&problem.project_out(masses, &own)));
    let further = faults(problem).filter(|fault| !parent.terms.contains(fault));
    let proposals = each_long(further, |fault| {
        let residual = residual(problem, Some(parent), &fault);
        let left = problem.project_out_one(masses, &residual);
        let pull = own.tr_mul(&left);
        let gain = factor.as_ref().map_or(0.0, |f| pull.dot(&f.solve(&pull)));
        let penalty = problem.penalty(std::slice::from_ref(&fault));
        let predicted_score = residual.dot(&left) - gain + parent.penalty + penalty;
        predicted_score.is_finite().then(|| Proposal {
            terms: sorted(context, &[parent.terms.as_slice(), &[fault]].concat()),
            predicted_score,
            parent: Some(parent.clone()),
        })
    });
    let mut proposals: Vec<Proposal> = proposals.into_iter().flatten().collect();
    proposals.sort_by(|a, b| a.predicted_score.total_cmp(&b.predicted_score));
    proposals.truncate(criteria::WIRING_BESIDE_PARENT);
    proposals
}

/// Effects without unknowns.
fn faults<'p>(problem: &'p Problem) -> impl Iterator<Item = Term> + 'p {
    let context = &problem.first.context;
    let all = effect_terms(context).into_iter();
    all.filter(|term| term.unknowns(context) == 0)
}

/// Whitened residuals of all rows under a fault beside a hypothesis.
fn residual(problem: &Problem, parent: Option<&Fit>, fault: &Term) -> DVector<f64> {
    let (terms, unknowns) = parent.map_or((&[][..], &[][..]), |fit| (&fit.terms, &fit.unknowns));
    let contexts = problem.posture_contexts(parent);
    let rewired = problem.blocks().map(|block| {
        let own = problem.carried(block, std::slice::from_ref(fault));
        block.rewired(&own.terms)
    });
    let (q, rewires): (Vec<Vec<f64>>, Vec<Rewire>) = rewired.unzip();
    let mut predicted = problem.predict(terms, unknowns, &contexts, Some(&q));
    for ((on, block), rewire) in predicted.iter_mut().zip(problem.blocks()).zip(&rewires) {
        on.residual = Arc::new(block.residual(&rewire.readings(&on.predicted)));
    }
    stacked_residual(predicted.iter())
}
