//! Hypotheses about the logs of one robot: what they predict, and what they cost.
//!
//! ```text
//! −2 log p(y | e) = eᵀ S e + log det A       e: residuals of all blocks, whitened, one below
//!                                            the other; S, A: see `nuisance`
//! ```
//!
//! Blocks share the robot's masses, which are marginalised once for all of them, and the unknowns
//! of effects. The first block is the log that is reported; further ones are of experiments.

pub(super) mod backlash_sides;
mod block;
mod fitting;

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DMatrixView, DVector};
use sesc_model::effects::EffectContext;

use super::criteria;
use super::hypothesis::{self, CarriedExplanation, Term, carried, with_places};
use super::nuisance::{MassPrior, Nuisance};
use super::outliers::Outliers;
use crate::fit::offset;
use crate::fit::prior::{Prior, Tolerances};
use crate::lsq::factor_normal;
use crate::lsq::solve::Beyond;
use crate::observations::correlation::Correlation;
use crate::observations::postures::Postures;

use crate::svd::svd;
pub(super) use block::{Block, InFile, OwnSides, Untold};
pub(super) use block::{run_alone, side, soles_of, tilts};
pub(super) use fitting::Weighting;

/// Logs of a robot, and the prior of its masses.
#[derive(Clone)]
pub(super) struct Problem<'m> {
    /// The log that is reported, then those of experiments.
    pub blocks: Vec<Block<'m>>,
    /// What is known of masses before the logs: the prior that was asked for, and the usual
    /// tolerances of CAD, for `mass_distribution`.
    priors: [MassPrior; 2],
    /// Share of the chance of each effect of the list at its target.
    target_weights: HashMap<Term, f64>,
    /// How many kinds of effects there are, and of what is no effect.
    kinds: usize,
    /// What terms cost that have a prior of their own.
    pub prices: HashMap<Term, f64>,
    /// Deviations that an offset of readings may have before the data, m.
    pub offset_stds: Vec<f64>,
    /// How many functions beyond the list are tried.
    pub functions: usize,
    /// Masses are known as tolerances of CAD alone.
    pub masses_are_cad: bool,
    /// Postures of the first block that count in a fit; all of them unless given.
    pub kept: Option<Vec<bool>>,
}

/// A hypothesis to be fitted.
pub(super) struct Proposal {
    pub terms: Vec<Term>,
    /// Score to first order.
    pub predicted_score: f64,
    pub parent: Option<Fit>,
}

impl Proposal {
    /// The most promising first.
    pub(super) fn order(&self, other: &Proposal) -> std::cmp::Ordering {
        self.predicted_score.total_cmp(&other.predicted_score)
    }
}

/// A hypothesis, fitted.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub terms: Vec<Term>,
    pub unknowns: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// −2 log evidence without the penalty, less a constant: χ² with masses
    /// marginalised, walls, sides and outliers paid for.
    pub objective: f64,
    /// What its unknowns and the search cost.
    pub penalty: f64,
    /// What it predicts of each block.
    pub blocks: Vec<OnBlock>,
    /// Outliers are among the readings of the first block.
    pub outliers: Option<Outliers>,
    /// Base parameters (m) that it is stated with, where they are not those that its
    /// residuals suggest: the problem is then about them.
    pub masses: Option<Vec<f64>>,
}

/// What a hypothesis predicts of a block.
#[derive(Debug, Clone)]
pub(super) struct OnBlock {
    /// Whitened residuals (reading − predicted)/σ and, below them, those of the soles, where the
    /// log is of both feet.
    pub residual: Arc<DVector<f64>>,
    /// Whitened derivative of the same rows by the unknowns of all blocks.
    pub slopes: Arc<DMatrix<f64>>,
    /// On which side joints rest, where dead bands matter.
    pub sides: Option<OwnSides>,
    /// Postures with a joint on the side of its dead band that gravity does not favour.
    pub flipped: Vec<usize>,
}

impl Fit {
    /// Smaller is better.
    pub(super) fn score(&self) -> f64 {
        self.objective + self.penalty
    }

    /// What was found of one of its terms.
    pub(super) fn unknowns_of(&self, context: &EffectContext, wanted: &Term) -> Option<&[f64]> {
        let mut all = with_places(&self.terms, context);
        let (_, own) = all.find(|(term, _)| *term == wanted)?;
        Some(&self.unknowns[own])
    }

    /// Its terms but for one.
    pub(super) fn terms_without(&self, place: usize) -> Vec<Term> {
        let mut terms = self.terms.clone();
        terms.remove(place);
        terms
    }

    /// Whether a joint has a dead band.
    pub(super) fn is_loose(&self) -> bool {
        self.terms.iter().any(|term| term.dead_band().is_some())
    }

    /// Whether masses are identified within the usual tolerances of CAD.
    pub(super) fn frees_masses(&self) -> bool {
        self.terms.contains(&Term::Masses)
    }

    /// Whitened residuals of all rows.
    pub(super) fn residual(&self) -> DVector<f64> {
        stacked_residual(&self.blocks)
    }

    /// Whitened slopes of all rows.
    pub(super) fn slopes(&self) -> DMatrix<f64> {
        stacked_slopes(&self.blocks, self.unknowns.len())
    }
}

/// Whitened residuals of all rows, block by block.
pub(super) fn stacked_residual(blocks: &[OnBlock]) -> DVector<f64> {
    let rows = blocks.iter().flat_map(|own| own.residual.iter().copied());
    DVector::from_vec(rows.collect())
}

/// The same of slopes by so many unknowns.
pub(super) fn stacked_slopes(blocks: &[OnBlock], unknowns: usize) -> DMatrix<f64> {
    let parts = blocks.iter().map(|own| own.slopes.as_view());
    below(&parts.collect::<Vec<_>>(), unknowns)
}

impl<'m> Problem<'m> {
    /// Logs of the robot, the first of which is reported.
    pub(super) fn new(blocks: Vec<Block<'m>>, prior: &Prior) -> Problem<'m> {
        let model = blocks[0].model;
        let p = model.base.params.len();
        let known = |prior: &Prior| {
            let (factor, beyond) = match prior {
                Prior::Free => {
                    let rows: Vec<_> = blocks.iter().map(Block::rows_of_first).collect();
                    let rows: Vec<_> = rows.iter().map(DMatrix::as_view).collect();
                    (Some(free(&below(&rows, p))), Beyond::Nothing)
                }
                held => (held.covariance_factor(model), Beyond::Exact),
            };
            let mut factor = factor.unwrap_or_else(|| DMatrix::zeros(p, 0));
            let is_weighed = blocks.iter().any(|block| block.weighed.is_some());
            if is_weighed {
                // The last direction is the total mass, of which no CoP knows.
                let directions = factor.ncols();
                factor = factor.insert_column(directions, 0.0);
            }
            MassPrior {
                factor,
                total: is_weighed.then(|| prior.tolerances().of_total(model)),
                beyond,
                nuisance: Arc::default(),
            }
        };
        let terms = hypothesis::effect_terms(&blocks[0].context);
        let mut targets: HashMap<&str, f64> = HashMap::new();
        for term in &terms {
            *targets.entry(term.name()).or_default() += 1.0;
        }
        let share = |term: &Term| (term.clone(), 1.0 / targets[term.name()]);
        let mut problem = Problem {
            kinds: targets.len() + hypothesis::MODEL_PAGES.len(),
            target_weights: terms.iter().map(share).collect(),
            functions: 0,
            kept: None,
            masses_are_cad: matches!(prior, Prior::Cad(_)),
            priors: [known(prior), known(&Prior::Cad(Tolerances::usual()))],
            prices: HashMap::new(),
            offset_stds: offset::STD_M.to_vec(),
            blocks,
        };
        problem.weigh();
        problem
    }

    /// The log that is reported.
    pub(super) fn first(&self) -> &Block<'m> {
        &self.blocks[0]
    }

    /// The robot of that log, as effects see it.
    pub(super) fn context(&self) -> &EffectContext<'m> {
        &self.first().context
    }

    /// Its postures.
    pub(super) fn data(&self) -> &Postures {
        &self.first().data
    }

    /// Places of each block's readings among all rows.
    pub(super) fn readings(&self) -> impl Iterator<Item = Range<usize>> {
        let mut at = 0;
        self.blocks.iter().map(move |block| {
            let from = at;
            at += block.height();
            from..from + 2 * block.data.len()
        })
    }

    /// Rows of all blocks.
    pub(super) fn height(&self) -> usize {
        self.blocks.iter().map(Block::height).sum()
    }

    /// `terms` with their unknowns as this block has them.
    pub(super) fn carried(
        &self,
        block: &Block,
        terms: &[Term],
        unknowns: &[f64],
    ) -> CarriedExplanation {
        let contexts = (self.context(), &block.context);
        carried(block.experiment, contexts, (terms, unknowns))
    }

    /// Rows per independent one, of the block and axis that have fewest.
    pub(super) fn rows_per_sample(&self) -> f64 {
        let of_blocks = self.blocks.iter().map(Block::rows_per_sample);
        of_blocks.fold(1.0, f64::max)
    }

    /// The noise of each axis of a block is `factors` times as large, and its readings are not
    /// independent: `correlation` says how many rows one is worth, and how far deviations of
    /// unknowns are from those of noise that is as slow as whatever they explain.
    pub(super) fn correlate_noise(
        &mut self,
        block: usize,
        factors: [f64; 2],
        correlation: &[Correlation; 2],
    ) {
        let own = &mut self.blocks[block];
        own.data.scale_noise(factors);
        own.widened = correlation.map(|axis| axis.rows_per_sample.sqrt());
        for (row, std) in own.data.std.iter_mut().enumerate() {
            *std *= own.widened[row % 2];
        }
        own.lasting = correlation.map(|axis| axis.process);
        self.weigh();
    }

    /// Take the noise of each axis of the first block from what is `left` of its readings, m, by
    /// that which took up `taken` of them.
    pub(super) fn take_noise(&mut self, left: &[f64], taken: f64) {
        self.blocks[0].data.take_noise(left, taken);
        self.weigh();
    }

    /// Readings count by their deviations.
    fn weigh(&mut self) {
        for block in &mut self.blocks {
            block.weight = block.data.std.iter().map(|s| 1.0 / s).collect();
        }
        let rows = self.whitened_rows();
        let of = |prior: &MassPrior| {
            let mut k = &rows * &prior.factor;
            let mut at = 0;
            for block in &self.blocks {
                at += block.height();
                if let (Some([_, std]), Some(total)) = (block.weighed, prior.total) {
                    k[(at - 1, prior.factor.ncols() - 1)] = total / std;
                }
            }
            Arc::new(Nuisance::of(k))
        };
        let [asked, usual] = &self.priors;
        let own = of(asked);
        let wide = match usual.factor == asked.factor && usual.total == asked.total {
            true => Arc::clone(&own),
            false => of(usual),
        };
        let [asked, usual] = &mut self.priors;
        (asked.nuisance, usual.nuisance) = (own, wide);
    }

    /// Whitened derivative of all rows by the base parameters; masses move no sole.
    pub(super) fn whitened_rows(&self) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(self.height(), self.priors[0].factor.nrows());
        for (block, range) in self.blocks.iter().zip(self.readings()) {
            let mut own = block.rows_of_first();
            for (mut row, weight) in own.row_iter_mut().zip(&block.weight) {
                row *= *weight;
            }
            all.rows_mut(range.start, range.len()).copy_from(&own);
        }
        all
    }

    /// What `fit` and free masses leave of the first block's readings, m, and how many of these
    /// they take up: free masses alone leave what the fit explains, too.
    pub(super) fn left_beside_masses(&self, fit: &Fit) -> (Vec<f64>, f64) {
        let (first, own) = (self.first(), &fit.blocks[0]);
        let n = first.weight.len();
        let left = DVector::from_fn(n, |row, _| own.residual[row] / first.weight[row]);
        let (p, unknowns) = (first.rows.ncols(), own.slopes.ncols());
        // Unknowns come in all units.
        let slopes = own.slopes.rows(0, n);
        let sizes = slopes.column_iter().map(|c| c.norm().max(1e-30));
        let sizes: Vec<f64> = sizes.collect();
        let columns = DMatrix::from_fn(n, p + unknowns, |row, c| match c.checked_sub(p) {
            None => first.rows[(row, c)],
            Some(c) => slopes[(row, c)] / first.weight[row] / sizes[c],
        });
        without(&columns, left)
    }

    /// The same robot with other `blocks`: further ones, or the same about other masses.
    pub(super) fn about(&self, blocks: Vec<Block<'m>>) -> Problem<'m> {
        let mut own = Problem {
            blocks,
            ..self.clone()
        };
        own.weigh();
        own
    }

    /// The same with about every so many-th posture of each block, readings alone.
    pub(super) fn thinned(&self, every: usize) -> Problem<'m> {
        let blocks = self.blocks.iter().map(|block| {
            let n = block.data.len();
            let every = every.min(n / criteria::WIRING_POSTURES).max(1);
            block.some(&(0..n).map(|k| k % every == 0).collect::<Vec<_>>())
        });
        self.about(blocks.collect())
    }

    /// Independent readings of all logs, and rows of soles.
    fn independent(&self) -> f64 {
        let of = |block: &Block| {
            let rows = block.data.len() as f64;
            let readings = block.widened.map(|factor| rows / (factor * factor));
            block.height() as f64 - 2.0 * rows + readings[0] + readings[1]
        };
        let all: f64 = self.blocks.iter().map(of).sum();
        all.max(std::f64::consts::E)
    }

    /// What unknowns and the number of things that were looked at cost:
    /// `Σ p ln 2N + 2 ln(kinds / w_target)`, see [`Problem::weigh_targets`]; N counts independent
    /// samples. An offset of readings costs no more than its own prior makes it cost.
    pub(super) fn penalty(&self, terms: &[Term]) -> f64 {
        let readings = self.independent();
        let of = |term: &Term| {
            let weight = match (term.effect(), self.target_weights.get(term)) {
                (Some(function), None) => {
                    return self.penalty_of_function(function.unknowns(self.context()));
                }
                (_, own) => own.copied().unwrap_or(1.0),
            };
            let unknowns = term.penalised_unknowns(self.context());
            let kinds = self.kinds as f64;
            let searched = unknowns as f64 * readings.ln() + 2.0 * (kinds / weight).ln();
            let own = self.prices.get(term).copied();
            own.map_or(searched, |own| own.min(searched))
        };
        terms.iter().map(of).sum()
    }

    /// What a function beyond the list costs, of so many unknowns: `p ln 2N + 2 ln K`, K the number
    /// tried, and that it is less plain than an effect of the list.
    pub(super) fn penalty_of_function(&self, unknowns: usize) -> f64 {
        let searched = 2.0 * (self.functions.max(1) as f64).ln();
        unknowns as f64 * self.independent().ln() + searched + criteria::functions::UNNAMED
    }

    /// A hypothesis with one term more, which changes its objective, to first order.
    pub(super) fn propose(&self, parent: &Fit, term: &Term, change: f64) -> Proposal {
        let own = std::slice::from_ref(term);
        Proposal {
            terms: [&parent.terms[..], own].concat(),
            predicted_score: parent.score() + change + self.penalty(own),
            parent: Some(parent.clone()),
        }
    }

    /// Share the chance of each effect among its targets by how well the logs
    /// see them: `visible` is χ² of an effect of ordinary size at each.
    ///
    /// A fault in an elbow that explains what an ankle's would has to be absurdly
    /// large. Weights of one effect sum to one, so false alarms stay as rare as
    /// with even weights.
    pub(super) fn weigh_targets(&mut self, visible: &[(Term, f64)]) {
        let chance = |chi2: f64| criteria::UNSEEN_CHANCE + (1.0 + chi2 / criteria::VISIBLE).ln();
        let mut sums: HashMap<&str, f64> = HashMap::new();
        for (term, chi2) in visible {
            *sums.entry(term.name()).or_default() += chance(*chi2);
        }
        for (term, chi2) in visible {
            let weight = chance(*chi2) / sums[term.name()];
            self.target_weights.insert(term.clone(), weight);
        }
    }

    /// What is known of masses before the logs under a hypothesis.
    pub(super) fn prior(&self, terms: &[Term]) -> &MassPrior {
        &self.priors[usize::from(terms.contains(&Term::Masses))]
    }

    /// The masses' directions under a hypothesis.
    pub(super) fn masses(&self, terms: &[Term]) -> &Nuisance {
        &self.prior(terms).nuisance
    }

    /// How rows count where some postures of the first block are outliers or left out.
    pub(super) fn weighting(&self, terms: &[Term], outliers: Option<&Outliers>) -> Weighting<'_> {
        let kept = self.kept.as_deref();
        let of_kept = |kept: &[bool]| -> Vec<f64> {
            let roots = kept.iter().flat_map(|k| [f64::from(u8::from(*k)); 2]);
            roots.collect()
        };
        let mut root = match outliers {
            Some(outliers) => Some(outliers.root_weights(kept)),
            None => kept.map(of_kept),
        };
        root.iter_mut()
            .for_each(|root| root.resize(self.height(), 1.0));
        let masses = self.masses(terms);
        Weighting {
            masses: match &root {
                Some(root) => Cow::Owned(masses.reweighted(root)),
                None => Cow::Borrowed(masses),
            },
            root,
        }
    }

    /// The most likely mass errors of a fit, in units of F's columns.
    pub(super) fn mass_errors(&self, fit: &Fit) -> DVector<f64> {
        let rows = self.weighting(&fit.terms, fit.outliers.as_ref());
        rows.masses.posterior_mean(&rows.residual(fit))
    }

    /// Base parameters of the first block at which a fit ends, m.
    pub(super) fn params_of(&self, fit: &Fit) -> Vec<f64> {
        match &fit.masses {
            Some(masses) => masses.clone(),
            None => self.moved(self.prior(&fit.terms), &self.mass_errors(fit)),
        }
    }

    /// Those that CAD's usual tolerances and the residuals of a fit suggest, m.
    pub(super) fn usual_params(&self, fit: &Fit) -> Vec<f64> {
        let usual = self.prior(&[Term::Masses]);
        self.moved(usual, &usual.nuisance.posterior_mean(&fit.residual()))
    }

    /// CAD's masses, moved by errors in units of F's columns, m.
    fn moved(&self, prior: &MassPrior, errors: &DVector<f64>) -> Vec<f64> {
        let shift = &prior.factor * errors;
        let cad = self.first().cad.iter().zip(shift.iter());
        cad.map(|(r, d)| r + d).collect()
    }

    /// Whitened shift of all rows by the mass errors that the residuals of `fit` suggest, or
    /// by those that it is stated with; outliers count as all readings do.
    pub(super) fn mass_shift(&self, fit: &Fit) -> DVector<f64> {
        if fit.masses.is_some() {
            let mut all = DVector::zeros(self.height());
            for (block, range) in self.blocks.iter().zip(self.readings()) {
                if let Some(offset) = &block.offset {
                    all.rows_mut(range.start, range.len()).copy_from(offset);
                }
            }
            return all;
        }
        let masses = self.masses(&fit.terms);
        masses.shift(&masses.posterior_mean(&fit.residual()))
    }

    /// The same shift by rows that count as they do in a fit.
    pub(super) fn mass_shift_of(&self, fit: &Fit) -> DVector<f64> {
        self.masses(&fit.terms).shift(&self.mass_errors(fit))
    }

    /// Whether the usual tolerances of CAD leave masses more room than the prior.
    pub(super) fn is_wider(&self) -> bool {
        self.masses(&[Term::Masses]).log_det > self.masses(&[]).log_det
    }

    /// What of stacked columns is neither a mass error nor common to all soles of a log.
    pub(super) fn project_out(&self, masses: &Nuisance, stacked: &DMatrix<f64>) -> DMatrix<f64> {
        let mut left = masses.project_out(stacked);
        for (block, range) in self.blocks.iter().zip(self.readings()) {
            if let Some(closure) = &block.closure {
                let mut own = left.rows_mut(range.end, block.soles());
                let rest = closure.without_common(&own.clone_owned());
                own.copy_from(&rest);
            }
        }
        left
    }

    /// The same of one column.
    pub(super) fn project_out_one(
        &self,
        masses: &Nuisance,
        stacked: &DVector<f64>,
    ) -> DVector<f64> {
        let column = DMatrix::from_column_slice(stacked.len(), 1, stacked.as_slice());
        self.project_out(masses, &column).column(0).into_owned()
    }

    /// What is known of the postures of each block, under a fit to them where one is given.
    pub(super) fn posture_contexts(&self, fit: Option<&Fit>) -> Vec<Cow<'_, [f64]>> {
        let blocks = self.blocks.iter().enumerate();
        let sides = |at: usize| fit.and_then(|fit| fit.blocks[at].sides.as_ref());
        let contexts = blocks.map(|(at, block)| match sides(at) {
            Some(sides) => block.context_of(sides).into(),
            None => block.data.posture_context[..].into(),
        });
        contexts.collect()
    }

    /// Joint positions of every block's postures as a hypothesis bends them.
    pub(super) fn bent(&self, fit: &Fit) -> Vec<Vec<f64>> {
        let contexts = self.posture_contexts(Some(fit));
        let blocks = self.blocks.iter().zip(&contexts);
        let bent = blocks.map(|(block, context)| {
            let own = self.carried(block, &fit.terms, &fit.unknowns);
            block.bent(&own.terms, &own.unknowns, context)
        });
        bent.collect()
    }
}

/// `gap` without what the columns `rows` can take of it, and how many directions that are; all of
/// it where rows are too few to tell.
fn without(rows: &DMatrix<f64>, gap: DVector<f64>) -> (Vec<f64>, f64) {
    if rows.nrows() < 2 * rows.ncols() {
        return (gap.as_slice().to_vec(), 0.0);
    }
    let directions = free(rows);
    let seen = rows * directions;
    match factor_normal(seen.tr_mul(&seen)) {
        Some(factor) => {
            let left = &gap - &seen * factor.solve(&seen.tr_mul(&gap));
            (left.as_slice().to_vec(), seen.ncols() as f64)
        }
        None => (gap.as_slice().to_vec(), 0.0),
    }
}

/// Matrices of `columns` columns, one below the other.
pub(super) fn below(parts: &[DMatrixView<f64>], columns: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(parts.iter().map(|part| part.nrows()).sum(), columns);
    let mut at = 0;
    for part in parts {
        all.rows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    all
}

/// A prior without information: 100 m on every direction that data determine.
fn free(rows: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = svd(rows.clone(), false, true);
    let v = svd.v_t.unwrap_or_else(|| DMatrix::zeros(0, rows.ncols()));
    let largest = svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > 1e-9 * largest)
        .collect();
    let mut factor = DMatrix::zeros(rows.ncols(), kept.len());
    for (to, &from) in kept.iter().enumerate() {
        factor.set_column(to, &(v.row(from).transpose() * 100.0));
    }
    factor
}
