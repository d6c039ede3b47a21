//! The search for what is missing.
//!
//! Forward, with several hypotheses kept alive, at least one of each family:
//! linear screening ranks what to add, a joint nonlinear fit of all unknowns
//! decides. Pairs are ranked together from the start, since one effect often
//! takes the part of two. Earlier steps are re-examined: drop one, replace one.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::DVector;
use sesc_model::effects::Stage;
use sesc_model::tape::Tape;

use super::criteria;
use super::dictionary::{Candidate, Dictionary};
use super::functions::Functions;
use super::hypothesis::{Term, compatible, keep_some, sorted};
use super::nuisance::Nuisance;
use super::outliers::Outliers;
use super::problem::{Fit, Problem, Proposal, run_alone, stacked_residual, stacked_slopes};
use crate::Error;
use crate::health::wirings;
use crate::lsq::factor_normal;
use crate::threads::{each_long, processors};
use crate::watch::{Watch, tell};

/// Whether functions beyond the list are tried: while nobody knows how long noise lasts, they
/// would explain it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beyond {
    Tried,
    Left,
}

/// Fitted hypotheses.
pub(super) struct Search<'m> {
    pub problem: Arc<Problem<'m>>,
    known: HashMap<Vec<Term>, Fit>,
    base: Dictionary,
    functions: Functions,
    /// χ² that each effect of ordinary size would have in this log.
    pub visible: Vec<(Term, f64)>,
    /// Hypotheses fitted so far.
    pub fitted: usize,
}

impl<'m> Search<'m> {
    pub(super) fn new(mut problem: Problem<'m>) -> Self {
        let base = Dictionary::new(&problem, None);
        let functions = Functions::new(&problem, &base);
        problem.functions = functions.tried();
        let visible = base.visible(&problem);
        problem.weigh_targets(&visible);
        let null = problem.fit(&[], None);
        problem.prices.extend(base.price_of_offset(&null, &problem));
        Search {
            problem: Arc::new(problem),
            known: HashMap::new(),
            base,
            functions,
            visible,
            fitted: 0,
        }
    }

    /// The fit of no effect, and the best fits of one, at most so many, whichever the search looked
    /// at: beside masses that are off CAD where these alone explain the log better than any effect.
    pub(super) fn alone(&mut self, most: usize) -> (Fit, Vec<Fit>) {
        let none = self.fit(&[], None);
        let alone = self.beside(&none, most);
        let by_effects = alone.iter().map(Fit::score).fold(none.score(), f64::min);
        if self.problem.is_wider() {
            let masses = self.fit(&[Term::Masses], Some(&none));
            if masses.score() < by_effects {
                let beside = self.beside(&masses, most);
                return (masses, beside);
            }
        }
        (none, alone)
    }

    /// The best fits of a hypothesis with one effect more.
    fn beside(&mut self, parent: &Fit, most: usize) -> Vec<Fit> {
        let adds_effect = |proposal: &Proposal| {
            let mut added = proposal.terms.iter();
            added.all(|term| parent.terms.contains(term) || term.effect().is_some())
        };
        let mut proposals = self.extensions(parent, (usize::MAX, most));
        proposals.retain(adds_effect);
        let terms = proposals.iter().map(|one| one.terms.clone());
        let terms: Vec<Vec<Term>> = terms.collect();
        // Nobody stops it.
        let _ = self.refine(proposals, 1, &mut ());
        let mut all: Vec<Fit> = terms.iter().map(|terms| self.fit(terms, None)).collect();
        all.sort_by(|a, b| a.score().total_cmp(&b.score()));
        all
    }

    /// All hypotheses that were fitted, the best first.
    ///
    /// # Errors
    /// When `watch` stops the search.
    pub(super) fn run(&mut self, beyond: Beyond, watch: &mut dyn Watch) -> Result<Vec<Fit>, Error> {
        let null = self.fit(&[], None);
        let faults = faults(&self.problem);
        let mut beam = vec![null];
        for depth in 1..=criteria::TOO_MANY_EFFECTS {
            let mut proposals = Vec::new();
            for parent in &beam {
                let breadth = [criteria::LATER, criteria::FIRST][usize::from(depth == 1)];
                proposals.extend(self.extensions(parent, breadth));
            }
            if depth > 1 {
                // Wiring faults also occur together, and leave large gaps.
                let large = criteria::WIRING_CHI2 * 2.0 * self.problem.data().len() as f64;
                let gaps = beam.iter().filter(|f| f.objective > large);
                let further = gaps
                    .take(criteria::WIRING_BESIDE.0)
                    .flat_map(|f| wirings_beside(&self.problem, f, &faults));
                proposals.extend(further);
            }
            if depth == 1 {
                proposals.extend(self.pairs(&beam[0]));
                proposals.extend(wirings_alone(&self.problem, &self.base, &faults));
            }
            self.refine(proposals, depth, watch)?;
            beam = self.beam(depth);
            let with = |count: usize| self.least_score(|fit| fit.terms.len() == count);
            if with(depth) >= with(depth - 1) && with(depth + 1) >= with(depth - 1) {
                break;
            }
        }
        self.reexamine_all(watch)?;
        if beyond == Beyond::Tried && self.look_beyond(watch)? {
            self.reexamine_all(watch)?;
        }
        Ok(self.ranked())
    }

    /// Functions beyond the list, beside nothing and beside the best; whether they do better.
    fn look_beyond(&mut self, watch: &mut dyn Watch) -> Result<bool, Error> {
        let first = self.best_score();
        for _ in 0..criteria::TOO_MANY_EFFECTS {
            let before = self.best_score();
            let mut parents = vec![self.fit(&[], None)];
            let best = self.ranked().into_iter();
            let best = best.filter(|fit| !fit.terms.is_empty());
            parents.extend(best.take(criteria::functions::BESIDE));
            let mut proposals = self.functions.proposals(&parents, &self.problem);
            let composed = |fit: &&Fit| fit.terms.iter().any(Term::is_composed);
            for parent in parents.iter().filter(composed) {
                proposals.extend(self.extensions(parent, criteria::LATER));
            }
            self.refine(proposals, 2, watch)?;
            if self.best_score() >= before - 1e-6 {
                break;
            }
        }
        Ok(self.best_score() < first - 1e-6)
    }

    fn reexamine_all(&mut self, watch: &mut dyn Watch) -> Result<(), Error> {
        for _ in 0..criteria::EXAMINED {
            let before = self.best_score();
            self.reexamine(watch)?;
            if self.best_score() >= before - 1e-6 {
                break;
            }
        }
        Ok(())
    }

    pub(super) fn ranked(&self) -> Vec<Fit> {
        let mut all: Vec<Fit> = self.known.values().cloned().collect();
        // Ties go to the fewest, then to the order of the list.
        let context = self.problem.context();
        let ranks = |fit: &Fit| fit.terms.iter().map(|term| term.rank(context)).collect();
        all.sort_by(|a, b| {
            let score = a.score().total_cmp(&b.score());
            score
                .then(a.terms.len().cmp(&b.terms.len()))
                .then_with(|| Vec::cmp(&ranks(a), &ranks(b)))
        });
        all
    }

    fn least_score(&self, counts: impl Fn(&&Fit) -> bool) -> f64 {
        let fits = self.known.values().filter(counts);
        fits.map(Fit::score).fold(f64::INFINITY, f64::min)
    }

    fn best_score(&self) -> f64 {
        self.least_score(|_| true)
    }

    /// Fit a set of terms once.
    pub(super) fn fit(&mut self, terms: &[Term], parent: Option<&Fit>) -> Fit {
        let terms = sorted(self.problem.context(), terms);
        if let Some(fit) = self.known.get(&terms) {
            return fit.clone();
        }
        let fit = self.problem.fit(&terms, parent);
        self.learn(fit.clone());
        fit
    }

    fn learn(&mut self, fit: Fit) {
        self.fitted += 1;
        self.known.insert(fit.terms.clone(), fit);
    }

    /// What could be added to a hypothesis, so many of each kind and of all, with its predicted
    /// score.
    fn extensions(&self, parent: &Fit, (per_kind, most): (usize, usize)) -> Vec<Proposal> {
        let is_wiring = |term: &Term| term.stage() == Some(Stage::Wiring);
        let rewired = parent.terms.iter().any(is_wiring);
        let rewired =
            rewired.then(|| Dictionary::new(&self.problem, Some(&self.problem.bent(parent))));
        let dictionary = rewired.as_ref().unwrap_or(&self.base);
        let gains = dictionary.gains(parent, &self.problem);
        let candidates = dictionary.candidates.iter().zip(gains);
        let candidates = candidates.filter(|(c, _)| compatible(&parent.terms, &c.term));
        let proposals = candidates.map(|(c, gain)| self.problem.propose(parent, &c.term, -gain));
        let mut proposals: Vec<Proposal> = proposals.collect();
        proposals.sort_by(Proposal::order);
        let added = |p: &Proposal| {
            let added = p.terms.iter().find(|i| !parent.terms.contains(i));
            added.map_or("", Term::name)
        };
        keep_some(&mut proposals, added, per_kind, most);
        let models = [
            (Term::Outliers, Some(self.with_outliers(parent))),
            (Term::Masses, self.with_masses(parent)),
        ];
        for (term, change) in models {
            if compatible(&parent.terms, &term) {
                proposals.extend(change.map(|change| self.problem.propose(parent, &term, change)));
            }
        }
        proposals
    }

    /// Change of the objective of a hypothesis beside outliers.
    fn with_outliers(&self, parent: &Fit) -> f64 {
        let residual = self.problem.first().readings_of(&parent.blocks[0]);
        let outliers = Outliers::of(residual, None);
        let root = outliers.root_weights(None);
        let squares = residual.iter().zip(&root).map(|(e, w)| (e * w).powi(2));
        let mixture = outliers.objective(residual, None, squares.sum());
        mixture - DVector::from_column_slice(residual).norm_squared()
    }

    /// Change of the objective of a hypothesis beside masses within other tolerances; none where
    /// these are as free already.
    fn with_masses(&self, parent: &Fit) -> Option<f64> {
        let masses = |terms| self.problem.masses(terms);
        let (wide, tight) = (masses(&[Term::Masses]), masses(&[]));
        let residual = parent.residual();
        let left = |n: &Nuisance| residual.dot(&n.project_out_one(&residual));
        let change = || left(wide) + wide.log_det - left(tight) - tight.log_det;
        self.problem.is_wider().then(change)
    }

    /// The best pairs of a linear search over all of them.
    fn pairs(&self, null: &Fit) -> Vec<Proposal> {
        let residual = null.residual();
        let candidates = &self.base.candidates;
        let penalty = |c: &Candidate| self.problem.penalty(std::slice::from_ref(&c.term));
        let penalties: Vec<f64> = candidates.iter().map(penalty).collect();
        let mut pairs = Vec::new();
        self.base.pairs(&self.problem, &residual, |i, j, gain| {
            if candidates[i].term.is_compatible(&candidates[j].term) {
                pairs.push((null.score() - gain + penalties[i] + penalties[j], i, j));
            }
        });
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let names = |&(_, i, j): &(f64, usize, usize)| {
            let mut names = [i, j].map(|k| candidates[k].term.name());
            names.sort_unstable();
            names
        };
        keep_some(&mut pairs, names, criteria::FIRST.0, criteria::PAIRS);
        let pairs = pairs.into_iter().map(|(predicted_score, i, j)| Proposal {
            terms: [i, j].map(|k| candidates[k].term.clone()).to_vec(),
            predicted_score,
            parent: None,
        });
        pairs.collect()
    }

    fn refine(
        &mut self,
        mut proposals: Vec<Proposal>,
        depth: usize,
        watch: &mut dyn Watch,
    ) -> Result<(), Error> {
        proposals.sort_by(Proposal::order);
        // A linear prediction is hardly ever too modest, but where gaps are large.
        let is_hopeless = |proposal: &Proposal, best: f64| {
            let (least, part) = criteria::HOPELESS;
            let room = least + part * best.abs();
            depth > 1 && proposal.predicted_score > best + room
        };
        let mut waiting = proposals.into_iter();
        loop {
            let best = self.best_score();
            let mut next: Vec<(Vec<Term>, Proposal)> = Vec::new();
            while next.len() < processors()
                && let Some(proposal) = waiting.next()
            {
                let terms = sorted(self.problem.context(), &proposal.terms);
                let is_known = self.known.contains_key(&terms)
                    || next.iter().any(|(others, _)| *others == terms);
                if !is_known && !is_hopeless(&proposal, best) {
                    next.push((terms, proposal));
                }
            }
            if next.is_empty() {
                return Ok(());
            }
            let problem = &*self.problem;
            let fits = each_long(&next, |(terms, proposal)| {
                problem.fit(terms, proposal.parent.as_ref())
            });
            // As if one had been fitted after the other: what those before it made hopeless
            // is not known.
            for ((_, proposal), fit) in next.into_iter().zip(fits) {
                if !is_hopeless(&proposal, self.best_score()) {
                    self.learn(fit);
                    tell(watch, "hypotheses", self.fitted as u64, None)?;
                }
            }
        }
    }

    /// The best of a depth, one of each family before seconds.
    fn beam(&self, depth: usize) -> Vec<Fit> {
        let mut beam = self.ranked();
        beam.retain(|fit| fit.terms.len() == depth);
        let family = |fit: &Fit| {
            let mut names: Vec<&str> = fit.terms.iter().map(Term::name).collect();
            names.sort_unstable();
            names
        };
        keep_some(&mut beam, family, criteria::BEAM.0, criteria::BEAM.1);
        beam
    }

    /// Drop one, replace one, of the best hypotheses; of the very best, by
    /// everything that comes near it.
    fn reexamine(&mut self, watch: &mut dyn Watch) -> Result<(), Error> {
        let null = self.fit(&[], None);
        let alone = self.extensions(&null, criteria::NEAR);
        self.refine(alone, 2, watch)?;
        let best: Vec<Fit> = self.ranked().into_iter().take(criteria::EXAMINED).collect();
        for (place, fit) in best.iter().enumerate() {
            for k in 0..fit.terms.len() {
                let parent = self.fit(&fit.terms_without(k), Some(fit));
                let breadth = [criteria::LATER, criteria::NEAR][usize::from(place == 0)];
                let proposals = self.extensions(&parent, breadth);
                self.refine(proposals, 2, watch)?;
            }
        }
        Ok(())
    }
}

/// Wiring faults, fitted by full evaluation: signs, swaps, units, axes. None of them is near linear,
/// so each is computed, alone and beside the best linear effect.
fn wirings_alone(problem: &Problem, dictionary: &Dictionary, faults: &[Term]) -> Vec<Proposal> {
    let proposal = |terms: &[&Term], predicted_score: f64| Proposal {
        terms: terms.iter().map(|term| (*term).clone()).collect(),
        predicted_score,
        parent: None,
    };
    let penalty = |term: &Term| problem.penalty(std::slice::from_ref(term));
    let with_best = tried(problem, None, faults, |fault, chi2, left| {
        let alone = chi2 + penalty(fault);
        let beside = dictionary.candidates.iter().zip(dictionary.gains_of(left));
        let beside = beside.map(|(Candidate { term, .. }, gain)| {
            proposal(&[fault, term], alone - gain + penalty(term))
        });
        (proposal(&[fault], alone), beside.min_by(Proposal::order))
    });
    let (mut alone, beside): (Vec<_>, Vec<_>) = with_best.into_iter().unzip();
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
fn wirings_beside(problem: &Problem, parent: &Fit, faults: &[Term]) -> Vec<Proposal> {
    let further = faults.iter().filter(|fault| !parent.terms.contains(fault));
    let mut proposals = tried(problem, Some(parent), further, |fault, chi2, _| {
        problem.propose(parent, fault, chi2 - parent.objective)
    });
    proposals.sort_by(Proposal::order);
    proposals.truncate(criteria::WIRING_BESIDE.1);
    proposals
}

/// Effects without unknowns; of very many in a long log those that come first on some of its
/// postures: a chain of 100 joints has 5000 pairs of encoders that may be exchanged.
fn faults(problem: &Problem) -> Vec<Term> {
    let all = wirings::faults(problem.context()).into_iter();
    let all: Vec<Term> = all.map(Term::Effect).collect();
    let postures: usize = problem.blocks.iter().map(|block| block.data.len()).sum();
    let every = (all.len() * postures).div_ceil(criteria::WIRING_WORK);
    if every < 2 {
        return all;
    }
    let some = problem.thinned(every);
    let mut scored = tried(&some, None, &all, |fault, chi2, _| (fault.clone(), chi2));
    scored.sort_by(|a, b| a.1.total_cmp(&b.1));
    scored.truncate(criteria::WIRING_WORK / postures);
    scored.into_iter().map(|(fault, _)| fault).collect()
}

/// What `of` makes of each fault beside a hypothesis, of its χ² and of what of its residuals is no
/// mass error; unknowns stay, but for what a linear step of theirs takes of χ².
fn tried<'f, T: Send>(
    problem: &Problem,
    parent: Option<&Fit>,
    faults: impl IntoIterator<Item = &'f Term>,
    of: impl Fn(&'f Term, f64, &DVector<f64>) -> T + Sync,
) -> Vec<T> {
    let (terms, unknowns) = parent.map_or((&[][..], &[][..]), |fit| {
        (&fit.terms[..], &fit.unknowns[..])
    });
    let (masses, contexts) = (problem.masses(terms), problem.posture_contexts(parent));
    let predicted = problem.predict(terms, unknowns, &contexts, None);
    let own = stacked_slopes(&predicted, unknowns.len());
    let left_of_own = problem.project_out(masses, &own);
    let factor = factor_normal(own.tr_mul(&left_of_own));
    let found = each_long(faults, |fault| {
        let rewired = problem.blocks.iter().map(|block| {
            let own = problem.carried(block, std::slice::from_ref(fault), &[]);
            block.rewired(&own.terms)
        });
        let (q, rewires): (Vec<Vec<f64>>, Vec<Option<Tape>>) = rewired.unzip();
        let mut predicted = problem.predict(terms, unknowns, &contexts, Some(&q));
        for ((on, block), rewire) in predicted.iter_mut().zip(&problem.blocks).zip(&rewires) {
            if let Some(tape) = rewire {
                let readings = run_alone(tape, &block.predicted(on), block.data.len());
                block.put_readings(&readings, on);
            }
        }
        let residual = stacked_residual(&predicted);
        let left = problem.project_out_one(masses, &residual);
        let pull = left_of_own.tr_mul(&residual);
        let gain = factor.as_ref().map_or(0.0, |f| pull.dot(&f.solve(&pull)));
        let chi2 = residual.dot(&left) - gain;
        chi2.is_finite().then(|| of(fault, chi2, &left))
    });
    found.into_iter().flatten().collect()
}
