//! Explanations about the masses at which their fit ends, stated as their model file predicts them.
//!
//! The search takes ∂h/∂r from the robot without effects and r_b = r₀: the product of an
//! effect and a mass error is left out. Where both are large (a gain of 2, free masses) the
//! file that holds both would not predict what was stated. Here ∂h/∂r and r_b are taken
//! where the explanation ended, and it is fitted again, until nothing changes. Further logs are
//! taken about their own masses in the same way, and fitted with the first.
//!
//! On which side of its dead band a loose joint rests, a log shows; a model file works it
//! out from its own masses. Where these are loosely known, the sides that fit a log and the
//! sides that the fitted masses ask for can exchange each other without end. So of the fits
//! about one point of masses after the other the one is taken whose own masses predict the
//! log best, and what it leaves is what the diagnosis states:
//!
//! ```text
//! min Σ_k χ²_k(e, r)      sides = sign τ(e, r), or what the log knows of a joint near no moment
//! ```

use std::sync::Arc;

use sesc_model::effects::{self, Instance, PostureContext};
use sesc_model::tape::{Tape, Values};

use super::criteria::resting::{FLIPPED, GAIN, MOST, SHORTEST};
use super::exact::{Exact, masses_of};
use super::further_logs::{self, FurtherLog, fitted_again};
use super::hypothesis::effects_of;
use super::problem::{Fit, Problem, backlash_sides};
use crate::evaluate::FASTEST;

/// Rounds, at most.
const ROUNDS: usize = 12;

/// `problem` and `fit` of all logs about the masses at which the fit ends; `None` where those of
/// CAD do.
pub(super) fn settle<'m>(
    problem: &Problem<'m>,
    fit: &Fit,
    further: &[FurtherLog],
) -> Option<(Problem<'m>, Fit)> {
    if effects_of(&fit.terms).is_empty() {
        return None;
    }
    let exact = Exact::new(problem, fit);
    // On which side a loose joint rests, the file decides by its own masses.
    if fit.terms.iter().any(|term| term.dead_band().is_some()) {
        return Some(at_rest(&exact, problem, fit, further));
    }
    if exact.agrees(problem, fit) {
        return None;
    }
    let (mut own, mut fit) = (problem.clone(), fit.clone());
    for _ in 0..ROUNDS {
        own = exact.about(&own, &fit, masses_of(&own, &fit));
        fit = fitted_again(&own, &fit, further);
        if exact.agrees(&own, &fit) {
            break;
        }
    }
    Some((own, fit))
}

/// `problem` and `fit` about masses whose own sides predict the log as stated.
fn at_rest<'m>(
    exact: &Exact,
    problem: &Problem<'m>,
    fit: &Fit,
    further: &[FurtherLog],
) -> (Problem<'m>, Fit) {
    let predictions = Predictions::new(problem, &effects_of(&fit.terms));
    let stated = |problem: &Problem, fit: &Fit, masses: Vec<f64>| Stated {
        misfit: predictions.misfit(problem, fit, &masses),
        fit: fit.clone(),
        masses,
    };
    let mut best = stated(problem, fit, masses_of(problem, fit));
    if !problem.is_wider() {
        // A prior that holds no masses lets those of light links be anything.
        let usual = stated(problem, fit, usual_masses(problem, fit));
        if usual.misfit < best.misfit {
            best = usual;
        }
    }
    let (mut about, mut part) = (best.masses.clone(), 1.0);
    for _ in 0..ROUNDS {
        let own = exact.about(problem, &best.fit, about.clone());
        let next = further_logs::fitted_again(&own, &best.fit, further);
        let next = stated(&own, &next, masses_of(&own, &next));
        let end = next.masses.clone();
        if next.misfit < (1.0 - GAIN) * best.misfit {
            best = next;
        } else {
            part *= 0.5;
            if part < SHORTEST {
                break;
            }
        }
        for (about, end) in about.iter_mut().zip(&end) {
            *about += part * (end - *about);
        }
    }
    let own = exact.about(problem, &best.fit, best.masses.clone());
    let stated = predictions.stated(&own, best, further);
    (own, stated)
}

/// Masses that CAD's usual tolerances and the residuals of a fit suggest, m.
fn usual_masses(problem: &Problem, fit: &Fit) -> Vec<f64> {
    let shift = &problem.wide_prior * problem.wide.posterior_mean(&fit.residual);
    let masses = problem.cad.iter().zip(shift.iter());
    masses.map(|(cad, shift)| cad + shift).collect()
}

/// A fit with the masses that its file would hold.
struct Stated {
    fit: Fit,
    /// Base parameters, m.
    masses: Vec<f64>,
    /// χ² that the file leaves.
    misfit: f64,
}

/// What a model file with these effects predicts of the log.
pub(super) struct Predictions {
    tape: Tape,
    dof: usize,
}

impl Predictions {
    pub fn new(problem: &Problem, effects: &[Instance]) -> Predictions {
        let program = effects::resting_reading(&problem.context, effects);
        Predictions {
            tape: Tape::new(&program),
            dof: problem.context.robot.dof(),
        }
    }

    /// Per posture the reading (x, y), m, and how far into its dead band each joint is.
    fn run(&self, problem: &Problem, unknowns: &[f64], masses: &[f64]) -> Vec<f64> {
        let arguments = [
            Values::PerPosture(&problem.data.q),
            Values::Shared(unknowns),
            Values::PerPosture(&problem.data.posture_context),
            Values::Shared(masses),
        ];
        let n = problem.data.len();
        let mut out = vec![0.0; n * self.tape.outputs()];
        self.tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Readings of the log's postures, m.
    pub fn readings(&self, problem: &Problem, unknowns: &[f64], masses: &[f64]) -> Vec<f64> {
        let out = self.run(problem, unknowns, masses);
        let postures = out.chunks_exact(self.tape.outputs());
        postures
            .flat_map(|posture| [posture[0], posture[1]])
            .collect()
    }

    /// χ² that a fit leaves where its file holds these masses.
    fn misfit(&self, problem: &Problem, fit: &Fit, masses: &[f64]) -> f64 {
        let predicted = self.readings(problem, &fit.unknowns, masses);
        let square = |row: usize| {
            let error = (problem.data.reading[row] - predicted[row]) * problem.weight[row];
            error * error
        };
        let of = |k: usize| match fit.flipped.contains(&k) {
            true => FLIPPED,
            // What is not a number counts as far off.
            false => MOST.min(square(2 * k) + square(2 * k + 1)),
        };
        (0..problem.data.len()).map(of).sum()
    }

    /// A fit, about its masses in `problem`, as its file predicts the log.
    fn stated(&self, problem: &Problem, of: Stated, further: &[FurtherLog]) -> Fit {
        let Stated { fit, masses, .. } = of;
        let layout = PostureContext::of(problem.context.robot);
        let width = self.tape.outputs();
        let out = self.run(problem, &fit.unknowns, &masses);
        let decided = backlash_sides::settle(problem, &fit.terms, &fit.unknowns, Some(&fit));
        let by_gravity = |k: &usize| !decided.flipped.contains(k);
        let postures = || (0..problem.data.len()).filter(by_gravity);
        let mut context = decided.posture_context;
        for k in postures() {
            for joint in 0..self.dof {
                context[k * layout.len() + layout.side(joint)] = out[k * width + 2 + joint];
            }
        }
        let errors = problem.masses(&fit.terms);
        let root = fit.outliers.as_ref().map(|o| o.root_weights(None));
        let unknowns = fit.unknowns.clone();
        let mut state = problem.state(&fit.terms, unknowns, &context, &root, errors);
        // Springs that give way while loose joints slide end a little elsewhere than springs
        // beside joints at rest: the file's own readings count.
        for row in postures().flat_map(|k| [2 * k, 2 * k + 1]) {
            let file = out[row / 2 * width + row % 2];
            let whitened = problem.weight[row];
            let back = problem.offset.as_ref().map_or(0.0, |offset| offset[row]) / whitened;
            state.predicted[row] = file - back;
            state.residual[row] = (problem.data.reading[row] - file + back) * whitened;
        }
        Fit {
            covariance: further_logs::covariance(problem, &fit, &state, further, &root, errors),
            unknowns: state.unknowns,
            predicted: Arc::new(state.predicted),
            residual: Arc::new(state.residual),
            slopes: Arc::new(state.slopes),
            closed: state.closed,
            at_bound: state.at_bound,
            sides: Some(problem.sides_of(&context)),
            flipped: decided.flipped,
            masses: Some(masses),
            ..fit
        }
    }
}
