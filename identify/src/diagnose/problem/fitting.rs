//! Fitting a hypothesis.
//!
//! ```text
//! objective(e) = −2 log p(y | e)      masses marginalised, physical bounds as walls
//! ```
//!
//! Damped least squares over the unknowns of all terms together, with the
//! symbolic derivatives of the measurement.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::backlash_sides::{self, Sides};
use super::{Block, Fit, OnBlock, Problem};
use super::{stacked_residual, stacked_slopes};
use crate::diagnose::criteria;
use crate::diagnose::hypothesis::{Term, with_places};
use crate::diagnose::nuisance::Nuisance;
use crate::diagnose::outliers::Outliers;
use crate::lsq::damped::{self, Expansion, SETTLED};
use crate::lsq::transposed_times;

/// Rounds in which sides of dead bands and outliers are settled with the rest.
const ROUNDS: usize = 4;

impl Problem<'_> {
    /// The best fit of a hypothesis from wherever it may be begun.
    pub(crate) fn fit(&self, terms: &[Term], parent: Option<&Fit>) -> Fit {
        let starts = self.starts(terms, parent).into_iter();
        let fits = starts.map(|start| self.fit_from(terms, start));
        fits.min_by(|a, b| a.objective.total_cmp(&b.objective))
            .expect("there is a start")
    }

    /// Where unknowns may start: every start of what is new, beside what `parent` found
    /// of the others.
    fn starts(&self, terms: &[Term], parent: Option<&Fit>) -> Vec<Vec<f64>> {
        let mut starts = vec![Vec::new()];
        for term in terms {
            let found = parent.and_then(|fit| fit.unknowns_of(self.context(), term));
            let own = match found {
                Some(own) => vec![own.to_vec()],
                None => term.starts(self.context()),
            };
            let longer = |before: &Vec<f64>| {
                let longer = own.iter().map(|own| [&before[..], own].concat());
                longer.collect::<Vec<_>>()
            };
            starts = starts.iter().flat_map(longer).collect();
        }
        starts.truncate(criteria::TRIED);
        starts
    }

    pub(crate) fn fit_from(&self, terms: &[Term], start: Vec<f64>) -> Fit {
        let slack = terms.iter().any(|term| term.dead_band().is_some());
        let outlying = terms.contains(&Term::Outliers);
        let mut unknowns = start;
        let mut fit: Option<Fit> = None;
        let mut sides = None;
        let mut outliers: Option<Outliers> = None;
        for round in 0..ROUNDS {
            if slack {
                if round == 0 {
                    // A width to begin with, else no side matters.
                    for (term, own) in with_places(terms, self.context()) {
                        match (term.dead_band(), unknowns.get_mut(own.start)) {
                            (Some(width), Some(first)) if *first == 0.0 => *first = width,
                            _ => {}
                        }
                    }
                }
                let fitted = fit.is_some();
                sides = Some(backlash_sides::settle(self, terms, &unknowns, fitted));
            }
            let held = (sides.as_deref(), outliers.as_ref());
            let next = self.descend(terms, unknowns.clone(), held);
            let is_near = |fit: &Fit| (fit.objective - next.objective).abs() < SETTLED;
            let done = fit.as_ref().is_some_and(is_near);
            unknowns = next.unknowns.clone();
            let better = fit.as_ref().is_none_or(|f| next.objective < f.objective);
            if better || outlying {
                fit = Some(next);
            }
            if done || !(slack || outlying) {
                break;
            }
            if outlying {
                let fit = fit.as_ref().expect("set above");
                let readings = self.first().readings_of(&fit.blocks[0]);
                outliers = Some(Outliers::of(readings, self.kept.as_deref()));
            }
        }
        fit.expect("at least one round")
    }

    /// Damped least squares with sides and outliers held.
    fn descend(
        &self,
        terms: &[Term],
        start: Vec<f64>,
        (sides, outliers): (Option<&[Sides]>, Option<&Outliers>),
    ) -> Fit {
        let contexts = sides.map(|sides| {
            let contexts = sides.iter().map(|own| own.posture_context[..].into());
            contexts.collect()
        });
        let contexts = contexts.unwrap_or_else(|| self.posture_contexts(None));
        let sides = sides.unwrap_or_default();
        let weighting = self.weighting(terms, outliers);
        let scales = self.scales(terms);
        let expand = |unknowns| self.state(terms, unknowns, &contexts, &weighting);
        let state = damped::minimise(expand(start), &scales, expand);
        let covariance = self.covariance(&state, &scales, &weighting);
        let mut objective = state.value + weighting.masses.log_det - self.masses(&[]).log_det;
        objective += sides.iter().map(|own| own.penalty).sum::<f64>();
        if let Some(outliers) = outliers {
            let residual = self.first().readings_of(&state.there[0]);
            objective = outliers.objective(residual, self.kept.as_deref(), objective);
        }
        let mut blocks = state.there;
        for ((own, block), sides) in blocks.iter_mut().zip(&self.blocks).zip(sides) {
            own.sides = Some(block.sides_of(&sides.posture_context));
            own.flipped.clone_from(&sides.flipped);
        }
        Fit {
            penalty: self.penalty(terms),
            terms: terms.to_vec(),
            unknowns: state.unknowns,
            covariance,
            objective,
            blocks,
            outliers: outliers.cloned(),
            masses: None,
        }
    }

    /// Covariance of the unknowns. The fit weighs rows as if noise were white over as many as are
    /// worth one; what it moves them by is that of noise which lasts as it does:
    ///
    /// ```text
    /// C = A⁻¹ (A + Σ_log Σ_axis Zᵀ (R/f − I) Z) A⁻¹        A = Jᵀ Z,  Z = (I + F Fᵀ)⁻¹ J
    /// ```
    ///
    /// R is the correlation of an axis's rows, f how many are worth one, F what masses do.
    pub(in crate::diagnose) fn covariance(
        &self,
        state: &State,
        scales: &[f64],
        weighting: &Weighting,
    ) -> DMatrix<f64> {
        let as_white = damped::covariance(&state.normal, scales);
        match self.lasting_spread(state, weighting) {
            Some(spread) => &as_white + &as_white * spread * &as_white,
            None => as_white,
        }
    }

    /// `Σ Zᵀ (R/f − I) Z`: how far noise that lasts spreads the gradient of the unknowns beyond
    /// noise that is white; none where no noise lasts.
    fn lasting_spread(&self, state: &State, weighting: &Weighting) -> Option<DMatrix<f64>> {
        let lasts =
            |block: &Block| block.data.t.is_some() && block.lasting.iter().any(Option::is_some);
        if !self.blocks.iter().any(lasts) {
            return None;
        }
        let unknowns = state.unknowns.len();
        let mut z = stacked_slopes(&state.there, unknowns);
        weighting.weigh(&mut z);
        z = weighting.masses.project_out(&z);
        weighting.weigh(&mut z);
        let mut spread = DMatrix::zeros(unknowns, unknowns);
        for (block, range) in self.blocks.iter().zip(self.readings()) {
            let Some(t) = &block.data.t else { continue };
            for (axis, process) in block.lasting.iter().enumerate() {
                let Some(process) = process else { continue };
                let row = |k: usize| range.start + 2 * k + axis;
                let own = DMatrix::from_fn(t.len(), unknowns, |k, c| z[(row(k), c)]);
                spread += process.spread(t, &own) / block.widened[axis].powi(2) - own.tr_mul(&own);
            }
        }
        Some(spread)
    }

    pub(crate) fn scales(&self, terms: &[Term]) -> Vec<f64> {
        let scales = terms.iter().flat_map(|term| term.scales(self.context()));
        scales.collect()
    }

    /// What terms predict of every block at joint positions `q`, those of the log unless given.
    pub(in crate::diagnose) fn predict(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        contexts: &[Cow<[f64]>],
        q: Option<&[Vec<f64>]>,
    ) -> Vec<OnBlock> {
        let blocks = self.blocks.iter().zip(contexts).enumerate();
        let predicted = blocks.map(|(at, (block, context))| {
            let own = self.carried(block, terms, unknowns);
            let q = q.map_or(&block.data.q, |q| &q[at]);
            block.predict(&own, unknowns.len(), q, context)
        });
        predicted.collect()
    }

    /// The likelihood at given unknowns, bounds as walls.
    pub(in crate::diagnose) fn state(
        &self,
        terms: &[Term],
        unknowns: Vec<f64>,
        contexts: &[Cow<[f64]>],
        weighting: &Weighting,
    ) -> State {
        let blocks = self.predict(terms, &unknowns, contexts, None);
        let width = unknowns.len();
        // Slopes, and residuals behind them: masses are taken from all of them at once.
        let mut rows = stacked_slopes(&blocks, width).insert_column(width, 0.0);
        rows.set_column(width, &stacked_residual(&blocks));
        weighting.weigh(&mut rows);
        let left = self.project_out(&weighting.masses, &rows);
        let products = transposed_times(&rows, &left);
        let mut state = State {
            value: products[(width, width)],
            normal: products.view((0, 0), (width, width)).into_owned(),
            gradient: products.view((0, width), (width, 1)).column(0).into_owned(),
            there: blocks,
            unknowns,
        };
        self.add_walls(terms, &mut state);
        if !state.value.is_finite() {
            state.value = f64::INFINITY;
        }
        state
    }

    /// Each bound that is crossed, with its slope by the unknowns.
    fn add_walls(&self, terms: &[Term], state: &mut State) {
        let context = self.context();
        for (term, places) in with_places(terms, context) {
            let own = state.unknowns[places.clone()].to_vec();
            let violation = |x: &[f64]| term.bound_violation(context, x);
            let scales = term.scales(context);
            for (wall, now) in violation(&own).into_iter().enumerate() {
                if now <= 0.0 {
                    continue;
                }
                let slope = DVector::from_fn(own.len(), |k, _| {
                    let mut moved = own.clone();
                    let step = 1e-6 * scales[k];
                    moved[k] += step;
                    (violation(&moved)[wall] - now) / step
                });
                let (at, count) = (places.start, own.len());
                state.value += now * now;
                let mut gradient = state.gradient.rows_mut(at, count);
                gradient -= now * &slope;
                let mut normal = state.normal.view_mut((at, at), (count, count));
                normal += &slope * slope.transpose();
            }
        }
    }
}

/// How rows count while unknowns are fitted.
pub(in crate::diagnose) struct Weighting<'w> {
    /// Root of the weight of each row; none where all count alike.
    pub root: Option<Vec<f64>>,
    /// The masses' directions in rows that count so.
    pub masses: Cow<'w, Nuisance>,
}

impl Weighting<'_> {
    pub(crate) fn weigh(&self, rows: &mut DMatrix<f64>) {
        let roots = self.root.iter().flatten().enumerate();
        roots.for_each(|(row, root)| rows.row_mut(row).scale_mut(*root));
    }

    /// Whitened residuals of a fit as they count.
    pub(crate) fn residual(&self, fit: &Fit) -> DVector<f64> {
        let mut residual = DMatrix::from_columns(&[fit.residual()]);
        self.weigh(&mut residual);
        residual.column(0).into_owned()
    }
}

/// A hypothesis at given unknowns, with what it predicts of each block there.
pub(in crate::diagnose) type State = Expansion<Vec<OnBlock>>;
