//! Hypotheses about the logs of one robot: what they predict, and what they cost.
//!
//! ```text
//! −2 log p(y | e) = eᵀ S e + log det A       e: residuals of all blocks, whitened, one below
//!                                            the other; S, A: see `nuisance`
//! ```
//!
//! Blocks share the robot's masses, which are marginalised once for all of them, and the unknowns
//! of effects. The first block is the log that is reported; further ones are of experiments.

pub mod backlash_sides;
mod block;
mod fitting;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::iter::once;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{self, EffectContext, EffectId, PostureContext};

use super::criteria;
use super::hypothesis::{self, CarriedExplanation, Term, carried, with_places};
use super::nuisance::Nuisance;
use super::outliers::Outliers;
use crate::fit::prior::{Prior, Tolerances};
use crate::lsq::factor_normal;
use crate::lsq::solve::Beyond;
use crate::observations::correlation::Correlation;

use crate::svd::svd;
pub(super) use block::Rewire;
pub use block::{Block, Closed, OwnSides};
pub(super) use fitting::Weighting;

/// Logs of a robot, and the prior of its masses.
#[derive(Clone)]
pub struct Problem<'m> {
    /// The log that is reported.
    pub first: Block<'m>,
    /// Logs of experiments.
    pub others: Vec<Block<'m>>,
    /// Masses within the prior that was asked for; rows are those of all blocks.
    pub nuisance: Arc<Nuisance>,
    /// Masses within the usual tolerances of CAD, for `mass_distribution`.
    wide: Arc<Nuisance>,
    /// Factor F of the prior on masses; `wide_prior` is that of the usual tolerances.
    pub prior: DMatrix<f64>,
    /// What is known of directions that `prior` has no column for.
    pub beyond_prior: Beyond,
    pub wide_prior: DMatrix<f64>,
    target_weights: HashMap<Term, f64>,
    /// How many targets each kind of effect has.
    targets: BTreeMap<EffectId, usize>,
    /// Masses are known as tolerances of CAD alone.
    pub masses_are_cad: bool,
}

/// A hypothesis to be fitted.
pub struct Proposal {
    pub terms: Vec<Term>,
    /// Score to first order.
    pub predicted_score: f64,
    pub parent: Option<Fit>,
}

/// A hypothesis, fitted.
#[derive(Debug, Clone)]
pub struct Fit {
    pub terms: Vec<Term>,
    pub unknowns: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// −2 log evidence without the penalty, less a constant: χ² with masses
    /// marginalised, walls, sides and outliers paid for.
    pub objective: f64,
    /// What its unknowns and the search cost.
    pub penalty: f64,
    /// What it predicts of the first block.
    pub first: OnBlock,
    /// The same of each further one.
    pub others: Vec<OnBlock>,
    /// Outliers are among the readings of the first block.
    pub outliers: Option<Outliers>,
    /// Walls that are touched: the answer lies at the edge of what is physical.
    pub at_bound: f64,
    /// Base parameters (m) that it is stated with, where they are not those that its
    /// residuals suggest: the problem is then about them.
    pub masses: Option<Vec<f64>>,
}

/// What a hypothesis predicts of a block.
#[derive(Debug, Clone)]
pub struct OnBlock {
    /// Readings, CAD masses, m.
    pub predicted: Arc<Vec<f64>>,
    /// Whitened residuals (reading − predicted)/σ.
    pub residual: Arc<DVector<f64>>,
    /// Whitened derivative of the readings by the unknowns of all blocks.
    pub slopes: Arc<DMatrix<f64>>,
    /// The same of the soles, where the log is of both feet.
    pub closed: Option<Closed>,
    /// Sides of dead bands, where they matter.
    pub sides: Option<OwnSides>,
    /// Postures with a joint on the side of its dead band that gravity does not favour.
    pub flipped: Vec<usize>,
}

impl Fit {
    /// Smaller is better.
    pub fn score(&self) -> f64 {
        self.objective + self.penalty
    }

    /// What was found of one of its terms.
    pub fn unknowns_of(&self, context: &EffectContext, wanted: &Term) -> Option<&[f64]> {
        let mut all = with_places(&self.terms, context);
        let (_, own) = all.find(|(term, _)| *term == wanted)?;
        Some(&self.unknowns[own])
    }

    /// Whether masses are identified within the usual tolerances of CAD.
    pub fn frees_masses(&self) -> bool {
        self.terms.contains(&Term::Masses)
    }

    /// What it predicts, block by block.
    pub fn blocks(&self) -> impl Iterator<Item = &OnBlock> + Clone {
        once(&self.first).chain(&self.others)
    }

    /// Whitened residuals of all rows.
    pub fn residual(&self) -> DVector<f64> {
        stacked_residual(self.blocks())
    }

    /// Whitened slopes of all rows.
    pub fn slopes(&self) -> DMatrix<f64> {
        stacked_slopes(self.blocks(), self.unknowns.len())
    }
}

impl OnBlock {
    fn height(&self) -> usize {
        let soles = self.closed.as_ref().map_or(0, |soles| soles.residual.len());
        self.residual.len() + soles
    }
}

/// Whitened residuals of readings and, below them, of soles, block by block.
pub(super) fn stacked_residual<'b>(blocks: impl Iterator<Item = &'b OnBlock>) -> DVector<f64> {
    let rows: Vec<f64> = blocks
        .flat_map(|own| {
            let soles = own.closed.iter().flat_map(|soles| soles.residual.iter());
            own.residual.iter().chain(soles)
        })
        .copied()
        .collect();
    DVector::from_vec(rows)
}

/// The same of slopes by so many unknowns.
pub(super) fn stacked_slopes<'b>(
    blocks: impl Iterator<Item = &'b OnBlock> + Clone,
    unknowns: usize,
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(blocks.clone().map(OnBlock::height).sum(), unknowns);
    let mut at = 0;
    let parts = blocks.flat_map(|own| {
        let soles = own.closed.iter().map(|soles| &soles.slopes);
        once(&*own.slopes).chain(soles)
    });
    for part in parts {
        all.rows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    all
}

/// How a set of readings counts in a fit.
#[derive(Clone, Copy)]
pub struct RowSelection<'a> {
    /// 1 or 0 per posture of the first block; all where `None`.
    pub keep: Option<&'a [bool]>,
}

pub const ALL: RowSelection = RowSelection { keep: None };

impl RowSelection<'_> {
    /// Root of the weight of the first block's readings; none where all count.
    pub(super) fn root(&self, outliers: Option<&Outliers>) -> Option<Vec<f64>> {
        match (outliers, self.keep) {
            (Some(outliers), keep) => Some(outliers.root_weights(keep)),
            (None, keep) => Some(
                keep?
                    .iter()
                    .flat_map(|k| [f64::from(u8::from(*k)); 2])
                    .collect(),
            ),
        }
    }
}

impl<'m> Problem<'m> {
    /// Logs of the robot, the first of which is reported.
    pub fn new(first: Block<'m>, others: Vec<Block<'m>>, prior: &Prior) -> Problem<'m> {
        let (model, p) = (first.model, first.model.base.params.len());
        let none = || DMatrix::zeros(p, 0);
        let (factor, beyond_prior) = match prior {
            Prior::Free => {
                let rows = once(&first).chain(&others).map(Block::rows_of_first);
                (free(&below(rows, p)), Beyond::Nothing)
            }
            Prior::Cad(_) | Prior::Population(_) | Prior::Fitted(_) => {
                let factor = prior.covariance_factor(model).unwrap_or_else(none);
                (factor, Beyond::Exact)
            }
        };
        let usual = Prior::Cad(Tolerances::usual()).covariance_factor(model);
        let mut targets: BTreeMap<EffectId, usize> = BTreeMap::new();
        for instance in effects::instances(&first.context) {
            *targets.entry(instance.effect.id()).or_default() += 1;
        }
        let mut problem = Problem {
            targets,
            masses_are_cad: matches!(prior, Prior::Cad(_)),
            first,
            others,
            nuisance: Arc::default(),
            wide: Arc::default(),
            prior: factor,
            beyond_prior,
            wide_prior: usual.unwrap_or_else(none),
            target_weights: HashMap::new(),
        };
        problem.weigh();
        problem
    }

    /// All blocks, the first one first.
    pub fn blocks(&self) -> impl Iterator<Item = &Block<'m>> + Clone {
        once(&self.first).chain(&self.others)
    }

    fn blocks_mut(&mut self) -> impl Iterator<Item = &mut Block<'m>> {
        once(&mut self.first).chain(&mut self.others)
    }

    /// Places of each block's readings among all rows.
    pub(super) fn readings(&self) -> impl Iterator<Item = Range<usize>> {
        let mut at = 0;
        self.blocks().map(move |block| {
            let from = at;
            at += block.height();
            from..from + 2 * block.data.len()
        })
    }

    /// Those of all rows that are of readings.
    pub(super) fn of_readings(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        let own = self
            .readings()
            .map(|range| rows.rows_range(range).into_owned());
        below(own, rows.ncols())
    }

    /// Rows of all blocks.
    pub(super) fn height(&self) -> usize {
        self.blocks().map(Block::height).sum()
    }

    /// `terms` as this block has them.
    pub(super) fn carried(&self, block: &Block, terms: &[Term]) -> CarriedExplanation {
        match &block.further {
            None => CarriedExplanation::same(terms, &self.first.context),
            Some(further) => carried(
                further.experiment,
                &self.first.context,
                &block.context,
                terms,
            ),
        }
    }

    /// Rows per independent one, of the block and axis that have fewest.
    pub(super) fn rows_per_sample(&self) -> f64 {
        self.blocks()
            .map(Block::rows_per_sample)
            .fold(1.0, f64::max)
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
        let own = self
            .blocks_mut()
            .nth(block)
            .expect("a block of the problem");
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
        self.first.data.take_noise(left, taken);
        self.weigh();
    }

    /// Readings count by their deviations.
    fn weigh(&mut self) {
        for block in self.blocks_mut() {
            block.weight = block.data.std.iter().map(|s| 1.0 / s).collect();
        }
        let rows = self.whitened_rows();
        self.nuisance = Arc::new(Nuisance::of(&rows * &self.prior));
        self.wide = match self.wide_prior == self.prior {
            true => Arc::clone(&self.nuisance),
            false => Arc::new(Nuisance::of(&rows * &self.wide_prior)),
        };
    }

    /// Whitened derivative of all rows by the base parameters; masses move no sole.
    pub(super) fn whitened_rows(&self) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(self.height(), self.prior.nrows());
        for (block, range) in self.blocks().zip(self.readings()) {
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
        let (first, own) = (&self.first, &fit.first);
        let n = own.residual.len();
        let left = |row: usize| own.residual[row] / first.weight[row];
        let left = DVector::from_fn(n, |row, _| left(row));
        let (p, unknowns) = (first.rows.ncols(), own.slopes.ncols());
        // Unknowns come in all units.
        let sizes = own.slopes.column_iter().map(|c| c.norm().max(1e-30));
        let sizes: Vec<f64> = sizes.collect();
        let columns = DMatrix::from_fn(n, p + unknowns, |row, c| match c.checked_sub(p) {
            None => first.rows[(row, c)],
            Some(c) => own.slopes[(row, c)] / first.weight[row] / sizes[c],
        });
        without(&columns, left)
    }

    /// Whether readings are linear in masses about those of CAD.
    #[cfg(test)]
    pub(super) fn is_about_cad(&self) -> bool {
        self.first.offset.is_none()
    }

    /// The same robot with other `blocks`: further ones, or the same about other masses.
    pub(super) fn about(&self, mut blocks: Vec<Block<'m>>) -> Problem<'m> {
        let first = blocks.remove(0);
        let mut own = Problem {
            first,
            others: blocks,
            ..self.clone()
        };
        own.weigh();
        own
    }

    /// The same with about every so many-th posture of each block, readings alone.
    pub(super) fn thinned(&self, every: usize) -> Problem<'m> {
        let blocks = self.blocks().map(|block| {
            let n = block.data.len();
            let every = every.min(n / criteria::WIRING_POSTURES).max(1);
            block.some(&(0..n).map(|k| k % every == 0).collect::<Vec<_>>())
        });
        self.about(blocks.collect())
    }

    /// What unknowns and the number of things that were looked at cost:
    /// `Σ p ln 2N + 2 ln(kinds / w_target)`, see [`Problem::weigh_targets`].
    pub fn penalty(&self, terms: &[Term]) -> f64 {
        let readings = self.height() as f64;
        let kinds = self.targets.len() + hypothesis::MODELS;
        let targets = |term: &Term| match term.effect() {
            Some(instance) => *self.targets.get(&instance.effect.id()).unwrap_or(&1),
            None => 1,
        };
        let of = |term: &Term| {
            let weight = match self.target_weights.get(term) {
                Some(weight) => *weight,
                None => 1.0 / targets(term) as f64,
            };
            let unknowns = term.penalised_unknowns(&self.first.context);
            unknowns as f64 * readings.ln() + 2.0 * (kinds as f64 / weight).ln()
        };
        terms.iter().map(of).sum()
    }

    /// Share the chance of each effect among its targets by how well the logs
    /// see them: `visible` is χ² of an effect of ordinary size at each.
    ///
    /// A fault in an elbow that explains what an ankle's would has to be absurdly
    /// large. Weights of one effect sum to one, so false alarms stay as rare as
    /// with even weights.
    pub fn weigh_targets(&mut self, visible: &[(Term, f64)]) {
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

    /// The masses' directions under a hypothesis.
    pub fn masses(&self, terms: &[Term]) -> &Nuisance {
        if terms.contains(&Term::Masses) {
            &self.wide
        } else {
            &self.nuisance
        }
    }

    /// Factor F of the masses' prior under a hypothesis, and what is known beyond.
    pub(super) fn prior_of(&self, terms: &[Term]) -> (&DMatrix<f64>, Beyond) {
        if terms.contains(&Term::Masses) {
            (&self.wide_prior, Beyond::Exact)
        } else {
            (&self.prior, self.beyond_prior)
        }
    }

    /// Root of the weight of all rows, where outliers count less or some are left out.
    pub(super) fn root_weights(&self, fit: &Fit, rows: RowSelection) -> Option<Vec<f64>> {
        let mut root = rows.root(fit.outliers.as_ref())?;
        root.resize(self.height(), 1.0);
        Some(root)
    }

    /// The masses' directions where rows count by the weights of a fit.
    pub(super) fn masses_of(&self, fit: &Fit, rows: RowSelection) -> Cow<'_, Nuisance> {
        let masses = self.masses(&fit.terms);
        match self.root_weights(fit, rows) {
            Some(root) => Cow::Owned(masses.reweighted(&root)),
            None => Cow::Borrowed(masses),
        }
    }

    /// The most likely mass errors of a fit, in units of F's columns.
    pub(super) fn mass_errors(&self, fit: &Fit, rows: RowSelection) -> DVector<f64> {
        let mut residual = fit.residual();
        let root = self.root_weights(fit, rows);
        let weights = root.iter().flatten();
        residual.iter_mut().zip(weights).for_each(|(e, w)| *e *= w);
        self.masses_of(fit, rows).posterior_mean(&residual)
    }

    /// Whitened shift of all rows by the mass errors that the residuals of `fit` suggest, or
    /// by those that it is stated with; outliers count as all readings do.
    pub(super) fn mass_shift(&self, fit: &Fit) -> DVector<f64> {
        if fit.masses.is_some() {
            let mut all = DVector::zeros(self.height());
            for (block, range) in self.blocks().zip(self.readings()) {
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
    pub(super) fn mass_shift_of(&self, fit: &Fit, rows: RowSelection) -> DVector<f64> {
        self.masses(&fit.terms).shift(&self.mass_errors(fit, rows))
    }

    /// Whether the usual tolerances of CAD leave masses more room than the prior.
    pub(super) fn is_wider(&self) -> bool {
        self.wide.log_det > self.nuisance.log_det
    }

    /// What of stacked columns is neither a mass error nor common to all soles of a log.
    pub(super) fn project_out(&self, masses: &Nuisance, stacked: &DMatrix<f64>) -> DMatrix<f64> {
        let mut left = masses.project_out(stacked);
        for (block, range) in self.blocks().zip(self.readings()) {
            if let Some(closure) = &block.closure {
                let mut own = left.rows_mut(range.end, block.height() - range.len());
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

    /// −2 log p of one column but for a constant: `eᵀ S e`.
    pub(super) fn chi2(&self, masses: &Nuisance, stacked: &DVector<f64>) -> f64 {
        let mut chi2 = masses.chi2(stacked);
        for (block, range) in self.blocks().zip(self.readings()) {
            if let Some(closure) = &block.closure {
                let own = stacked.rows_range(range.end..range.start + block.height());
                let own = own.into_owned();
                chi2 += own.dot(&closure.without_common_of(&own)) - own.norm_squared();
            }
        }
        chi2
    }

    /// What is known of the postures of each block, under a fit to them where one is given.
    pub(super) fn posture_contexts(&self, fit: Option<&Fit>) -> Vec<Cow<'_, [f64]>> {
        let sides = |at: usize| fit?.blocks().nth(at)?.sides.as_ref();
        let blocks = self.blocks().enumerate();
        blocks
            .map(|(at, block)| {
                let log = &block.data.posture_context;
                match sides(at) {
                    Some(own) => {
                        let layout = PostureContext::of(block.context.robot);
                        Cow::Owned(own.context(&layout, log))
                    }
                    None => Cow::Borrowed(&log[..]),
                }
            })
            .collect()
    }

    /// Joint positions of every block's postures as a hypothesis bends them.
    pub fn bent(&self, fit: &Fit) -> Vec<Vec<f64>> {
        let contexts = self.posture_contexts(Some(fit));
        let blocks = self.blocks().zip(&contexts);
        blocks
            .map(|(block, context)| {
                let own = self.carried(block, &fit.terms);
                block.bent(&own.terms, &own.unknowns(&fit.unknowns), context)
            })
            .collect()
    }
}

/// What free masses leave of readings, m, and how many of these they take up: noise, and
/// whatever else is in the log. Where postures are too few for that, all of the gap.
fn left_by_masses(rows: &DMatrix<f64>, reading: &[f64], cad: &[f64]) -> (Vec<f64>, f64) {
    let gap = DVector::from_fn(reading.len(), |row, _| reading[row] - cad[row]);
    without(rows, gap)
}

/// `gap` without what the columns `rows` can take of it, and how many directions that are.
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
fn below(parts: impl Iterator<Item = DMatrix<f64>>, columns: usize) -> DMatrix<f64> {
    parts.fold(DMatrix::zeros(0, columns), |all, part| {
        let at = all.nrows();
        let mut all = all.resize_vertically(at + part.nrows(), 0.0);
        all.rows_mut(at, part.nrows()).copy_from(&part);
        all
    })
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
