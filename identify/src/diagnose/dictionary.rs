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

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, Dyn};

use super::criteria;
use super::hypothesis::{Term, effect_terms};
use super::nuisance::Nuisance;
use super::problem::{Block, Fit, Problem, side, stacked_residual, stacked_slopes};
use crate::fit::OFFSET;
use crate::lsq::{factor_normal, transposed_times};
use crate::threads::each_long;

/// Candidates whose columns are made and projected together.
const PART: usize = 64;

pub(super) struct Dictionary {
    pub candidates: Vec<Candidate>,
    /// Whitened slopes Z, all candidates side by side.
    slopes: DMatrix<f64>,
    /// Zᵀ S Z of each candidate, the same for all residuals: beside masses within the prior, and
    /// within the usual tolerances of CAD.
    squares: [Vec<DMatrix<f64>>; 2],
}

pub(super) struct Candidate {
    pub term: Term,
    /// Its column is what a start does, for effects that have no slope at none.
    started: bool,
    from: usize,
    count: usize,
}

impl Dictionary {
    /// Slopes at joint positions `q` of each block, those of the logs unless given.
    pub(super) fn new(problem: &Problem, q: Option<&[Vec<f64>]>) -> Dictionary {
        let context = problem.context();
        let blocks = problem.blocks.iter().enumerate();
        let contexts =
            blocks.map(|(at, block)| sides_at(block, q.map_or(&block.data.q, |q| &q[at])).into());
        let contexts: Vec<Cow<[f64]>> = contexts.collect();
        let predicted =
            |terms: &[Term], unknowns: &[f64]| problem.predict(terms, unknowns, &contexts, q);
        let none = stacked_residual(&predicted(&[], &[]));
        let terms = effect_terms(context);
        let rows = none.len();
        let count: usize = terms.iter().map(|term| term.unknowns(context)).sum();
        let mut candidates = Vec::new();
        let mut columns: Vec<f64> = Vec::with_capacity(rows * count);
        let of = |term: &Term| -> (bool, DMatrix<f64>) {
            let own = std::slice::from_ref(term);
            let starts = term.starts(context);
            if starts.len() == 1 {
                let slopes = predicted(own, &starts[0]);
                return (false, stacked_slopes(&slopes, term.unknowns(context)));
            }
            // No slope at none: what each start does, as one direction each, of which the
            // strongest stands for it.
            let with = stacked_residual(&predicted(own, &starts[starts.len() / 3]));
            // A residual falls by what its prediction rises.
            (true, DMatrix::from_columns(&[&none - with]))
        };
        let unknown = |term: &&Term| term.unknowns(context) > 0;
        let terms: Vec<&Term> = terms.iter().filter(unknown).collect();
        for some in terms.chunks(PART) {
            for (term, (started, own)) in some.iter().zip(each_long(some, |term| of(term))) {
                candidates.push(Candidate {
                    started,
                    term: (*term).clone(),
                    from: columns.len() / rows,
                    count: own.ncols(),
                });
                columns.extend_from_slice(own.as_slice());
            }
        }
        let mut dictionary = Dictionary {
            slopes: DMatrix::from_vec(rows, columns.len() / rows, columns),
            squares: [Vec::new(), Vec::new()],
            candidates,
        };
        let own = dictionary.squares_beside(problem, problem.masses(&[]));
        let wide = match problem.is_wider() {
            true => dictionary.squares_beside(problem, problem.masses(&[Term::Masses])),
            false => own.clone(),
        };
        dictionary.squares = [own, wide];
        dictionary
    }

    /// Zᵀ S Z of each candidate.
    fn squares_beside(&self, problem: &Problem, masses: &Nuisance) -> Vec<DMatrix<f64>> {
        let mut squares = Vec::new();
        self.in_parts(problem, masses, |some, slopes, left| {
            let first = some[0].from;
            squares.extend(some.iter().map(|c| {
                let own = |all: &DMatrix<f64>| all.columns(c.from - first, c.count).into_owned();
                own(slopes).tr_mul(&own(left))
            }));
        });
        squares
    }

    /// Each in turn of a few candidates, with their slopes Z and S Z: those of all would take
    /// as much memory again.
    fn in_parts(
        &self,
        problem: &Problem,
        masses: &Nuisance,
        mut each: impl FnMut(&[Candidate], &DMatrix<f64>, &DMatrix<f64>),
    ) {
        for some in self.candidates.chunks(PART) {
            let (first, last) = (&some[0], &some[some.len() - 1]);
            let count = last.from + last.count - first.from;
            let slopes = self.slopes.columns(first.from, count).into_owned();
            let left = problem.project_out(masses, &slopes);
            each(some, &slopes, &left);
        }
    }

    /// Each candidate's term with its slopes, whitened.
    pub(super) fn of_each(&self) -> impl Iterator<Item = (&Term, DMatrixView<'_, f64>)> {
        let of = |c: &Candidate| self.slopes.columns(c.from, c.count);
        self.candidates.iter().map(move |c| (&c.term, of(c)))
    }

    /// χ² that each candidate of ordinary size would have in this log.
    pub(super) fn visible(&self, problem: &Problem) -> Vec<(Term, f64)> {
        let of = |(c, square): (&Candidate, &DMatrix<f64>)| {
            let scales = c.term.scales(problem.context());
            let ordinary = match c.count == scales.len() && !c.started {
                true => DVector::from_vec(scales),
                false => DVector::from_element(c.count, 1.0),
            };
            let chi2 = ordinary.dot(&(square * &ordinary));
            (c.term.clone(), chi2.max(0.0))
        };
        self.candidates
            .iter()
            .zip(&self.squares[0])
            .map(of)
            .collect()
    }

    /// What an offset of readings costs whose prior has the likeliest of some deviations (m), where
    /// nothing is missing beside it.
    ///
    /// ```text
    /// price(σ) = bᵀ A⁻¹ b − bᵀ (A + 1/σ²)⁻¹ b + log det(1 + σ² A)
    /// ```
    pub(super) fn price_of_offset(&self, null: &Fit, problem: &Problem) -> Option<(Term, f64)> {
        let is_offset = |c: &Candidate| c.term.name() == OFFSET;
        let place = self.candidates.iter().position(is_offset)?;
        let (own, a) = (&self.candidates[place], &self.squares[0][place]);
        let left = problem.project_out_one(problem.masses(&[]), &null.residual());
        let b = self.slopes.columns(own.from, own.count).tr_mul(&left);
        let gain = b.dot(&a.clone().cholesky()?.solve(&b));
        // Free masses take all of an offset: then data say nothing of it.
        let tells = |std: f64| (0..own.count).all(|k| std * std * a[(k, k)] > 1.0);
        let price = |std: &f64| {
            let mut held = a.clone();
            (0..own.count).for_each(|k| held[(k, k)] += 1.0 / (std * std));
            let factor = held.cholesky()?;
            let log_det = factor.l_dirty().diagonal().map(|x| (x * std).ln()).sum();
            let price = gain - b.dot(&factor.solve(&b)) + 2.0 * log_det;
            (tells(*std) && price > 0.0).then_some(price)
        };
        let prices = problem.offset_stds.iter().filter_map(price);
        Some((own.term.clone(), prices.min_by(f64::total_cmp)?))
    }

    /// How far each candidate would lower the objective of `fit`, to first order.
    pub(super) fn gains(&self, fit: &Fit, problem: &Problem) -> Vec<f64> {
        let beside = Beside::new(problem, fit, None);
        let products = transposed_times(&self.slopes, &beside.left);
        let squares = &self.squares[usize::from(fit.frees_masses())];
        let candidates = self.candidates.iter().zip(squares);
        let gains = candidates.map(|(c, square)| {
            let own = products.rows(c.from, c.count).into_owned();
            gain(square, beside.rest(square.clone(), &own))
        });
        gains.collect()
    }

    /// Gains of one candidate with whitened residuals of another model of the same
    /// slopes, `left` of which is no mass error: for wiring faults, tried by the hundred.
    pub(super) fn gains_of(&self, left: &DVector<f64>) -> Vec<f64> {
        let b = self.slopes.tr_mul(left);
        let candidates = self.candidates.iter().zip(&self.squares[0]);
        let gains = candidates.map(|(c, square)| {
            let b = b.rows(c.from, c.count).into_owned();
            gain(square, (square.clone(), b))
        });
        gains.collect()
    }

    /// Every pair's gain, by their places among the candidates.
    pub(super) fn pairs(
        &self,
        problem: &Problem,
        residual: &DVector<f64>,
        mut each: impl FnMut(usize, usize, f64),
    ) {
        let width = self.slopes.ncols();
        let mut gram = DMatrix::zeros(width, width);
        self.in_parts(problem, problem.masses(&[]), |some, slopes, left| {
            gram.columns_mut(some[0].from, slopes.ncols())
                .copy_from(&transposed_times(&self.slopes, left));
        });
        let left = problem.project_out_one(problem.masses(&[]), residual);
        let b = self.slopes.tr_mul(&left);
        let square = |c: &Candidate| {
            let own = gram.view((c.from, c.from), (c.count, c.count));
            own.into_owned()
        };
        for (i, first) in self.candidates.iter().enumerate() {
            let Some(factor) = safe(square(first), &square(first)).cholesky() else {
                continue;
            };
            let ba = b.rows(first.from, first.count).into_owned();
            let solved = factor.solve(&ba);
            let alone = ba.dot(&solved);
            for (j, second) in self.candidates.iter().enumerate().skip(i + 1) {
                let cross = gram.view((second.from, first.from), (second.count, first.count));
                let whole = square(second);
                let a = &whole - cross * factor.solve(&cross.transpose());
                let b = b.rows(second.from, second.count) - cross * &solved;
                each(i, j, alone + gain(&whole, (a, b)));
            }
        }
    }
}

/// What a hypothesis leaves, to first order: of the residuals, and of columns beside its own.
pub(super) struct Beside {
    /// S times its slopes and, behind them, what it leaves.
    pub left: DMatrix<f64>,
    /// Of its own unknowns, with what is left of their gradient.
    own: Option<(Cholesky<f64, Dyn>, DVector<f64>)>,
}

impl Beside {
    /// In all rows, or in some of them as if these were all.
    pub(super) fn new(problem: &Problem, fit: &Fit, rows: Option<&[usize]>) -> Beside {
        let own = fit.unknowns.len();
        // Slopes count as they are, residuals by their weights.
        let weighting = problem.weighting(&fit.terms, fit.outliers.as_ref());
        let mut all = fit.slopes().insert_column(own, 0.0);
        all.set_column(own, &weighting.residual(fit));
        let mut left = problem.project_out(problem.masses(&fit.terms), &all);
        if let Some(rows) = rows {
            (all, left) = (all.select_rows(rows), left.select_rows(rows));
        }
        let of_own = transposed_times(&all, &left);
        let factor = factor_normal(of_own.view((0, 0), (own, own)).into_owned());
        let pull = of_own.view((0, own), (own, 1)).column(0).into_owned();
        Beside {
            left,
            own: factor.filter(|_| own > 0).map(|factor| (factor, pull)),
        }
    }

    /// What is left of a square `a` and of the gradient of columns once the hypothesis has taken
    /// its part, by their `products` with what it leaves.
    pub(super) fn rest(
        &self,
        mut a: DMatrix<f64>,
        products: &DMatrix<f64>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let own = products.ncols() - 1;
        let mut b = products.column(own).into_owned();
        if let Some((factor, pull)) = &self.own {
            let cross = products.columns(0, own).into_owned();
            a -= &cross * factor.solve(&cross.transpose());
            b -= cross * factor.solve(pull);
        }
        (a, b)
    }
}

/// `bᵀ A⁻¹ b` where others have left so much of A, a `square`, and of b; directions that they
/// have copied are left out.
fn gain(square: &DMatrix<f64>, (a, b): (DMatrix<f64>, DVector<f64>)) -> f64 {
    match safe(a, square).cholesky() {
        Some(factor) => b.dot(&factor.solve(&b)).max(0.0),
        None => 0.0,
    }
}

/// A matrix that can be solved where its columns are copies of others.
fn safe(mut a: DMatrix<f64>, whole: &DMatrix<f64>) -> DMatrix<f64> {
    for k in 0..a.nrows() {
        a[(k, k)] += criteria::COPIED * whole[(k, k)] + 1e-12;
    }
    a
}

/// Posture context with every joint on the side where gravity puts it.
fn sides_at(block: &Block, q: &[f64]) -> Vec<f64> {
    let mut posture_context = block.data.posture_context.clone();
    let (dof, moments) = (block.context.robot.dof(), block.moments_at(q));
    block.put_sides(&mut posture_context, 0..dof, |k, joint, _| {
        side(moments[k * 3 * dof + joint])
    });
    posture_context
}
