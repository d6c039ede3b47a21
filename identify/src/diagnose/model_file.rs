//! The corrected model as a file: parameters and effects, and what it predicts of the logs.
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
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use nalgebra::DMatrix;
use sesc_model::effects::{self, Catalog, Stage};
use sesc_model::tape::Tape;
use sesc_model::{EffectRecord, ModelFile, Quantity};

use super::criteria::{
    AGREES, FILE_AGREES, FLIPPED, GAIN, LARGEST_OUTLIER_SHARE, MOST, OTHER_SIDE, SHORTEST,
};
use super::findings::ModelOnLog;
use super::hypothesis::{CarriedExplanation, Term, effects_of};
use super::problem::{ALL, Fit, OnBlock, Problem, backlash_sides};
use super::{held_out, words};
use crate::Error;
use crate::lsq::solve::information;
use crate::observations::postures::rms;

/// Rounds, at most.
const ROUNDS: usize = 12;

/// Parameters as the masses' prior and the data have them, and every effect of
/// the explanation `best` that a model can hold; the logs are added by the caller.
pub(super) fn model_file(problem: &Problem, best: &Fit) -> ModelFile {
    let model = problem.first().context.robot;
    let identified = best.frees_masses();
    let prior = problem.prior(&best.terms);
    let values = problem.params_of(best);
    let weighting = problem.weighting(&best.terms, best.outliers.as_ref(), ALL);
    let spread = &prior.factor * weighting.masses.covariance() * prior.factor.transpose();
    let std: Vec<f64> = (0..values.len())
        .map(|k| spread[(k, k)].max(0.0).sqrt())
        .collect();
    let mut rows = problem.whitened_rows();
    weighting.weigh(&mut rows);
    let source = if identified { "data" } else { "prior" };
    let mut file = ModelFile::from_values(model, &values, Some(&std), source);
    file.inform(information(&rows, &prior.factor, prior.beyond));
    file.noise_floor = Some(problem.first().data.noise_floor);
    let quantities = words::values(problem, best);
    for (term, values) in best.terms.iter().zip(&quantities) {
        let Some(instance) = term.effect() else {
            continue;
        };
        if instance.effect.stage() == Stage::Cells {
            file.cells = problem.first().data.cells.clone();
        }
        let of = |v: &words::NamedValue| {
            let quantity = Quantity {
                value: v.value,
                std: v.std.is_finite().then_some(v.std),
            };
            (v.name.to_string(), quantity)
        };
        file.effects.push(EffectRecord {
            effect: term.name().to_string(),
            target: problem.first().context.name_of(&instance.target),
            parameters: values.iter().map(of).collect::<BTreeMap<_, _>>(),
        });
    }
    file
}

/// Compare what is stated of an explanation with what its `file` predicts of the log, and
/// check that no command refuses the file.
///
/// # Errors
/// When one does.
pub(super) fn on_log(problem: &Problem, best: &Fit, file: &ModelFile) -> Result<ModelOnLog, Error> {
    // Effects of a caller's own are no part of files.
    let standard = Catalog::standard();
    let is_known = |record: &EffectRecord| standard.named(&record.effect).is_some();
    if file.effects.iter().all(is_known) {
        problem.first().model.clone().with_file(file.clone())?;
    }
    let (first, mut apart) = (problem.first(), held_out::apart(problem, best));
    let stated = held_out::errors_of(problem, best, None);
    let predicted = FileModel::new(problem, &best.terms);
    let predicted = predicted.run(problem, &best.unknowns, &problem.params_of(best));
    let pairs = first.data.reading.iter().zip(&predicted[0].readings);
    let predicted: Vec<f64> = pairs.map(|(y, p)| y - p).collect();
    // On which side of its dead band a joint rests near no moment, the log knows and a
    // posture alone does not.
    let before = apart.iter().filter(|apart| **apart).count();
    for k in (0..apart.len()).filter(|_| best.is_loose()) {
        let off = |row: usize| (predicted[row] - stated[row]).abs() * first.weight[row];
        apart[k] |= off(2 * k).max(off(2 * k + 1)) > OTHER_SIDE;
    }
    let left_out = apart.iter().filter(|apart| **apart).count() - before;
    let error = |errors: &[f64]| {
        let rows = (0..errors.len()).filter(|row| !apart[row / 2]);
        rms(rows.map(|row| errors[row]))
    };
    let (stated_rmse, predicted_rmse) = (error(&stated), error(&predicted));
    let slack = FILE_AGREES * stated_rmse.max(first.data.noise_floor);
    let few = (left_out as f64) <= LARGEST_OUTLIER_SHARE * apart.len() as f64;
    Ok(ModelOnLog {
        stated_rmse,
        predicted_rmse,
        left_out,
        agrees: few && (stated_rmse - predicted_rmse).abs() <= slack,
    })
}

/// `problem` and `fit` about the masses at which the fit ends, as its file predicts them; both as
/// they are where the linear problem says the same.
pub(super) fn settle<'p, 'm>(problem: &'p Problem<'m>, fit: &Fit) -> (Cow<'p, Problem<'m>>, Fit) {
    let same = || (Cow::Borrowed(problem), fit.clone());
    if effects_of(&fit.terms).is_empty() {
        return same();
    }
    let file = FileModel::new(problem, &fit.terms);
    // On which side a loose joint rests, the file decides by its own masses.
    let loose = fit.is_loose();
    if !loose && file.agrees(problem, fit) {
        return same();
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
    (Cow::Owned(own), stated)
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
struct FileModel {
    blocks: Vec<OfBlock>,
}

struct OfBlock {
    carried: CarriedExplanation,
    /// Reading, and how far into its dead band each joint is.
    resting: Tape,
    /// Reading with its derivatives by the base parameters.
    by_masses: OnceLock<Tape>,
}

/// What a file predicts of a block, posture by posture.
struct Predicted {
    /// x, y, m.
    readings: Vec<f64>,
    /// How far into its dead band each joint is.
    depths: Vec<f64>,
}

impl FileModel {
    fn new(problem: &Problem, terms: &[Term]) -> FileModel {
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

    /// What the file predicts of each block where base parameters of the first are `masses`, m.
    fn run(&self, problem: &Problem, unknowns: &[f64], masses: &[f64]) -> Vec<Predicted> {
        let blocks = problem.blocks.iter().zip(&self.blocks);
        let predicted = blocks.map(|(block, own)| {
            let masses = block.params_from_first(masses);
            let (unknowns, data) = (own.carried.unknowns(unknowns), &block.data);
            let context = &data.posture_context;
            let out = block.run(&own.resting, &data.q, &unknowns, context, Some(&masses));
            let postures = out.chunks_exact(own.resting.outputs());
            let (readings, depths): (Vec<_>, Vec<_>) = postures.map(|own| own.split_at(2)).unzip();
            let mut readings = readings.concat();
            let motion = block.motion_of(&masses);
            readings.iter_mut().zip(motion).for_each(|(y, by)| *y += by);
            Predicted {
                readings,
                depths: depths.concat(),
            }
        });
        predicted.collect()
    }

    /// Whether the masses at which a fit ends predict what its linear problem states.
    fn agrees(&self, problem: &Problem, fit: &Fit) -> bool {
        let predicted = self.run(problem, &fit.unknowns, &problem.params_of(fit));
        let shift = problem.mass_shift_of(fit, ALL);
        let (mut apart, mut all) = (Vec::new(), Vec::new());
        let blocks = problem.blocks.iter().zip(&fit.blocks);
        for (((block, on), own), range) in blocks.zip(&predicted).zip(problem.readings()) {
            let left = &*on.residual - shift.rows_range(range);
            apart.extend((block.residual(&own.readings) - &left).iter().copied());
            all.extend(left.iter().copied());
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
            let out = block.run(tape, &block.data.q, &unknowns, context, Some(&masses));
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
        let blocks = problem.blocks.iter().zip(&fit.blocks).zip(&predicted);
        let misfits = blocks.map(|((block, on), own)| {
            let left = block.residual(&own.readings);
            let postures = left.as_slice().chunks_exact(2).enumerate();
            let misfit = |(k, left): (usize, &[f64])| match on.flipped.contains(&k) {
                true => FLIPPED,
                // What is not a number counts as far off.
                false => MOST.min(left[0].powi(2) + left[1].powi(2)),
            };
            postures.map(misfit).sum::<f64>()
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
        let sides = backlash_sides::settle(problem, &fit.terms, &fit.unknowns, fit.is_loose());
        let blocks = || problem.blocks.iter().zip(&predicted).zip(&sides);
        let contexts = blocks().map(|((block, own), sides)| {
            let mut context = sides.posture_context.clone();
            let joints = own.depths.len() / block.data.len();
            let stays = |k: usize| sides.flipped.contains(&k);
            block.put_sides(&mut context, 0..joints, |k, joint, side| match stays(k) {
                true => side,
                false => own.depths[k * joints + joint],
            });
            Cow::Owned(context)
        });
        let contexts: Vec<Cow<[f64]>> = contexts.collect();
        let weighting = problem.weighting(&fit.terms, fit.outliers.as_ref(), ALL);
        let mut state = problem.state(&fit.terms, fit.unknowns.clone(), &contexts, &weighting);
        // Springs that give way while loose joints slide end a little elsewhere than springs
        // beside joints at rest: the file's own readings count.
        let on_blocks = state.there.iter_mut().zip(&contexts);
        for (((block, own), sides), (on, context)) in blocks().zip(on_blocks) {
            let mut readings = on.predicted.to_vec();
            for row in (0..readings.len()).filter(|row| !sides.flipped.contains(&(row / 2))) {
                readings[row] = block.of_cad(row, own.readings[row]);
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
            blocks: state.there,
            masses: Some(masses),
            ..fit
        }
    }
}
