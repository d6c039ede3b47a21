//! What every candidate would do to the readings, to first order.
//!
//! ```text
//! Z_c = ∂y/∂e_c at no effect       G = Zᵀ S Z       gain_c = bᵀ A⁻¹ b
//! ```
//!
//! with `A` and `b` what is left of `G_cc` and `Z_cᵀ S residual` once the unknowns
//! of the current hypothesis take their part. S: no mass error, see `nuisance`. Of a log of
//! both feet the rows of the soles stand below those of the readings.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::PostureContext;

use super::criteria;
use super::hypothesis::{Term, effect_terms};
use super::problem::{ALL, Block, Fit, Problem, stacked_residual, stacked_slopes};
use crate::lsq::{factor_normal, transposed_times};

pub struct Dictionary {
    pub candidates: Vec<Candidate>,
    /// Whitened slopes, all candidates side by side, and S times them.
    slopes: DMatrix<f64>,
    projected: DMatrix<f64>,
    /// Products of each candidate's columns with their projections: the same for all residuals.
    squares: Vec<DMatrix<f64>>,
    gram: Option<DMatrix<f64>>,
}

pub struct Candidate {
    pub term: Term,
    /// Its column is what a start does, for effects that have no slope at none.
    started: bool,
    from: usize,
    count: usize,
}

impl Dictionary {
    /// Slopes at joint positions `q` of each block, those of the logs unless given.
    pub fn new(problem: &Problem, q: Option<&[Vec<f64>]>) -> Dictionary {
        let context = &problem.first.context;
        let contexts: Vec<Cow<[f64]>> = problem
            .blocks()
            .enumerate()
            .map(|(at, block)| sides_at(block, q.map_or(&block.data.q, |q| &q[at])).into())
            .collect();
        let predicted =
            |terms: &[Term], unknowns: &[f64]| problem.predict(terms, unknowns, &contexts, q);
        let none = stacked_residual(predicted(&[], &[]).iter());
        let mut candidates = Vec::new();
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for term in effect_terms(context) {
            let count = term.unknowns(context);
            if count == 0 {
                continue;
            }
            let from = columns.len();
            let own = std::slice::from_ref(&term);
            let starts = term.starts(context);
            if starts.len() == 1 {
                let slopes = stacked_slopes(predicted(own, &starts[0]).iter(), count);
                columns.extend(slopes.column_iter().map(|column| column.into_owned()));
            } else {
                // No slope at none: what each start does, as one direction each,
                // of which the strongest stands for it.
                let middle = &starts[starts.len() / 3];
                let with = stacked_residual(predicted(own, middle).iter());
                // A residual falls by what its prediction rises.
                columns.push(&none - with);
            }
            candidates.push(Candidate {
                started: starts.len() > 1,
                term,
                from,
                count: columns.len() - from,
            });
        }
        let slopes = match columns.is_empty() {
            true => DMatrix::zeros(none.len(), 0),
            false => DMatrix::from_columns(&columns),
        };
        let projected = problem.project_out(&problem.nuisance, &slopes);
        let square = |c: &Candidate| {
            let columns = slopes.columns(c.from, c.count);
            columns.tr_mul(&projected.columns(c.from, c.count))
        };
        Dictionary {
            squares: candidates.iter().map(square).collect(),
            candidates,
            slopes,
            projected,
            gram: None,
        }
    }

    /// χ² that each candidate of ordinary size would have in this log.
    pub fn visible(&self, problem: &Problem) -> Vec<(Term, f64)> {
        let of = |c: &Candidate| {
            let scales = c.term.scales(&problem.first.context);
            let ordinary = match c.count == scales.len() && !c.started {
                true => DVector::from_vec(scales),
                false => DVector::from_element(c.count, 1.0),
            };
            let z = self.slopes.columns(c.from, c.count);
            let sz = self.projected.columns(c.from, c.count);
            let chi2 = (sz * &ordinary).dot(&(z * &ordinary));
            (c.term.clone(), chi2.max(0.0))
        };
        self.candidates.iter().map(of).collect()
    }

    /// How far each candidate would lower the objective of `fit`, to first order.
    pub fn gains(&self, fit: &Fit, problem: &Problem) -> Vec<f64> {
        let masses = problem.masses(&fit.terms);
        let (mut residual, own) = (fit.residual(), fit.slopes());
        let root = problem.root_weights(fit, ALL);
        let weights = root.iter().flatten();
        residual.iter_mut().zip(weights).for_each(|(e, w)| *e *= w);
        let left = problem.project_out_one(masses, &residual);
        let own_projected = problem.project_out(masses, &own);
        let factor = factor_normal(own.tr_mul(&own_projected));
        let of_own = own.tr_mul(&left);
        self.candidates
            .iter()
            .zip(&self.squares)
            .map(|(c, square)| {
                let z = self.slopes.columns(c.from, c.count);
                let sz = self.projected.columns(c.from, c.count);
                let mut a = square.clone();
                let mut b = z.tr_mul(&left);
                let whole: Vec<f64> = (0..c.count).map(|k| a[(k, k)]).collect();
                if let (Some(factor), true) = (&factor, own.ncols() > 0) {
                    let cross = sz.tr_mul(&own);
                    a -= &cross * factor.solve(&cross.transpose());
                    b -= &cross * factor.solve(&of_own);
                }
                gain(a, &b, &whole)
            })
            .collect()
    }

    /// Gains of one candidate with whitened residuals of another model of the same
    /// slopes: for wiring faults, tried by the hundred.
    pub fn gains_of(&self, residual: &DVector<f64>) -> Vec<f64> {
        let b = self.projected.tr_mul(residual);
        self.candidates
            .iter()
            .zip(&self.squares)
            .map(|(c, a)| {
                let whole: Vec<f64> = (0..c.count).map(|k| a[(k, k)]).collect();
                gain(a.clone(), &b.rows(c.from, c.count).into_owned(), &whole)
            })
            .collect()
    }

    /// Every pair's gain: (first, second, gain).
    pub fn pairs(&mut self, residual: &DVector<f64>) -> Vec<(usize, usize, f64)> {
        if self.gram.is_none() {
            self.gram = Some(transposed_times(&self.slopes, &self.projected));
        }
        let gram = self.gram.as_ref().expect("made above");
        let b = self.projected.tr_mul(residual);
        let mut pairs = Vec::new();
        for (i, first) in self.candidates.iter().enumerate() {
            let aa = gram
                .view((first.from, first.from), (first.count, first.count))
                .into_owned();
            let mut safe = aa.clone();
            for k in 0..first.count {
                safe[(k, k)] = safe[(k, k)] * (1.0 + criteria::COPIED) + 1e-12;
            }
            let Some(factor) = safe.cholesky() else {
                continue;
            };
            let ba = b.rows(first.from, first.count).into_owned();
            let alone = ba.dot(&factor.solve(&ba));
            let solved = factor.solve(&ba);
            for (j, second) in self.candidates.iter().enumerate().skip(i + 1) {
                let cross = gram.view((second.from, first.from), (second.count, first.count));
                let mut a = gram
                    .view((second.from, second.from), (second.count, second.count))
                    .into_owned();
                let whole: Vec<f64> = (0..second.count).map(|k| a[(k, k)]).collect();
                a -= cross * factor.solve(&cross.transpose());
                let bb = b.rows(second.from, second.count) - cross * &solved;
                pairs.push((i, j, alone + gain(a, &bb, &whole)));
            }
        }
        pairs
    }
}

/// `bᵀ A⁻¹ b`, directions that others have copied (measured by `whole`) left out.
fn gain(mut a: DMatrix<f64>, b: &DVector<f64>, whole: &[f64]) -> f64 {
    for (k, whole) in whole.iter().enumerate() {
        a[(k, k)] += criteria::COPIED * whole + 1e-12;
    }
    match a.cholesky() {
        Some(factor) => b.dot(&factor.solve(b)).max(0.0),
        None => 0.0,
    }
}

/// Posture context with every joint on the side where gravity puts it.
fn sides_at(block: &Block, q: &[f64]) -> Vec<f64> {
    let layout = PostureContext::of(block.context.robot);
    let dof = block.context.robot.dof();
    let mut posture_context = block.data.posture_context.clone();
    let moments = block.moments_at(q);
    for k in 0..block.data.len() {
        for joint in 0..dof {
            let moment = moments[k * 3 * dof + joint];
            posture_context[k * layout.len() + layout.side(joint)] =
                if moment < 0.0 { -1.0 } else { 1.0 };
        }
    }
    posture_context
}
