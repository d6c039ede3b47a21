//! Fitting a hypothesis.
//!
//! ```text
//! objective(e) = −2 log p(y | e)      masses marginalised, physical bounds as walls
//! ```
//!
//! Damped least squares over the unknowns of all terms together, with the
//! symbolic derivatives of the measurement.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::{Closed, Fit, Problem, RowSelection, backlash_sides};
use crate::diagnose::hypothesis::{Term, with_places};
use crate::diagnose::nuisance::Nuisance;
use crate::diagnose::outliers::Outliers;
use crate::lsq::damped::{self, Expansion, SETTLED};
use crate::lsq::transposed_times;

/// Starts of a fit, at most.
const STARTS: usize = 8;
/// Rounds in which sides of dead bands and outliers are settled with the rest.
const ROUNDS: usize = 4;

impl Problem<'_> {
    /// Fit a hypothesis from where its unknowns may start.
    pub fn fit(&self, terms: &[Term], start: Option<&[f64]>, rows: RowSelection) -> Fit {
        let starts = match start {
            Some(start) => vec![start.to_vec()],
            None => self.starts(terms, None),
        };
        let fits = starts
            .into_iter()
            .map(|start| self.fit_from(terms, start, rows));
        fits.min_by(|a, b| a.objective.total_cmp(&b.objective))
            .expect("there is a start")
    }

    /// Where unknowns may start: every start of what is new, beside what `parent` found
    /// of the others.
    pub fn starts(&self, terms: &[Term], parent: Option<&Fit>) -> Vec<Vec<f64>> {
        let mut starts = vec![Vec::new()];
        for term in terms {
            let found = parent.and_then(|fit| fit.unknowns_of(&self.context, term));
            let own = match found {
                Some(own) => vec![own.to_vec()],
                None => term.starts(&self.context),
            };
            let longer = |before: &Vec<f64>| -> Vec<Vec<f64>> {
                own.iter()
                    .map(|own| [before.as_slice(), own].concat())
                    .collect()
            };
            starts = starts.iter().flat_map(longer).collect();
        }
        starts.truncate(STARTS);
        starts
    }

    fn fit_from(&self, terms: &[Term], start: Vec<f64>, rows: RowSelection) -> Fit {
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
                    self.widen(terms, &mut unknowns);
                }
                sides = Some(backlash_sides::settle(self, terms, &unknowns, fit.as_ref()));
            }
            let next = self.descend(terms, unknowns.clone(), sides.as_ref(), &outliers, rows);
            let done = match &fit {
                Some(before) => (before.objective - next.objective).abs() < SETTLED,
                None => false,
            };
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
                outliers = Some(Outliers::of(&fit.residual, rows.keep));
            }
        }
        fit.expect("at least one round")
    }

    fn widen(&self, terms: &[Term], unknowns: &mut [f64]) {
        for (term, own) in with_places(terms, &self.context) {
            let at = own.start;
            if let (Some(width), true) = (term.dead_band(), unknowns.get(at) == Some(&0.0)) {
                unknowns[at] = width;
            }
        }
    }

    /// Damped least squares with sides and outliers held.
    fn descend(
        &self,
        terms: &[Term],
        start: Vec<f64>,
        sides: Option<&backlash_sides::Sides>,
        outliers: &Option<Outliers>,
        rows: RowSelection,
    ) -> Fit {
        let posture_context: &[f64] = match sides {
            Some(sides) => &sides.posture_context,
            None => &self.data.posture_context,
        };
        let masses = self.masses(terms);
        let root = outliers.as_ref().map(|o| o.root_weights(rows.keep));
        let root = match (root, rows.keep) {
            (None, Some(keep)) => Some(
                keep.iter()
                    .flat_map(|k| [f64::from(u8::from(*k)); 2])
                    .collect(),
            ),
            (root, _) => root,
        };
        let reweighted = root.as_ref().map(|root: &Vec<f64>| masses.reweighted(root));
        let masses = reweighted.as_ref().unwrap_or(masses);
        let scales = self.scales(terms);
        let expand = |unknowns| self.state(terms, unknowns, posture_context, &root, masses);
        let state = damped::minimise(expand(start), &scales, expand);
        let covariance = self.covariance(&state, &scales, &root, masses);
        let mut objective = state.value + masses.log_det - self.nuisance.log_det;
        if let Some(sides) = sides {
            objective += sides.penalty;
        }
        if let Some(outliers) = outliers {
            objective = outliers.objective(&state.residual, rows.keep, objective);
        }
        Fit {
            penalty: self.penalty(terms),
            terms: terms.to_vec(),
            unknowns: state.unknowns,
            covariance,
            objective,
            predicted: Arc::new(state.predicted),
            residual: Arc::new(state.residual),
            slopes: Arc::new(state.slopes),
            closed: state.closed,
            sides: sides.map(|sides| self.sides_of(&sides.posture_context)),
            outliers: outliers.clone(),
            flipped: sides.map_or_else(Vec::new, |sides| sides.flipped.clone()),
            at_bound: state.at_bound,
            masses: None,
        }
    }

    /// Covariance of the unknowns. The fit weighs rows as if noise were white over as many as are
    /// worth one; what it moves them by is that of noise which lasts as it does:
    ///
    /// ```text
    /// C = A⁻¹ (A + Σ_axis Zᵀ (R/f − I) Z) A⁻¹        A = Jᵀ Z,  Z = (I + F Fᵀ)⁻¹ J
    /// ```
    ///
    /// R is the correlation of an axis's rows, f how many are worth one, F what masses do.
    pub(in crate::diagnose) fn covariance(
        &self,
        state: &State,
        scales: &[f64],
        root: &Option<Vec<f64>>,
        masses: &Nuisance,
    ) -> DMatrix<f64> {
        let as_white = damped::covariance(&state.normal.0, scales);
        match self.lasting_spread(state, root, masses) {
            Some(spread) => &as_white + &as_white * spread * &as_white,
            None => as_white,
        }
    }

    /// `Σ_axis Zᵀ (R/f − I) Z`: how far noise that lasts spreads the gradient of the unknowns beyond
    /// noise that is white; none where no noise lasts. That of several logs is the sum of theirs.
    pub(in crate::diagnose) fn lasting_spread(
        &self,
        state: &State,
        root: &Option<Vec<f64>>,
        masses: &Nuisance,
    ) -> Option<DMatrix<f64>> {
        let t = self.data.t.as_ref()?;
        if self.lasting.iter().all(Option::is_none) {
            return None;
        }
        let counted = |mut slopes: DMatrix<f64>| {
            let rows = root.iter().flatten().enumerate();
            rows.for_each(|(row, root)| slopes.row_mut(row).scale_mut(*root));
            slopes
        };
        let z = counted(masses.project_out(&counted(state.slopes.clone())));
        let mut spread = DMatrix::zeros(z.ncols(), z.ncols());
        for (axis, process) in self.lasting.iter().enumerate() {
            let Some(process) = process else { continue };
            let own = DMatrix::from_fn(t.len(), z.ncols(), |k, c| z[(2 * k + axis, c)]);
            spread += process.spread(t, &own) / self.widened[axis].powi(2) - own.tr_mul(&own);
        }
        Some(spread)
    }

    pub fn scales(&self, terms: &[Term]) -> Vec<f64> {
        terms
            .iter()
            .flat_map(|term| term.scales(&self.context))
            .collect()
    }

    pub(in crate::diagnose) fn state(
        &self,
        terms: &[Term],
        unknowns: Vec<f64>,
        posture_context: &[f64],
        root: &Option<Vec<f64>>,
        masses: &Nuisance,
    ) -> State {
        let mut state = self.squares(terms, unknowns, posture_context, root, masses);
        let (normal, gradient) = &mut state.normal;
        self.walls(terms, &state.unknowns, |violation, slope| {
            state.value += violation * violation;
            state.at_bound += violation * violation;
            for a in 0..slope.len() {
                gradient[a] -= violation * slope[a];
                for b in 0..slope.len() {
                    normal[(a, b)] += slope[a] * slope[b];
                }
            }
        });
        if !state.value.is_finite() {
            state.value = f64::INFINITY;
        }
        state
    }

    /// The same without walls.
    pub(in crate::diagnose) fn squares(
        &self,
        terms: &[Term],
        unknowns: Vec<f64>,
        posture_context: &[f64],
        root: &Option<Vec<f64>>,
        masses: &Nuisance,
    ) -> State {
        let (n, p) = (self.data.len(), unknowns.len());
        let out = self.evaluate(terms, &unknowns, &self.data.q, posture_context);
        let width = p + 1;
        let mut predicted = Vec::with_capacity(2 * n);
        let mut residual = DVector::zeros(2 * n);
        let mut slopes = DMatrix::zeros(2 * n, p);
        for row in 0..2 * n {
            let values = &out[row * width..(row + 1) * width];
            // Readings of CAD's masses, by what is linear about `params`.
            let back = self.offset.as_ref().map_or(0.0, |offset| offset[row]) / self.weight[row];
            let value = values[0] - back;
            predicted.push(value);
            residual[row] = (self.data.reading[row] - value) * self.weight[row];
            for k in 0..p {
                slopes[(row, k)] = values[1 + k] * self.weight[row];
            }
        }
        let (mut e, mut j) = (residual.clone(), slopes.clone());
        if let Some(root) = root {
            for row in 0..2 * n {
                e[row] *= root[row];
                j.row_mut(row).scale_mut(root[row]);
            }
        }
        let inner = masses.project_out_one(&e);
        let mut value = e.dot(&inner);
        let mut normal = (
            transposed_times(&j, &masses.project_out(&j)),
            j.tr_mul(&inner),
        );
        let closed = self.closed(terms, &unknowns, posture_context);
        if let (Some(closure), Some(closed)) = (&self.closure, &closed) {
            let (residual, slopes) = (&closed.residual, &closed.slopes);
            let inner = closure.without_common_of(residual);
            value += residual.dot(&inner);
            normal.0 += slopes.tr_mul(&closure.without_common(slopes));
            normal.1 += slopes.tr_mul(&inner);
        }
        State {
            value,
            normal,
            closed,
            at_bound: 0.0,
            unknowns,
            predicted,
            residual,
            slopes,
        }
    }

    /// Each bound that is crossed, with its slope by the unknowns.
    fn walls(&self, terms: &[Term], unknowns: &[f64], mut each: impl FnMut(f64, &[f64])) {
        for (term, places) in with_places(terms, &self.context) {
            let own = &unknowns[places.clone()];
            let violation = |x: &[f64]| term.bound_violation(&self.context, x);
            let now = violation(own);
            if now.iter().any(|x| *x > 0.0) {
                let scales = term.scales(&self.context);
                let mut slopes = vec![vec![0.0; unknowns.len()]; now.len()];
                for k in 0..own.len() {
                    let mut moved = own.to_vec();
                    let step = 1e-6 * scales[k];
                    moved[k] += step;
                    for (wall, after) in violation(&moved).iter().enumerate() {
                        slopes[wall][places.start + k] = (after - now[wall]) / step;
                    }
                }
                for (wall, slope) in slopes.iter().enumerate() {
                    if now[wall] > 0.0 {
                        each(now[wall], slope);
                    }
                }
            }
        }
    }
}

/// A hypothesis at given unknowns.
pub(in crate::diagnose) struct State {
    pub unknowns: Vec<f64>,
    pub predicted: Vec<f64>,
    pub residual: DVector<f64>,
    pub slopes: DMatrix<f64>,
    pub closed: Option<Closed>,
    pub value: f64,
    pub normal: (DMatrix<f64>, DVector<f64>),
    pub at_bound: f64,
}

impl Expansion for State {
    fn unknowns(&self) -> &[f64] {
        &self.unknowns
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn normal(&self) -> &DMatrix<f64> {
        &self.normal.0
    }

    fn gradient(&self) -> &DVector<f64> {
        &self.normal.1
    }
}
