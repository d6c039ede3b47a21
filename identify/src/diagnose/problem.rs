//! Hypotheses about one log: what they predict, and what they cost.

pub mod backlash_sides;
mod closing;
mod fitting;
mod readings;

use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex};

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{self, Catalog, EffectContext, EffectId, Instance, PostureContext};
use sesc_model::{Function, Model};

use super::criteria;
use super::hypothesis::{self, Term, with_places};
use super::nuisance::Nuisance;
use super::outliers::Outliers;
use crate::Error;
use crate::evaluate::Evaluator;
use crate::feet::{Closure, ROWS};
use crate::fit::prior::{Prior, Tolerances};
use crate::lsq::factor_normal;
use crate::lsq::solve::Beyond;
use crate::observations::correlation::{Correlation, Process};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::Postures;
use crate::observations::rows::CopRows;

use crate::svd::svd;
pub use closing::Closed;
pub(super) use fitting::State;
use readings::Tapes;

/// A log, the robot, and the prior of its masses.
#[derive(Clone)]
pub struct Problem<'m> {
    /// The robot on its support, with CAD masses.
    pub model: &'m Model,
    pub context: EffectContext<'m>,
    pub data: Postures,
    /// Base parameters from CAD, m.
    pub cad: Vec<f64>,
    /// Those about which readings are linear in masses: CAD's, or where a fit ended.
    pub params: Vec<f64>,
    /// Whitened shift of readings from `params` back to CAD's, where they differ.
    pub(super) offset: Option<DVector<f64>>,
    /// 1/σ per reading.
    pub weight: Vec<f64>,
    /// Factor of each axis's noise for the correlation of its readings in time.
    pub widened: [f64; 2],
    /// How each axis's noise lasts; none where readings are independent.
    lasting: [Option<Process>; 2],
    /// Masses within the prior that was asked for.
    pub nuisance: Nuisance,
    /// Masses within the usual tolerances of CAD, for `mass_distribution`.
    pub wide: Nuisance,
    /// Factor F of the prior on masses; `wide_prior` is that of the usual tolerances.
    pub prior: DMatrix<f64>,
    /// What is known of directions that `prior` has no column for.
    pub beyond_prior: Beyond,
    pub wide_prior: DMatrix<f64>,
    /// Regressor rows of the unbent robot.
    pub rows: DMatrix<f64>,
    /// What of them is motion's; none of standing robots.
    motion_rows: Option<Arc<DMatrix<f64>>>,
    /// Both soles on one floor, where the log is of both feet.
    pub(crate) closure: Option<Arc<Closure>>,
    /// Shared by copies of the problem, whose noise may be another.
    tapes: Arc<Mutex<HashMap<Vec<Instance>, Arc<Tapes>>>>,
    target_weights: HashMap<Term, f64>,
    kinds: usize,
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
    /// Readings it predicts, CAD masses, m.
    pub predicted: Arc<Vec<f64>>,
    /// Whitened residuals (reading − predicted)/σ.
    pub residual: Arc<DVector<f64>>,
    /// Whitened derivative by the unknowns.
    pub slopes: Arc<DMatrix<f64>>,
    /// The same of the soles, where the log is of both feet.
    pub closed: Option<Closed>,
    /// Sides of dead bands, where they matter.
    pub sides: Option<backlash_sides::OwnSides>,
    pub outliers: Option<Outliers>,
    /// Postures with a joint on the side of its dead band that gravity does not favour.
    pub flipped: Vec<usize>,
    /// Walls that are touched: the answer lies at the edge of what is physical.
    pub at_bound: f64,
    /// Base parameters (m) that it is stated with, where they are not those that its
    /// residuals suggest: the problem is then about them.
    pub masses: Option<Vec<f64>>,
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
        self.terms.contains(&Term::FreeMasses)
    }
}

/// How a set of readings counts in a fit.
#[derive(Clone, Copy)]
pub struct RowSelection<'a> {
    /// 1 or 0 per posture; all where `None`.
    pub keep: Option<&'a [bool]>,
}

pub const ALL: RowSelection = RowSelection { keep: None };

impl<'m> Problem<'m> {
    pub fn new(
        model: &'m Model,
        mut data: Postures,
        prior: &Prior,
        effects: &Catalog,
    ) -> Result<Problem<'m>, Error> {
        let times = data.motion.is_some();
        let mut context = EffectContext::new(model, &data.cells, times, effects.clone());
        context.moving = data.moved.is_some();
        let n = data.len();
        let p = model.base.params.len();
        let layout = PostureContext::of(model);
        let entry = |k: usize, entry: usize| data.posture_context[k * layout.len() + entry];
        let tilt = |k: usize| [0, 1].map(|axis| entry(k, layout.tilt(axis)));
        let tilts: Vec<[f64; 2]> = (0..n).map(tilt).collect();
        let mut flat = CopRows::new(model).of(&data.q, n, Some(&tilts));
        let motion_rows = data.moved.as_ref().map(|moved| {
            let standing = std::mem::replace(&mut flat, moved.rows.dense());
            Arc::new(&flat - standing)
        });
        let factor = match prior {
            Prior::Free => free(&flat),
            Prior::Cad(_) | Prior::Population(_) | Prior::Fitted(_) => prior
                .covariance_factor(model)
                .unwrap_or_else(|| DMatrix::zeros(p, 0)),
        };
        let usual = Prior::Cad(Tolerances::usual()).covariance_factor(model);
        let usual = usual.unwrap_or_else(|| DMatrix::zeros(p, 0));
        if data.noise_source == NoiseSource::Residuals {
            let mut out = Evaluator::new(model, Function::Cop).run(&data.q, n);
            let moved = data
                .moved
                .iter()
                .flat_map(|moved| moved.shift.iter().flatten());
            out.iter_mut().zip(moved).for_each(|(cop, by)| *cop += by);
            let (left, taken) = left_by_masses(&flat, &data.reading, &out);
            data.take_noise(&left, taken);
        }
        let weight: Vec<f64> = data.std.iter().map(|s| 1.0 / s).collect();
        let nuisance = Nuisance::new(&flat, &factor, &weight);
        let wide = Nuisance::new(&flat, &usual, &weight);
        let instances = effects::instances(&context);
        let kinds: BTreeSet<EffectId> = instances.iter().map(|i| i.effect.id()).collect();
        Ok(Problem {
            cad: model.cad_params(),
            params: model.cad_params(),
            offset: None,
            widened: [1.0; 2],
            lasting: [None; 2],
            model,
            kinds: kinds.len() + hypothesis::MODELS,
            context,
            data,
            weight,
            nuisance,
            wide,
            prior: factor,
            beyond_prior: match prior {
                Prior::Free => Beyond::Nothing,
                Prior::Cad(_) | Prior::Population(_) | Prior::Fitted(_) => Beyond::Exact,
            },
            wide_prior: usual,
            rows: flat,
            motion_rows,
            closure: None,
            tapes: Arc::default(),
            target_weights: HashMap::new(),
        })
    }

    /// The same beliefs about the robot on another support: nothing can be fitted there,
    /// explanations can be evaluated.
    pub fn on<'o>(&self, model: &'o Model) -> Problem<'o>
    where
        'm: 'o,
    {
        let (cells, times) = (&self.data.cells, self.data.motion.is_some());
        Problem {
            cad: model.cad_params(),
            params: model.cad_params(),
            offset: None,
            widened: [1.0; 2],
            lasting: [None; 2],
            context: EffectContext::new(model, cells, times, self.context.catalog.clone()),
            model,
            motion_rows: None,
            closure: None,
            tapes: Arc::default(),
            target_weights: HashMap::new(),
            ..self.clone()
        }
    }

    /// The same problem, whose log is of both feet: what the soles say counts.
    pub(super) fn on_both_feet(self, closure: Option<Closure>) -> Problem<'m> {
        Problem {
            closure: closure.map(Arc::new),
            ..self
        }
    }

    /// What masses `r` (m) do to what motion adds to readings of CAD's, m; empty of standing
    /// robots.
    pub(super) fn motion_of(&self, r: &[f64]) -> Vec<f64> {
        let Some(rows) = &self.motion_rows else {
            return Vec::new();
        };
        let off = DVector::from_fn(r.len(), |k, _| r[k] - self.cad[k]);
        (&**rows * off).as_slice().to_vec()
    }

    /// Rows per independent one, of the axis that has fewer.
    pub(super) fn rows_per_sample(&self) -> f64 {
        self.widened[0].max(self.widened[1]).powi(2)
    }

    /// Factor of an axis's noise for what is known worse.
    pub(super) fn widened(&self, axis: usize) -> f64 {
        self.widened[axis]
    }

    /// The noise of each axis is `factors` times as large.
    pub(super) fn scale_noise(&mut self, factors: [f64; 2]) {
        self.data.scale_noise(factors);
        self.weigh();
    }

    /// Count each axis as known `factors` times as badly: readings are not independent.
    pub(super) fn widen_noise(&mut self, factors: [f64; 2]) {
        self.widened = factors;
        for (row, std) in self.data.std.iter_mut().enumerate() {
            *std *= factors[row % 2];
        }
        self.weigh();
    }

    /// The same by what `correlation` says, which also tells how far deviations of unknowns are
    /// from those of noise that is as slow as whatever they explain.
    pub(super) fn correlate_noise(&mut self, correlation: &[Correlation; 2]) {
        self.widen_noise(correlation.map(|axis| axis.rows_per_sample.sqrt()));
        self.lasting = correlation.map(|axis| axis.process);
    }

    /// Readings count by their deviations.
    fn weigh(&mut self) {
        self.weight = self.data.std.iter().map(|s| 1.0 / s).collect();
        self.nuisance = Nuisance::new(&self.rows, &self.prior, &self.weight);
        self.wide = Nuisance::new(&self.rows, &self.wide_prior, &self.weight);
    }

    /// Take the noise of each axis from what is `left` of readings, m, by that which took up
    /// `taken` of them.
    pub(super) fn take_noise(&mut self, left: &[f64], taken: f64) {
        self.data.take_noise(left, taken);
        self.weigh();
    }

    /// What `fit` and free masses leave of readings, m, and how many of these they take up:
    /// free masses alone leave what the fit explains, too.
    pub(super) fn left_beside_masses(&self, fit: &Fit) -> (Vec<f64>, f64) {
        let n = fit.residual.len();
        let left = |row: usize| fit.residual[row] / self.weight[row];
        let left = DVector::from_fn(n, |row, _| left(row));
        let (p, unknowns) = (self.rows.ncols(), fit.slopes.ncols());
        // Unknowns come in all units.
        let sizes = fit.slopes.column_iter().map(|c| c.norm().max(1e-30));
        let sizes: Vec<f64> = sizes.collect();
        let columns = DMatrix::from_fn(n, p + unknowns, |row, c| match c.checked_sub(p) {
            None => self.rows[(row, c)],
            Some(c) => fit.slopes[(row, c)] / self.weight[row] / sizes[c],
        });
        without(&columns, left)
    }

    /// Whether readings are linear in masses about those of CAD.
    pub(super) fn is_about_cad(&self) -> bool {
        self.offset.is_none()
    }

    /// The same problem about other masses `params`: `rows` are the slopes of readings
    /// there, `offset` the whitened shift of readings from `params` back to CAD's.
    pub(super) fn about(
        &self,
        params: Vec<f64>,
        rows: DMatrix<f64>,
        nuisance: Nuisance,
        wide: Nuisance,
        offset: DVector<f64>,
    ) -> Problem<'m> {
        Problem {
            params,
            offset: Some(offset),
            nuisance,
            wide,
            rows,
            tapes: Arc::default(),
            ..self.clone()
        }
    }

    /// Readings and the directions that masses take of them, where nothing states the noise and
    /// readings are fewer than twice those: what masses leave says little of it.
    pub fn too_few(&self) -> Option<[usize; 2]> {
        let unknown = self.data.noise_source == NoiseSource::Residuals;
        let (rows, directions) = (self.rows.nrows(), self.rows.ncols());
        (unknown && rows < 2 * directions).then_some([rows, directions.min(rows)])
    }

    /// What unknowns and the number of things that were looked at cost:
    /// `Σ p ln 2N + 2 ln(kinds / w_target)`, see [`Problem::weigh_targets`].
    pub fn penalty(&self, terms: &[Term]) -> f64 {
        let soles = if self.closure.is_some() { ROWS } else { 0 };
        let readings = ((2 + soles) * self.data.len()) as f64;
        let of = |term: &Term| {
            let weight = match self.target_weights.get(term) {
                Some(weight) => *weight,
                None => 1.0 / term.targets(&self.context) as f64,
            };
            let unknowns = term.penalised_unknowns(&self.context);
            unknowns as f64 * readings.ln() + 2.0 * (self.kinds as f64 / weight).ln()
        };
        terms.iter().map(of).sum()
    }

    /// Share the chance of each effect among its targets by how well this log
    /// sees them: `visible` is χ² of an effect of ordinary size at each.
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
        match terms.contains(&Term::FreeMasses) {
            true => &self.wide,
            false => &self.nuisance,
        }
    }

    /// Whitened shift of readings by the mass errors that the residuals of `fit` suggest, or
    /// by those that it is stated with.
    pub(super) fn mass_shift(&self, fit: &Fit) -> DVector<f64> {
        match (&fit.masses, &self.offset) {
            (Some(_), Some(offset)) => offset.clone(),
            _ => {
                let masses = self.masses(&fit.terms);
                masses.shift(&masses.posterior_mean(&fit.residual))
            }
        }
    }

    /// Whether the usual tolerances of CAD leave masses more room than the prior.
    pub(super) fn is_wider(&self) -> bool {
        self.wide.log_det > self.nuisance.log_det
    }

    /// The revolute joints that have a dead band under `terms`, with the
    /// place of its width among the unknowns.
    pub(super) fn slack_joints(&self, terms: &[Term]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        for (term, own) in with_places(terms, &self.context) {
            if let (Some(_), Some(instance)) = (term.dead_band(), term.effect()) {
                let joints = instance.target.revolute(self.context.robot);
                found.extend(joints.into_iter().map(|j| (j, own.start)));
            }
        }
        found
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
