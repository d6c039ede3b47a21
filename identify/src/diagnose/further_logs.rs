//! A further log, of an experiment: explanations of the first, fitted to both.
//!
//! ```text
//! objective(e) = objective_1(e) + χ²_2(S e)      S: what the experiment makes of the
//!                                                unknowns, see `experiment`
//! ```
//!
//! Masses are marginalised log by log: what both know of them together is left out. Noise that
//! lasts in a log moves the unknowns by that log's rows: with A of all logs and what their noise
//! spreads the gradient by beyond white noise,
//!
//! ```text
//! C = A⁻¹ (A + B_1 + Sᵀ B_2 S) A⁻¹        B: that of `Problem::covariance`
//! ```

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use sesc_model::effects::Experiment;

use super::exact::{Exact, masses_of};
use super::experiment::{self, CarriedExplanation};
use super::hypothesis::Term;
use super::nuisance::Nuisance;
use super::problem::{ALL, Fit, Problem, State, backlash_sides};
use crate::lsq::damped;

/// A log of an experiment, on the support that it was taken on.
#[derive(Clone)]
pub struct FurtherLog<'m> {
    pub experiment: Experiment,
    pub problem: Problem<'m>,
}

impl<'m> FurtherLog<'m> {
    /// What `fit`, of the `first` log or of all, says of this one: its terms here, and what they
    /// leave; with this log about its own masses where the first is about its own.
    pub(super) fn explained_by(
        &self,
        first: &Problem,
        fit: &Fit,
    ) -> (FurtherLog<'m>, Vec<Term>, State) {
        let own = match first.is_about_cad() {
            true => self.clone(),
            false => self.about_its_masses(first, fit),
        };
        let log = Log::new(first, fit, &own);
        let state = log.state(&fit.unknowns);
        let terms = log.carried.terms;
        (own, terms, state)
    }

    /// This log, linear in masses about those that `fit` of all logs leaves it.
    pub(super) fn about_its_masses(&self, first: &Problem, fit: &Fit) -> FurtherLog<'m> {
        let own = Log::new(first, fit, self).stated(fit);
        let masses = masses_of(&self.problem, &own);
        FurtherLog {
            experiment: self.experiment,
            problem: Exact::new(&self.problem, &own).about(&self.problem, &own, masses),
        }
    }
}

/// `fit` of the first log, fitted to all: its score is that of all logs, its
/// predictions and residuals are those of the first.
pub fn together(first: &Problem, fit: Fit, further: &[FurtherLog]) -> Fit {
    if further.is_empty() {
        return fit;
    }
    let logs: Vec<Log> = further.iter().map(|f| Log::new(first, &fit, f)).collect();
    let root = fit.outliers.as_ref().map(|o| o.root_weights(None));
    let masses = root
        .as_ref()
        .map(|r| first.masses(&fit.terms).reweighted(r));
    let posture_context = first.posture_context_of(&fit);
    let own = |unknowns: Vec<f64>| {
        let masses = masses.as_ref().unwrap_or(first.masses(&fit.terms));
        first.state(&fit.terms, unknowns, &posture_context, &root, masses)
    };
    let scales = first.scales(&fit.terms);
    let before = own(fit.unknowns.clone());
    // Of the first log alone: what is no square, and stays.
    let rest = fit.objective - before.value;
    let start = joint(before, &logs);
    let at = damped::minimise(start, &scales, |unknowns| joint(own(unknowns), &logs));
    let n = first.data.len() as f64;
    let all = n + further
        .iter()
        .map(|f| f.problem.data.len() as f64)
        .sum::<f64>();
    let own_masses = masses.as_ref().unwrap_or(first.masses(&fit.terms));
    Fit {
        covariance: covariance_of(
            first,
            (&at, &at.normal.0),
            &logs,
            &root,
            own_masses,
            &scales,
        ),
        objective: at.value + rest,
        penalty: fit.penalty + scales.len() as f64 * (all / n).ln(),
        unknowns: at.unknowns,
        predicted: Arc::new(at.predicted),
        residual: Arc::new(at.residual),
        slopes: Arc::new(at.slopes),
        closed: at.closed,
        at_bound: at.at_bound,
        ..fit
    }
}

/// Covariance of the unknowns of `fit` by all logs, of which the first is at `state`.
pub(super) fn covariance(
    first: &Problem,
    fit: &Fit,
    state: &State,
    further: &[FurtherLog],
    root: &Option<Vec<f64>>,
    masses: &Nuisance,
) -> DMatrix<f64> {
    let logs: Vec<Log> = further.iter().map(|f| Log::new(first, fit, f)).collect();
    let scales = first.scales(&fit.terms);
    let mut normal = state.normal.clone();
    for log in &logs {
        log.add(&log.state(&state.unknowns), &mut normal);
    }
    covariance_of(first, (state, &normal.0), &logs, root, masses, &scales)
}

/// The same where the `normal` matrix of all logs is known.
fn covariance_of(
    first: &Problem,
    (state, normal): (&State, &DMatrix<f64>),
    logs: &[Log],
    root: &Option<Vec<f64>>,
    masses: &Nuisance,
    scales: &[f64],
) -> DMatrix<f64> {
    let mut spread = first.lasting_spread(state, root, masses);
    for log in logs {
        log.add_spread(&log.state(&state.unknowns), scales.len(), &mut spread);
    }
    let as_white = damped::covariance(normal, scales);
    match spread {
        Some(spread) => &as_white + &as_white * spread * &as_white,
        None => as_white,
    }
}

/// `fit` of all logs, fitted to them again: the first about the masses of `own`, the others about
/// those that it leaves them.
pub(super) fn fitted_again(own: &Problem, fit: &Fit, further: &[FurtherLog]) -> Fit {
    let first = own.fit(&fit.terms, Some(&fit.unknowns), ALL);
    let logs = further.iter().map(|log| log.about_its_masses(own, fit));
    let logs: Vec<FurtherLog> = logs.collect();
    together(own, first, &logs)
}

/// A further log under one explanation.
struct Log<'f, 'm> {
    problem: &'f Problem<'m>,
    carried: CarriedExplanation,
    posture_context: Vec<f64>,
    /// Penalty of sides of backlash that gravity does not favour.
    penalty: f64,
}

impl<'f, 'm> Log<'f, 'm> {
    fn new(first: &Problem, fit: &Fit, further: &'f FurtherLog<'m>) -> Log<'f, 'm> {
        let problem = &further.problem;
        let (here, there) = (&first.context, &problem.context);
        let carried = experiment::carried(further.experiment, here, there, &fit.terms);
        let mut posture_context = problem.data.posture_context.clone();
        let mut penalty = 0.0;
        if !problem.slack_joints(&carried.terms).is_empty() {
            let unknowns = carried.unknowns(&fit.unknowns);
            let sides = backlash_sides::settle(problem, &carried.terms, &unknowns, Some(fit));
            penalty = sides.penalty;
            posture_context.clone_from(&sides.posture_context);
        }
        Log {
            problem,
            carried,
            posture_context,
            penalty,
        }
    }

    fn state(&self, unknowns: &[f64]) -> State {
        let terms = &self.carried.terms;
        let unknowns = self.carried.unknowns(unknowns);
        let masses = self.problem.masses(terms);
        self.problem
            .squares(terms, unknowns, &self.posture_context, &None, masses)
    }

    /// What is left of this log where the unknowns of all are those of `fit`.
    fn stated(&self, fit: &Fit) -> Fit {
        let state = self.state(&fit.unknowns);
        let unknowns = state.unknowns.len();
        Fit {
            terms: self.carried.terms.clone(),
            unknowns: state.unknowns,
            covariance: DMatrix::zeros(unknowns, unknowns),
            objective: state.value,
            penalty: 0.0,
            predicted: Arc::new(state.predicted),
            residual: Arc::new(state.residual),
            slopes: Arc::new(state.slopes),
            closed: state.closed,
            sides: Some(self.problem.sides_of(&self.posture_context)),
            outliers: None,
            flipped: Vec::new(),
            at_bound: 0.0,
            masses: None,
        }
    }

    /// Add what this log at `state` says of the unknowns of all.
    fn add(&self, state: &State, (normal, gradient): &mut (DMatrix<f64>, DVector<f64>)) {
        for (a, &(to_a, sign_a)) in self.carried.columns.iter().enumerate() {
            gradient[to_a] += sign_a * state.normal.1[a];
            for (b, &(to_b, sign_b)) in self.carried.columns.iter().enumerate() {
                normal[(to_a, to_b)] += sign_a * sign_b * state.normal.0[(a, b)];
            }
        }
    }

    /// Add how far noise that lasts in this log spreads the gradient of the unknowns of all.
    /// `all`: how many these are.
    fn add_spread(&self, state: &State, all: usize, spread: &mut Option<DMatrix<f64>>) {
        let masses = self.problem.masses(&self.carried.terms);
        let Some(own) = self.problem.lasting_spread(state, &None, masses) else {
            return;
        };
        let sum = spread.get_or_insert_with(|| DMatrix::zeros(all, all));
        for (a, &(to_a, sign_a)) in self.carried.columns.iter().enumerate() {
            for (b, &(to_b, sign_b)) in self.carried.columns.iter().enumerate() {
                sum[(to_a, to_b)] += sign_a * sign_b * own[(a, b)];
            }
        }
    }
}

/// All logs at the unknowns of the `first`: their value and slopes, and what the first predicts.
fn joint(mut first: State, logs: &[Log]) -> State {
    for log in logs {
        let state = log.state(&first.unknowns);
        first.value += state.value + log.penalty;
        log.add(&state, &mut first.normal);
    }
    first
}
