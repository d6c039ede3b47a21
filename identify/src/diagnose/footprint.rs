//! What an effect does to the readings of a robot that stands or moves, what masses take of it,
//! which other effect imitates the rest, and in which postures the two differ.
//!
//! ```text
//! Z = W ∂y/∂e diag(ordinary sizes)          S: what is no mass error (see `nuisance`)
//! taken(Z by masses) = 1 − tr ZᵀSZ / tr ZᵀZ
//! taken(Z by X)      = tr CᵀB / tr ZᵀSZ           C = XᵀSZ, B = (XᵀSX)⁻¹ C
//! ```
//!
//! Everything is to first order, as in the dictionary of a diagnosis; effects that have no
//! slope at none (a dead band, crossed wires) count with what they do at an ordinary size.

use nalgebra::DMatrix;
use sesc_model::effects::{Catalog, Value};
use sesc_model::{Function, Model};

use super::criteria::{self, FIVE_DEVIATIONS};
use super::dictionary::Dictionary;
use super::hypothesis::{Term, effect_terms};
use super::motion;
use super::problem::Problem;
use crate::Error;
use crate::evaluate::Evaluator;
use crate::fit::prior::{Prior, PriorChoice};
use crate::logs::{LogSource, Options};
use crate::observations::motion_use::MotionModel;
use crate::observations::postures::{Postures, Taking, rms};

/// Share of postures that count as the telling ones.
const TELLING: f64 = 0.1;

/// Every effect on one robot in the same postures, to be asked one by one.
pub struct Footprints<'m> {
    problem: Problem<'m>,
    dictionary: Dictionary,
    without: Vec<f64>,
}

/// What one effect does at one joint, link or cell.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Footprint {
    /// `joint_offset:r_knee`
    pub label: String,
    /// `an offset of r_knee`
    pub phrase: String,
    /// Its parameters at an ordinary size, with which everything here is stated.
    pub size: Vec<Value>,
    /// RMS distance by which it moves the CoP, m.
    pub moves_m: f64,
    /// Share of its mean square that masses within the prior can take.
    pub taken_by_masses: f64,
    /// Share of its mean square that masses within the usual tolerances of CAD can take.
    pub taken_by_free_masses: f64,
    /// Other effects by the share of the rest that each takes, the largest first.
    pub imitators: Vec<Imitator>,
}

/// An effect that does much the same as another one.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Imitator {
    /// `ground_slope`
    pub label: String,
    /// `a slope of the ground`
    pub phrase: String,
    /// Share that it takes of what masses leave of the other's mean square, 0 to 1.
    pub share: f64,
}

/// How an effect and its best imitator differ.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Telling {
    /// CoP (m) of each posture without any effect.
    pub without: Vec<[f64; 2]>,
    /// The same with the effect.
    pub with: Vec<[f64; 2]>,
    /// What imitator and masses, fitted to the effect, say instead.
    pub imitated: Vec<[f64; 2]>,
    /// RMS distance of the last two, m.
    pub left_m: f64,
    /// How many postures like these tell the two apart ([`FIVE_DEVIATIONS`]).
    pub postures: f64,
    /// Share of what is left that stands in the tenth of the postures that has most of it.
    pub share_of_tenth: f64,
    /// How that tenth differs from all postures, the clearest difference first.
    pub features: Vec<Feature>,
}

/// A quantity of a posture, among the telling ones and among all.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Feature {
    /// Which quantity.
    pub what: Quantity,
    /// Mean over the telling postures, rad or m.
    pub among: f64,
    /// Mean over all postures.
    pub all: f64,
    /// Standard deviation over all postures.
    pub spread: f64,
}

/// A quantity of a posture.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// Height of the CoM, m.
    ComHeight,
    /// Distance of the CoP from the middle of all CoPs along this axis, m.
    CopOut(usize),
    /// The CoP along this axis, m.
    Cop(usize),
    /// The position of a joint, rad or m.
    Joint(usize),
    /// The speed of a joint in a log of a motion, rad/s or m/s.
    JointSpeed(usize),
}

impl<'m> Footprints<'m> {
    /// All standard effects on `model` in postures `q` (joint by joint, rad or m), whose CoPs are
    /// read with this noise (m, one axis) by a foot with these cells (m, support frame).
    ///
    /// # Errors
    /// A prior that is none.
    pub fn new(
        model: &'m Model,
        q: &[f64],
        cells: &[[f64; 2]],
        noise_m: f64,
        prior: &PriorChoice,
    ) -> Result<Footprints<'m>, Error> {
        let n = q.len() / model.dof();
        let without = Evaluator::new(model, Function::Cop).run(q, n);
        let mut data = Postures::given(model.dof(), q, &without, noise_m, 0.0);
        data.cells = cells.to_vec();
        let prior = prior.of(model)?;
        Footprints::of_readings(model, data, &prior, without)
    }

    /// All standard effects on `model` in a log of a motion, whose CoPs are read with this noise
    /// (m, one axis).
    ///
    /// # Errors
    /// A log that cannot be read, or does not know its accelerations; a prior that is none.
    pub fn moving(
        model: &'m Model,
        log: &LogSource,
        noise_m: f64,
        prior: &PriorChoice,
    ) -> Result<Footprints<'m>, Error> {
        let taking = Taking {
            options: Options {
                support: Some(model.support().to_string()),
                ..Options::default()
            },
            noise: Some(noise_m),
            floor: 0.0,
        };
        let mut data = Postures::read(log, model, &taking, &mut ())?;
        let prior = prior.of(model)?;
        motion::account(&mut data, model, &prior, MotionModel::Auto);
        if data.moved.is_none() {
            let message = "its readings are not those of a motion that is known";
            return Err(Error::log(log.name(), None, message));
        }
        let none = data.reading.clone();
        let mut all = Footprints::of_readings(model, data, &prior, none)?;
        let (q, context) = (&all.problem.data.q, &all.problem.data.posture_context);
        all.without = all.problem.evaluate(&[], &[], q, context);
        Ok(all)
    }

    fn of_readings(
        model: &'m Model,
        data: Postures,
        prior: &Prior,
        without: Vec<f64>,
    ) -> Result<Footprints<'m>, Error> {
        let problem = Problem::new(model, data, prior, &Catalog::standard())?;
        let dictionary = Dictionary::new(&problem, &problem.data.q);
        Ok(Footprints {
            problem,
            dictionary,
            without,
        })
    }

    /// One effect at each of its targets, by how far it moves the CoP, farthest first; empty
    /// where standing postures do not show it.
    pub fn of(&self, effect: &str) -> Vec<Footprint> {
        let mut found: Vec<Footprint> = self.terms(effect).map(|term| self.one(&term)).collect();
        found.sort_by(|a, b| b.moves_m.total_cmp(&a.moves_m));
        found
    }

    /// How an effect of [`Footprints::of`] differs from its imitator called `by`; none where
    /// there is no such effect.
    pub fn telling(&self, of: &Footprint, by: &str) -> Option<Telling> {
        let context = &self.problem.context;
        let name = of.label.split(':').next().unwrap_or(&of.label);
        // Ways of one effect may share a label.
        let term = self
            .terms(name)
            .find(|term| term.label(context) == of.label && term.phrase(context) == of.phrase)?;
        let own = self.columns(&term);
        let (x, sx) = self
            .dictionary
            .scaled(&self.problem, |term| term.label(context) == by)?;
        let masses = &self.problem.nuisance;
        let (_, by_x) = taken(&x, &sx, &masses.project_out(&own));
        let rest = &own - &x * by_x;
        let left = masses.project_out(&rest);
        let n = self.problem.data.len();
        let chi2 = rest.component_mul(&left).sum();
        let energy: Vec<f64> = (0..n)
            .map(|k| left.rows(2 * k, 2).iter().map(|e| e * e).sum())
            .collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|a, b| energy[*b].total_cmp(&energy[*a]));
        let tenth = &order[..((TELLING * n as f64).round() as usize).clamp(1, n)];
        let of_tenth: f64 = tenth.iter().map(|k| energy[*k]).sum();
        let points = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
            (0..n).map(|k| [of(2 * k), of(2 * k + 1)]).collect()
        };
        let weight = &self.problem.weight;
        let sum = |columns: &DMatrix<f64>, row: usize| columns.row(row).sum() / weight[row];
        Some(Telling {
            without: points(&|row| self.without[row]),
            with: points(&|row| self.without[row] + sum(&own, row)),
            imitated: points(&|row| self.without[row] + sum(&own, row) - sum(&left, row)),
            left_m: rms_of_rows(&left, weight),
            postures: FIVE_DEVIATIONS * n as f64 / chi2.max(1e-300),
            share_of_tenth: of_tenth / energy.iter().sum::<f64>().max(1e-300),
            features: self.features(tenth),
        })
    }

    fn terms(&self, effect: &str) -> impl Iterator<Item = Term> {
        let terms = effect_terms(&self.problem.context).into_iter();
        terms.filter(move |term| term.name() == effect)
    }

    /// What `term` does to whitened readings: a column for each of its parameters at its
    /// ordinary size, or one for all.
    fn columns(&self, term: &Term) -> DMatrix<f64> {
        if let Some((own, _)) = self.dictionary.scaled(&self.problem, |known| known == term) {
            return own;
        }
        let problem = &self.problem;
        let data = &problem.data;
        let own = std::slice::from_ref(term);
        let out = problem.evaluate(own, &[], &data.q, &data.posture_context);
        DMatrix::from_fn(out.len(), 1, |row, _| {
            (out[row] - self.without[row]) * problem.weight[row]
        })
    }

    fn one(&self, term: &Term) -> Footprint {
        let problem = &self.problem;
        let context = &problem.context;
        let own = self.columns(term);
        let left = problem.nuisance.project_out(&own);
        let (whole, rest) = (own.dot(&own), own.dot(&left));
        let taken_of_whole = |rest: f64| (1.0 - rest / whole.max(1e-300)).clamp(0.0, 1.0);
        let candidates = self.dictionary.candidates.iter();
        let mut imitators: Vec<Imitator> = candidates
            .filter(|other| other.term != *term)
            .filter_map(|other| {
                let (x, sx) = (self.dictionary).scaled(problem, |known| *known == other.term)?;
                let (share, _) = taken(&x, &sx, &left);
                Some(Imitator {
                    label: other.term.label(context),
                    phrase: other.term.phrase(context),
                    share: (share / rest.max(1e-300)).clamp(0.0, 1.0),
                })
            })
            .collect();
        imitators.sort_by(|a, b| b.share.total_cmp(&a.share));
        Footprint {
            label: term.label(context),
            phrase: term.phrase(context),
            size: term.values(context, &self.dictionary.ordinary(problem, term)),
            moves_m: rms_of_rows(&own, &problem.weight),
            taken_by_masses: taken_of_whole(rest),
            taken_by_free_masses: taken_of_whole(own.dot(&problem.wide.project_out(&own))),
            imitators,
        }
    }

    /// What sets postures of the log apart from all, the clearest first.
    fn features(&self, chosen: &[usize]) -> Vec<Feature> {
        let (data, dof) = (&self.problem.data, self.problem.model.dof());
        let n = data.len();
        let com = Evaluator::new(self.problem.model, Function::Com).run(&data.q, n);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let cop =
            |axis: usize| -> Vec<f64> { (0..n).map(|k| self.without[2 * k + axis]).collect() };
        let out = |axis: usize| -> Vec<f64> {
            let (all, middle) = (cop(axis), mean(&cop(axis)));
            all.iter().map(|x| (x - middle).abs()).collect()
        };
        let joint = |j: usize| -> Vec<f64> { (0..n).map(|k| data.q[k * dof + j]).collect() };
        let quantities = [Quantity::ComHeight].into_iter();
        let quantities = quantities
            .chain((0..2).flat_map(|axis| [Quantity::Cop(axis), Quantity::CopOut(axis)]))
            .chain((0..dof).map(Quantity::Joint));
        let rates = data.motion.as_ref().map_or(&[][..], |motion| &motion.rates);
        let moving = if rates.is_empty() { 0 } else { dof };
        let quantities = quantities.chain((0..moving).map(Quantity::JointSpeed));
        let mut features: Vec<(f64, Feature)> = quantities
            .map(|what| {
                let values = match what {
                    Quantity::ComHeight => (0..n).map(|k| com[3 * k + 2]).collect(),
                    Quantity::Cop(axis) => cop(axis),
                    Quantity::CopOut(axis) => out(axis),
                    Quantity::Joint(j) => joint(j),
                    Quantity::JointSpeed(j) => (0..n).map(|k| rates[k * dof + j].abs()).collect(),
                };
                let all = mean(&values);
                let spread = rms(values.iter().map(|x| x - all));
                let among: Vec<f64> = chosen.iter().map(|k| values[*k]).collect();
                let among = mean(&among);
                let clear = (among - all).abs() / spread.max(1e-300);
                (
                    clear,
                    Feature {
                        what,
                        among,
                        all,
                        spread,
                    },
                )
            })
            .collect();
        features.sort_by(|a, b| b.0.total_cmp(&a.0));
        features.into_iter().map(|(_, feature)| feature).collect()
    }
}

/// How much of `tr ZᵀSZ` columns `x` take, and what of each they take for that; `sx` and `left`
/// are S x and S Z.
fn taken(x: &DMatrix<f64>, sx: &DMatrix<f64>, left: &DMatrix<f64>) -> (f64, DMatrix<f64>) {
    let mut own = x.tr_mul(sx);
    for k in 0..own.nrows() {
        own[(k, k)] += criteria::COPIED * own[(k, k)] + 1e-12;
    }
    let cross = x.tr_mul(left);
    match own.cholesky() {
        Some(factor) => {
            let by = factor.solve(&cross);
            (cross.dot(&by), by)
        }
        None => (0.0, DMatrix::zeros(cross.nrows(), cross.ncols())),
    }
}

/// RMS length (m) of the displacements that whitened columns are together.
fn rms_of_rows(columns: &DMatrix<f64>, weight: &[f64]) -> f64 {
    let squares = columns.row_iter().zip(weight);
    let squares = squares.map(|(row, w)| row.norm_squared() / (w * w));
    (2.0 * squares.sum::<f64>() / columns.nrows() as f64).sqrt()
}
