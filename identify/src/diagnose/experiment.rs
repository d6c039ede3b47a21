//! Experiments that could tell explanations apart, and what each would show.
//!
//! ```text
//! S_j = min over δ, z of ‖(y_i − y_j − J_j δ − K z)/σ‖² + ‖z‖²     old and new rows
//! ```
//!
//! the χ² by which explanation j would fail, its unknowns fitted again, if i
//! were true. From [`TOLD_APART`](super::criteria::TOLD_APART) on it tells the two apart.

use super::hypothesis::{CarriedExplanation, Term, carried, with_places};
use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{Experiment, PostureContext, known_weight};
use sesc_model::{Function, Model};

use super::criteria;
use super::problem::{Block, Fit, Problem};
use crate::evaluate::Evaluator;

/// The experiment of this name whose log says all that there is to know of it: not
/// the size of a weight, nor from where a posture was approached.
pub fn of_log(name: &str) -> Option<Experiment> {
    let told = |experiment: &Experiment| {
        !matches!(experiment, Experiment::KnownWeight | Experiment::BothSides)
    };
    let mut all = Experiment::ALL.into_iter().filter(told);
    all.find(|experiment| experiment.name() == name)
}

/// Postures to be taken, with their context.
pub struct Postures<'m> {
    pub model: &'m Model,
    pub q: Vec<f64>,
    pub posture_context: Vec<f64>,
}

/// Whitened readings of an explanation and their slopes by its unknowns.
struct WhitenedReadings {
    value: DVector<f64>,
    slopes: DMatrix<f64>,
}

impl WhitenedReadings {
    fn below(self, more: WhitenedReadings) -> WhitenedReadings {
        let (a, b) = (self.value.len(), more.value.len());
        let p = self.slopes.ncols();
        let mut rows = WhitenedReadings {
            value: DVector::zeros(a + b),
            slopes: DMatrix::zeros(a + b, p),
        };
        rows.value.rows_mut(0, a).copy_from(&self.value);
        rows.value.rows_mut(a, b).copy_from(&more.value);
        rows.slopes.rows_mut(0, a).copy_from(&self.slopes);
        rows.slopes.rows_mut(a, b).copy_from(&more.slopes);
        rows
    }
}

/// Explanations under an experiment. `here` is the problem of the log; `there` one
/// whose robot stands as in the experiment (`here` unless on the other foot).
pub struct Trial<'a, 'm> {
    pub experiment: Experiment,
    pub here: &'a Problem<'m>,
    pub there: &'a Block<'m>,
    pub postures: Postures<'m>,
}

impl Trial<'_, '_> {
    /// S of each of `others` if `truth` holds, and what each new posture adds to
    /// all of them.
    pub fn separations(&self, truth: &Fit, others: &[&Fit]) -> (Vec<f64>, Vec<f64>) {
        let n = self.postures.posture_context.len() / self.layout().len();
        let mut by_posture = vec![0.0; n];
        let told = self.rows(truth);
        let masses = self.masses();
        let separation = |other: &&Fit| {
            let theirs = self.rows(other);
            let left = least(&(&told.value - &theirs.value), &theirs.slopes, &masses);
            let old = left.len() - 2 * n;
            for (k, by) in by_posture.iter_mut().enumerate() {
                let own = left[old + 2 * k].powi(2) + left[old + 2 * k + 1].powi(2);
                *by += own.min(criteria::TOLD_BY_ONE);
            }
            left.norm_squared() + self.by_weight(truth, other)
        };
        let separations = others.iter().map(separation).collect();
        (separations, by_posture)
    }

    fn layout(&self) -> PostureContext {
        PostureContext::of(self.postures.model)
    }

    /// What the sum of raw cells tells: their noise on it is that of the CoP times
    /// weight over the cells' arm.
    fn by_weight(&self, truth: &Fit, other: &Fit) -> f64 {
        if self.experiment != Experiment::RawCells {
            return 0.0;
        }
        let context = &self.here.first().context;
        let carried = |fit: &Fit| -> f64 {
            let mut mass = 0.0;
            for (term, own) in with_places(&fit.terms, context) {
                let own = &fit.unknowns[own];
                let share = term.effect().map_or(0.0, |i| i.effect.load_share(own));
                mass += context.mass() * share / (1.0 - share);
            }
            mass
        };
        let arms = self.here.first().data.cells.iter().map(|c| c[0].abs());
        let arm = arms.fold(0.0, f64::max).max(0.01);
        let noise = self.here.first().data.noise_floor * context.mass() / arm;
        let postures = self.here.first().data.len() as f64;
        postures * ((carried(truth) - carried(other)) / noise).powi(2)
    }

    /// Old rows as the logs have them, then new ones.
    fn rows(&self, fit: &Fit) -> WhitenedReadings {
        let blocks = self.here.blocks.iter().zip(&fit.blocks);
        let values = blocks.flat_map(|(block, own)| {
            let pairs = own.predicted.iter().zip(&block.weight);
            pairs.map(|(value, weight)| value * weight)
        });
        let old = WhitenedReadings {
            value: DVector::from_vec(values.collect()),
            slopes: self.here.of_readings(&fit.slopes()),
        };
        old.below(self.new_rows(fit))
    }

    fn new_rows(&self, fit: &Fit) -> WhitenedReadings {
        let (here, there) = (&self.here.first().context, &self.there.context);
        let carried = carried(Some(self.experiment), here, there, &fit.terms);
        let mut unknowns = carried.unknowns(&fit.unknowns);
        let CarriedExplanation { mut terms, columns } = carried;
        if self.experiment == Experiment::KnownWeight {
            self.carry(&mut terms, &mut unknowns);
        }
        // Their order is their own: programs sort by stage, not by place in the list.
        let mut posture_context = self.postures.posture_context.clone();
        self.rest(&terms, &unknowns, &mut posture_context);
        let out = self
            .there
            .evaluate(&terms, &unknowns, &self.postures.q, &posture_context);
        let width = unknowns.len() + 1;
        let rows = out.len() / width;
        let weight = 1.0 / self.here.first().data.noise_floor;
        let mut slopes = DMatrix::zeros(rows, fit.unknowns.len());
        for row in 0..rows {
            for (own, (k, sign)) in columns.iter().enumerate() {
                slopes[(row, *k)] = sign * out[row * width + 1 + own] * weight;
            }
        }
        WhitenedReadings {
            value: DVector::from_fn(rows, |row, _| out[row * width] * weight),
            slopes,
        }
    }

    fn carry(&self, terms: &mut Vec<Term>, unknowns: &mut Vec<f64>) {
        let context = &self.there.context;
        let (mass, arm) = (
            criteria::CARRIED_SHARE * context.mass(),
            0.3 * context.height(),
        );
        if let Some((weight, own)) = known_weight(context, mass, arm) {
            terms.push(Term::Effect(weight));
            unknowns.extend(own);
        }
    }

    /// Sides of dead bands: gravity's, or in an approach from the other side, the other.
    fn rest(&self, terms: &[Term], unknowns: &[f64], posture_context: &mut [f64]) {
        let joints = self.there.slack_joints(terms);
        if joints.is_empty() {
            return;
        }
        let layout = self.layout();
        let dof = self.postures.model.dof();
        let sense = match self.experiment {
            Experiment::BothSides => -1.0,
            _ => 1.0,
        };
        let moments =
            self.there
                .evaluate_moments(terms, unknowns, &self.postures.q, posture_context);
        for k in 0..posture_context.len() / layout.len() {
            for (joint, _) in &joints {
                let side = if moments[k * 3 * dof + joint] < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                posture_context[k * layout.len() + layout.side(*joint)] = sense * side;
            }
        }
    }

    /// Whitened directions of mass errors, old rows and new ones.
    fn masses(&self) -> DMatrix<f64> {
        let here = self.here;
        let n = self.postures.posture_context.len() / self.layout().len();
        let first = here.of_readings(here.masses(&[]).columns());
        let old = first.nrows();
        let mut k = DMatrix::zeros(old + 2 * n, first.ncols());
        k.rows_mut(0, old).copy_from(&first);
        // Base parameters of another support are others: shifted by lengths.
        let params = self.postures.model.base.params.len();
        let flat = Evaluator::new(self.postures.model, Function::RegressorCop);
        let rows = DMatrix::from_row_slice(2 * n, params, &flat.run(&self.postures.q, n));
        let map = match self.experiment {
            Experiment::OtherFoot => {
                let shift = self.postures.model.params_from(here.first().context.robot);
                &shift.matrix * &here.prior(&[]).factor
            }
            _ => here.prior(&[]).factor.clone(),
        };
        let second = rows * map / here.first().data.noise_floor;
        k.rows_mut(old, 2 * n).copy_from(&second);
        k
    }
}

/// What is left of `difference` once slopes and masses have taken their part.
fn least(difference: &DVector<f64>, slopes: &DMatrix<f64>, masses: &DMatrix<f64>) -> DVector<f64> {
    let (p, m) = (slopes.ncols(), masses.ncols());
    let mut all = DMatrix::zeros(difference.len(), p + m);
    all.columns_mut(0, p).copy_from(slopes);
    all.columns_mut(p, m).copy_from(masses);
    let mut normal = all.tr_mul(&all);
    for k in 0..p + m {
        normal[(k, k)] += if k < p {
            1e-9 * normal[(k, k)] + 1e-12
        } else {
            1.0
        };
    }
    match normal.cholesky() {
        Some(factor) => difference - &all * factor.solve(&all.tr_mul(difference)),
        None => difference.clone(),
    }
}
