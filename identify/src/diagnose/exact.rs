//! Readings of a log under an explanation, for any masses, and the problem about them.
//!
//! ```text
//! y(e, r) ≈ y(e, r_b) + ∂y/∂r (r − r_b)        ∂y/∂r by central differences about r_b
//! ```

use nalgebra::{DMatrix, DVector};
use sesc_model::effects;
use sesc_model::tape::{Tape, Values};

use super::criteria::exact::AGREES;
use super::hypothesis::effects_of;
use super::nuisance::Nuisance;
use super::problem::{Fit, Problem};
use crate::evaluate::FASTEST;
use crate::observations::postures::rms;

/// Parameters are moved by this part of the robot's reach for differences: readings are
/// linear in them but where joints bend.
const STEP: f64 = 1e-4;

/// Base parameters (m) at which a fit ends.
pub(super) fn masses_of(problem: &Problem, fit: &Fit) -> Vec<f64> {
    if let Some(masses) = &fit.masses {
        return masses.clone();
    }
    let factor = match fit.frees_masses() {
        true => &problem.wide_prior,
        false => &problem.prior,
    };
    let shift = factor * mass_errors(problem, fit);
    let cad = problem.cad.iter().zip(shift.iter());
    cad.map(|(r, d)| r + d).collect()
}

/// The most likely mass errors z, in units of F's columns.
fn mass_errors(problem: &Problem, fit: &Fit) -> DVector<f64> {
    let masses = problem.masses(&fit.terms);
    match &fit.outliers {
        None => masses.posterior_mean(&fit.residual),
        Some(outliers) => {
            let root = outliers.root_weights(None);
            let weighted = DVector::from_fn(root.len(), |row, _| fit.residual[row] * root[row]);
            masses.reweighted(&root).posterior_mean(&weighted)
        }
    }
}

/// Readings of the log under an explanation, for any masses.
pub(super) struct Exact {
    tape: Tape,
}

impl Exact {
    pub fn new(problem: &Problem, fit: &Fit) -> Exact {
        let program = effects::reading_of_masses(&problem.context, &effects_of(&fit.terms));
        Exact {
            tape: Tape::new(&program),
        }
    }

    fn readings(&self, problem: &Problem, fit: &Fit, r: &[f64]) -> Vec<f64> {
        let n = problem.data.len();
        let context = problem.posture_context_of(fit);
        let arguments = [
            Values::PerPosture(&problem.data.q),
            Values::Shared(&fit.unknowns),
            Values::PerPosture(&context),
            Values::Shared(r),
        ];
        let mut out = vec![0.0; 2 * n];
        self.tape.run(&arguments, n, &mut out, FASTEST);
        let moved = problem.motion_of(r);
        out.iter_mut().zip(moved).for_each(|(y, by)| *y += by);
        out
    }

    /// Whether the masses that are stated predict what is stated.
    pub fn agrees(&self, problem: &Problem, fit: &Fit) -> bool {
        let z = mass_errors(problem, fit);
        let stated = problem.masses(&fit.terms).shift(&z);
        let found = self.readings(problem, fit, &masses_of(problem, fit));
        let left = |row: usize| fit.residual[row] - stated[row];
        let apart = (0..found.len()).map(|row| {
            let predicted = (problem.data.reading[row] - found[row]) * problem.weight[row];
            predicted - left(row)
        });
        rms(apart) <= AGREES * rms((0..found.len()).map(left))
    }

    /// The problem about masses `r` (base parameters, m), its slopes under `fit`.
    pub fn about<'m>(&self, problem: &Problem<'m>, fit: &Fit, r: Vec<f64>) -> Problem<'m> {
        let rows = self.slopes(problem, fit, &r);
        let of = |prior: &DMatrix<f64>| Nuisance::new(&rows, prior, &problem.weight);
        let (nuisance, wide) = (of(&problem.prior), of(&problem.wide_prior));
        let errors = r.iter().zip(&problem.cad).map(|(r, cad)| r - cad);
        let mut offset = &rows * DVector::from_iterator(r.len(), errors);
        for (shift, weight) in offset.iter_mut().zip(&problem.weight) {
            *shift *= weight;
        }
        problem.about(r, rows, nuisance, wide, offset)
    }

    /// ∂y/∂r, 2n × p, by central differences.
    fn slopes(&self, problem: &Problem, fit: &Fit, r: &[f64]) -> DMatrix<f64> {
        let step = STEP * problem.model.reach();
        let mut rows = DMatrix::zeros(2 * problem.data.len(), r.len());
        for k in 0..r.len() {
            let at = |by: f64| {
                let mut moved = r.to_vec();
                moved[k] += by;
                self.readings(problem, fit, &moved)
            };
            let (ahead, back) = (at(step), at(-step));
            for (row, (a, b)) in ahead.iter().zip(&back).enumerate() {
                rows[(row, k)] = (a - b) / (2.0 * step);
            }
        }
        rows
    }
}
