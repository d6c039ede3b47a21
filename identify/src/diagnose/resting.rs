//! Explanations with dead bands, stated as their model file predicts them.
//!
//! On which side of its dead band a loose joint rests, a log shows; a model file works it
//! out from its own masses. Where these are loosely known, the sides that fit a log and the
//! sides that the fitted masses ask for can exchange each other without end. So unknowns e
//! and masses r are those, on the way of the fit, whose own sides predict the log best,
//!
//! ```text
//! min Σ_k min(χ²_k(e, r), most)      sides = sign τ(e, r)
//! ```
//!
//! and what they leave is what the diagnosis states.

use std::rc::Rc;

use sesc_model::effects::{self, Instance, PostureContext};
use sesc_model::tape::{Tape, Values};

use super::backlash_sides;
use super::exact::{Exact, masses_of};
use super::hypothesis::effects_of;
use super::problem::{ALL, Fit, Problem};
use crate::evaluate::FASTEST;
use crate::lsq::damped;

/// Rounds, at most.
const ROUNDS: usize = 12;
/// χ² that one posture counts, at most: its side may be one that gravity does not decide.
const MOST: f64 = 9.0;
/// Parts of the way to the next fit that are tried.
const STEPS: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.03, 0.01];
/// A step that gains less, as a part of the misfit, is not taken.
const GAIN: f64 = 1e-4;

/// `problem` and `fit` about masses whose own sides predict the log as stated.
pub(super) fn settle<'m>(exact: &Exact, problem: &Problem<'m>, fit: &Fit) -> (Problem<'m>, Fit) {
    let predictions = Predictions::new(problem, &effects_of(&fit.terms));
    let mut at = Point {
        unknowns: fit.unknowns.clone(),
        masses: masses_of(problem, fit),
    };
    // Masses that no prior holds may be anything where the log says little of them.
    let usual = Point {
        unknowns: fit.unknowns.clone(),
        masses: usual_masses(problem, fit),
    };
    let mut misfit = predictions.misfit(problem, &at);
    let of_usual = predictions.misfit(problem, &usual);
    if of_usual < misfit {
        (at, misfit) = (usual, of_usual);
    }
    let mut own = exact.about(problem, fit, at.masses.clone());
    let mut last = own.fit(&fit.terms, Some(&at.unknowns), ALL);
    for _ in 0..ROUNDS {
        let end = Point {
            unknowns: last.unknowns.clone(),
            masses: masses_of(&own, &last),
        };
        let tried = STEPS.iter().map(|part| {
            let point = at.towards(&end, *part);
            (predictions.misfit(problem, &point), point)
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((found, point)) = best.filter(|best| best.0 < (1.0 - GAIN) * misfit) else {
            break;
        };
        (at, misfit) = (point, found);
        own = exact.about(&own, &last, at.masses.clone());
        last = own.fit(&fit.terms, Some(&at.unknowns), ALL);
    }
    let stated = predictions.stated(&own, last, at);
    (own, stated)
}

/// Masses that CAD's usual tolerances and the residuals of a fit suggest, m.
fn usual_masses(problem: &Problem, fit: &Fit) -> Vec<f64> {
    let shift = &problem.wide_prior * problem.wide.posterior_mean(&fit.residual);
    let masses = problem.cad.iter().zip(shift.iter());
    masses.map(|(cad, shift)| cad + shift).collect()
}

/// Unknowns and masses of an explanation.
struct Point {
    unknowns: Vec<f64>,
    masses: Vec<f64>,
}

impl Point {
    /// `part` of the way to `end`.
    fn towards(&self, end: &Point, part: f64) -> Point {
        let between = |from: &[f64], to: &[f64]| -> Vec<f64> {
            let pairs = from.iter().zip(to);
            pairs.map(|(from, to)| from + part * (to - from)).collect()
        };
        Point {
            unknowns: between(&self.unknowns, &end.unknowns),
            masses: between(&self.masses, &end.masses),
        }
    }
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

    fn misfit(&self, problem: &Problem, at: &Point) -> f64 {
        let predicted = self.readings(problem, &at.unknowns, &at.masses);
        let error = |row: usize| {
            let error = (problem.data.reading[row] - predicted[row]) * problem.weight[row];
            error * error
        };
        let postures = 0..problem.data.len();
        let of = postures.map(|k| (error(2 * k) + error(2 * k + 1)).min(MOST));
        // What is not finite counts as a posture that is far off.
        of.map(|chi2| if chi2.is_nan() { MOST } else { chi2 }).sum()
    }

    /// `last`, fitted about the masses of a point, as the file of this point predicts the log.
    fn stated(&self, problem: &Problem, last: Fit, at: Point) -> Fit {
        let layout = PostureContext::of(problem.context.robot);
        let width = self.tape.outputs();
        let out = self.run(problem, &at.unknowns, &at.masses);
        let decided = backlash_sides::settle(problem, &last.terms, &at.unknowns, Some(&last));
        let by_gravity = |k: &usize| !decided.flipped.contains(k);
        let postures = || (0..problem.data.len()).filter(by_gravity);
        let mut context = decided.posture_context.to_vec();
        for k in postures() {
            for joint in 0..self.dof {
                context[k * layout.len() + layout.side(joint)] = out[k * width + 2 + joint];
            }
        }
        let masses = problem.masses(&last.terms);
        let root = last.outliers.as_ref().map(|o| o.root_weights(None));
        let mut state = problem.state(&last.terms, at.unknowns, &context, &root, masses);
        // Springs that give way while loose joints slide end a little elsewhere than springs
        // beside joints at rest: the file's own readings count.
        for row in postures().flat_map(|k| [2 * k, 2 * k + 1]) {
            let file = out[row / 2 * width + row % 2];
            let whitened = problem.weight[row];
            let back = problem.offset.as_ref().map_or(0.0, |offset| offset[row]) / whitened;
            state.predicted[row] = file - back;
            state.residual[row] = (problem.data.reading[row] - file + back) * whitened;
        }
        let scales = problem.scales(&last.terms);
        Fit {
            covariance: damped::covariance(&state.normal.0, &scales),
            unknowns: state.unknowns,
            predicted: state.predicted,
            residual: state.residual,
            slopes: state.slopes,
            at_bound: state.at_bound,
            posture_context: Some(Rc::new(context)),
            flipped: decided.flipped,
            masses: Some(at.masses),
            ..last
        }
    }
}
