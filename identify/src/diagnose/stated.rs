//! Explanations as the model file that holds them predicts the logs.
//!
//! ```text
//! y(e, r) ≈ y(e, r_b) + ∂y/∂r (r − r_b)        r_b: where the fit before ended; CAD's at first
//! min Σ_k χ²_k(e, r)                           sides = sign τ(e, r), or what the log knows of a
//!                                              joint near no moment
//! ```
//!
//! The search takes ∂y/∂r from the robot without effects: the product of an effect and a mass
//! error is left out. Where both are large (a gain of 2, free masses) the file that holds both
//! would not predict what was stated. Here ∂y/∂r and r_b are taken where the explanation ended,
//! and it is fitted again (Gauss–Newton), until the file predicts what is stated.
//!
//! On which side of its dead band a loose joint rests, a log shows; a model file works it out from
//! its own masses. Where these are loosely known, the sides that fit a log and the sides that the
//! fitted masses ask for can exchange each other without end. So a step counts only where χ² of
//! the file falls, and what the file of the best leaves is what is stated.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use nalgebra::DMatrix;
use sesc_model::effects::{self, PostureContext};
use sesc_model::tape::{Tape, Values};

use super::criteria::stated::{AGREES, FLIPPED, GAIN, MOST, SHORTEST};
use super::hypothesis::{CarriedExplanation, Term, effects_of};
use super::problem::{ALL, Block, Fit, OnBlock, Problem, backlash_sides};
use crate::evaluate::FASTEST;
use crate::observations::postures::rms;

/// Rounds, at most.
const ROUNDS: usize = 12;

/// `problem` and `fit` about the masses at which the fit ends, as its file predicts them; `None`
/// where the linear problem says the same.
pub(super) fn settle<'m>(problem: &Problem<'m>, fit: &Fit) -> Option<(Problem<'m>, Fit)> {
    if effects_of(&fit.terms).is_empty() {
        return None;
    }
    let file = FileModel::new(problem, &fit.terms);
    // On which side a loose joint rests, the file decides by its own masses.
    let loose = fit.terms.iter().any(|term| term.dead_band().is_some());
    if !loose && file.agrees(problem, fit) {
        return None;
    }
    let mut best = file.filled(problem, fit.clone(), problem.params_of(fit));
    if loose && !problem.is_wider() {
        // A prior that holds no masses lets those of light links be anything.
        let usual = file.filled(problem, fit.clone(), problem.usual_params(fit));
        if usual.misfit < best.misfit {
            best = usual;
        }
    }
    let (mut about, mut part) = (best.masses.clone(), 1.0);
    for _ in 0..ROUNDS {
        let own = file.linearised(problem, &best.fit, &about);
        let next = own.fit(&fit.terms, Some(&best.fit), ALL);
        let settled = !loose && file.agrees(&own, &next);
        let masses = own.params_of(&next);
        let next = file.filled(&own, next, masses.clone());
        if !loose || next.misfit < (1.0 - GAIN) * best.misfit {
            best = next;
        } else {
            part *= 0.5;
        }
        if settled || part < SHORTEST {
            break;
        }
        for (about, end) in about.iter_mut().zip(&masses) {
            *about += part * (end - *about);
        }
    }
    let own = file.linearised(problem, &best.fit, &best.masses);
    let stated = file.stated(&own, best);
    Some((own, stated))
}

/// A fit with the masses that its file would hold.
struct Filled {
    fit: Fit,
    /// Base parameters of the first block, m.
    masses: Vec<f64>,
    /// χ² that the file leaves.
    misfit: f64,
}

/// A model file with some effects and any masses, on the logs of a problem.
pub(super) struct FileModel {
    blocks: Vec<OfBlock>,
}

struct OfBlock {
    carried: CarriedExplanation,
    /// Reading, and how far into its dead band each joint is.
    resting: Tape,
    /// Reading with its derivatives by the base parameters.
    by_masses: OnceLock<Tape>,
}

impl FileModel {
    pub fn new(problem: &Problem, terms: &[Term]) -> FileModel {
        let blocks = problem.blocks.iter().map(|block| {
            let carried = problem.carried(block, terms);
            let effects = effects_of(&carried.terms);
            OfBlock {
                resting: Tape::of_many(&effects::resting_reading(&block.context, &effects)),
                by_masses: OnceLock::new(),
                carried,
            }
        });
        FileModel {
            blocks: blocks.collect(),
        }
    }

    /// Block by block what the file predicts: per posture x, y (m), then how far into its dead
    /// band each joint is.
    fn run(&self, problem: &Problem, unknowns: &[f64], masses: &[f64]) -> Vec<Vec<f64>> {
        let blocks = problem.blocks.iter().zip(&self.blocks);
        blocks
            .map(|(block, own)| {
                let masses = block.params_from_first(masses);
                let unknowns = own.carried.unknowns(unknowns);
                let context = &block.data.posture_context;
                let mut out = own.run(&own.resting, block, &unknowns, context, &masses);
                let width = own.resting.outputs();
                for (row, by) in block.motion_of(&masses).into_iter().enumerate() {
                    out[row / 2 * width + row % 2] += by;
                }
                out
            })
            .collect()
    }

    /// Readings of the first block, m.
    pub fn readings(&self, problem: &Problem, unknowns: &[f64], masses: &[f64]) -> Vec<f64> {
        let out = self.run(problem, unknowns, masses).swap_remove(0);
        let postures = out.chunks_exact(self.blocks[0].resting.outputs());
        postures
            .flat_map(|posture| [posture[0], posture[1]])
            .collect()
    }

    /// Whether the masses at which a fit ends predict what its linear problem states.
    fn agrees(&self, problem: &Problem, fit: &Fit) -> bool {
        let predicted = self.run(problem, &fit.unknowns, &problem.params_of(fit));
        let shift = problem.mass_shift_of(fit, ALL);
        let (mut apart, mut all) = (Vec::new(), Vec::new());
        let blocks = problem.blocks.iter().zip(&fit.blocks).zip(&self.blocks);
        for (((block, on), own), (predicted, range)) in
            blocks.zip(predicted.iter().zip(problem.readings()))
        {
            let width = own.resting.outputs();
            for (row, at) in range.enumerate() {
                let file = predicted[row / 2 * width + row % 2];
                let left = on.residual[row] - shift[at];
                all.push(left);
                apart.push((block.data.reading[row] - file) * block.weight[row] - left);
            }
        }
        rms(apart.into_iter()) <= AGREES * rms(all.into_iter())
    }

    /// The problem about masses `r` of the first block (m), its slopes under `fit`.
    fn linearised<'m>(&self, problem: &Problem<'m>, fit: &Fit, r: &[f64]) -> Problem<'m> {
        let contexts = problem.posture_contexts(Some(fit));
        let blocks = problem.blocks.iter().zip(&self.blocks).zip(&contexts);
        let blocks = blocks.map(|((block, own), context)| {
            let masses = block.params_from_first(r);
            let tape = own.by_masses.get_or_init(|| {
                let effects = effects_of(&own.carried.terms);
                Tape::of_many(&effects::reading_by_masses(&block.context, &effects))
            });
            let unknowns = own.carried.unknowns(&fit.unknowns);
            let out = own.run(tape, block, &unknowns, context, &masses);
            let width = 1 + masses.len();
            let still = DMatrix::from_fn(2 * block.data.len(), masses.len(), |row, k| {
                out[row * width + 1 + k]
            });
            block.about(masses, block.with_motion(still))
        });
        problem.about(blocks.collect())
    }

    fn filled(&self, problem: &Problem, fit: Fit, masses: Vec<f64>) -> Filled {
        let predicted = self.run(problem, &fit.unknowns, &masses);
        let blocks = problem.blocks.iter().zip(&fit.blocks).zip(&self.blocks);
        let misfits = blocks
            .zip(&predicted)
            .map(|(((block, on), own), predicted)| {
                let width = own.resting.outputs();
                let square = |row: usize| {
                    let file = predicted[row / 2 * width + row % 2];
                    ((block.data.reading[row] - file) * block.weight[row]).powi(2)
                };
                let of = |k: usize| match on.flipped.contains(&k) {
                    true => FLIPPED,
                    // What is not a number counts as far off.
                    false => MOST.min(square(2 * k) + square(2 * k + 1)),
                };
                (0..block.data.len()).map(of).sum::<f64>()
            });
        Filled {
            misfit: misfits.sum(),
            fit,
            masses,
        }
    }

    /// A fit, about its masses in `problem`, as its file predicts the logs.
    fn stated(&self, problem: &Problem, of: Filled) -> Fit {
        let Filled { fit, masses, .. } = of;
        let predicted = self.run(problem, &fit.unknowns, &masses);
        let loose = fit.terms.iter().any(|term| term.dead_band().is_some());
        let sides = backlash_sides::settle(problem, &fit.terms, &fit.unknowns, loose);
        let mut contexts = Vec::new();
        let blocks = || {
            problem
                .blocks
                .iter()
                .zip(&self.blocks)
                .zip(&predicted)
                .zip(&sides)
        };
        for (((block, own), predicted), sides) in blocks() {
            let layout = PostureContext::of(block.context.robot);
            let width = own.resting.outputs();
            let mut context = sides.posture_context.clone();
            for k in (0..block.data.len()).filter(|k| !sides.flipped.contains(k)) {
                for joint in 0..width - 2 {
                    context[k * layout.len() + layout.side(joint)] =
                        predicted[k * width + 2 + joint];
                }
            }
            contexts.push(Cow::Owned(context));
        }
        let weighting = problem.weighting(&fit.terms, fit.outliers.as_ref(), ALL);
        let mut state = problem.state(&fit.terms, fit.unknowns.clone(), &contexts, &weighting);
        // Springs that give way while loose joints slide end a little elsewhere than springs
        // beside joints at rest: the file's own readings count.
        let on_blocks = state.blocks.iter_mut().zip(&contexts);
        for ((((block, own), predicted), sides), (on, context)) in blocks().zip(on_blocks) {
            let width = own.resting.outputs();
            let mut readings = on.predicted.to_vec();
            for row in (0..readings.len()).filter(|row| !sides.flipped.contains(&(row / 2))) {
                let file = predicted[row / 2 * width + row % 2];
                readings[row] = block.of_cad(row, file);
            }
            *on = OnBlock {
                residual: Arc::new(block.residual(&readings)),
                predicted: Arc::new(readings),
                sides: Some(block.sides_of(context)),
                flipped: sides.flipped.clone(),
                ..on.clone()
            };
        }
        let covariance = problem.covariance(&state, &problem.scales(&fit.terms), &weighting);
        Fit {
            covariance,
            unknowns: state.unknowns,
            blocks: state.blocks,
            at_bound: state.at_bound,
            masses: Some(masses),
            ..fit
        }
    }
}

impl OfBlock {
    fn run(
        &self,
        tape: &Tape,
        block: &Block,
        unknowns: &[f64],
        context: &[f64],
        masses: &[f64],
    ) -> Vec<f64> {
        let arguments = [
            Values::PerPosture(&block.data.q),
            Values::Shared(unknowns),
            Values::PerPosture(context),
            Values::Shared(masses),
        ];
        let n = block.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }
}
