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

use sesc_model::effects::{Catalog, Instance, PostureContext, Stage, Target};
use sesc_model::formula::Variable;
use sesc_model::{EffectRecord, Function, ModelFile, Quantity};

use super::criteria::{
    AGREES, COM_APART_M, FILE_AGREES, FLIPPED, GAIN, LARGEST_OUTLIER_SHARE, MOST, OTHER_SIDE,
    SHORTEST,
};
use super::findings::{Explained, ModelOnLog};
use super::hypothesis::{Term, effects_of};
use super::problem::{Fit, InFile, Problem, backlash_sides};
use super::{held_out, words};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::lsq::solve::information;
use crate::observations::postures::{range as span, rms};

/// Rounds, at most.
const ROUNDS: usize = 12;

/// Parameters as the masses' prior and the data have them, and every effect of
/// the explanation `best` that a model can hold; the logs are added by the caller.
pub(super) fn model_file(problem: &Problem, best: &Fit) -> ModelFile {
    let model = problem.context().robot;
    let identified = best.frees_masses();
    let prior = problem.prior(&best.terms);
    let values = problem.params_of(best);
    let weighting = problem.weighting(&best.terms, best.outliers.as_ref());
    let spread = &prior.factor * weighting.masses.covariance() * prior.factor.transpose();
    let std = spread.diagonal().map(|square| square.max(0.0).sqrt());
    let mut rows = problem.whitened_rows();
    weighting.weigh(&mut rows);
    let source = if identified { "data" } else { "prior" };
    let mut file = ModelFile::from_values(model, &values, Some(std.as_slice()), source);
    file.inform(information(&rows, &prior.factor, prior.beyond));
    file.noise_floor = Some(problem.data().noise_floor);
    file.motion = problem.data().motion_use.counted();
    put_effects(problem, best, &mut file);
    file
}

/// Why no command would take a file with an explanation whose joints give way, if none would: its
/// springs do not come to rest.
pub(super) fn unsettled_reason(problem: &Problem, fit: &Fit) -> Option<String> {
    let gives_way = |term: &Term| term.stage() == Some(Stage::Bends);
    if !fit.terms.iter().any(gives_way) {
        return None;
    }
    let model = problem.context().robot;
    let mut file = ModelFile::from_values(model, &problem.params_of(fit), None, "data");
    put_effects(problem, fit, &mut file);
    let refused = problem.first().model.clone().with_file(file).err()?;
    Some(refused.to_string().trim_start_matches(": ").to_string())
}

/// Every effect of an explanation that a model can hold.
fn put_effects(problem: &Problem, best: &Fit, file: &mut ModelFile) {
    for (term, values) in best.terms.iter().zip(words::values(problem, best)) {
        let Some(instance) = term.effect() else {
            continue;
        };
        if instance.effect.stage() == Stage::Cells {
            file.cells = problem.data().cells.clone();
        }
        let parameters = values.iter().map(|(name, own)| {
            let std = own.std.is_finite().then_some(own.std);
            let value = own.value;
            (name.to_string(), Quantity { value, std })
        });
        let target = problem.context().name_of(&instance.target);
        let mut record = EffectRecord::new(instance.effect, target, parameters.collect());
        record.range = ranges(problem, instance);
        file.effects.push(record);
    }
}

/// What the log had of the variables of a function, outside of which it says nothing of it.
fn ranges(problem: &Problem, instance: &Instance) -> BTreeMap<String, [f64; 2]> {
    let (data, dofs) = (problem.data(), &problem.context().robot.tree.dofs);
    let column = |values: &[f64], width: usize, k: usize| {
        let (least, most) = span(values.iter().skip(k).step_by(width).copied());
        (least <= most).then_some([least, most])
    };
    let joint = |named: &Option<String>| match (named, &instance.target) {
        (Some(name), _) => dofs.iter().position(|dof| dof.joint == *name),
        (None, Target::Joint(joint)) => Some(*joint),
        (None, _) => None,
    };
    let moments_over_weight = || {
        let evaluator = Evaluator::new(problem.first().model, Function::GravityMoments);
        evaluator.run(&data.q, data.len())
    };
    let composed = instance.effect.composed().into_iter();
    let variables = composed.flat_map(|own| own.definition().function.variables());
    let range = |variable: &Variable| match variable {
        Variable::Position(named) => column(&data.q, dofs.len(), joint(named)?),
        Variable::Moment(named) => {
            let range = column(&moments_over_weight(), dofs.len(), joint(named)?);
            range.map(|ends| ends.map(|end| problem.context().weight() * end))
        }
        Variable::Reading(axis) => column(&data.reading, 2, *axis),
        Variable::Time => {
            let layout = PostureContext::of(problem.context().robot);
            column(&data.posture_context, layout.len(), layout.time())
        }
        _ => None,
    };
    let ranges = variables.filter_map(|variable| Some((variable.to_string(), range(&variable)?)));
    ranges.collect()
}

/// Compare what is stated of an explanation with what its `file` predicts of the log, and
/// check that no command refuses the file.
///
/// # Errors
/// When one does.
pub(super) fn on_log(problem: &Problem, best: &Fit, file: &ModelFile) -> Result<ModelOnLog, Error> {
    // Effects of a caller's own are no part of files.
    let standard = Catalog::standard();
    let is_known = |record: &EffectRecord| {
        record.function.is_some() || standard.named(&record.effect).is_some()
    };
    if file.effects.iter().all(is_known) {
        problem.first().model.clone().with_file(file.clone())?;
    }
    let (first, mut apart) = (problem.first(), held_out::apart(problem, best));
    let stated = held_out::errors_of(problem, best);
    let predicted = in_file(problem, best, &problem.params_of(best));
    let pairs = first.data.reading.iter().zip(&predicted[0].readings);
    let predicted: Vec<f64> = pairs.map(|(y, p)| y - p).collect();
    // On which side of its dead band a joint rests near no moment, the log knows and a
    // posture alone does not.
    let before = apart.iter().filter(|apart| **apart).count();
    for k in (0..apart.len()).filter(|_| best.is_loose()) {
        let off = |row: usize| (predicted[row] - stated[row]).abs() * first.weight[row];
        apart[k] |= off(2 * k).max(off(2 * k + 1)) > OTHER_SIDE;
    }
    let poses = first.data.pose.iter().zip(&apart);
    let poses = poses.filter_map(|(pose, apart)| apart.then_some(*pose));
    let left_out: Vec<i64> = poses.collect();
    let error = |errors: &[f64]| {
        let rows = (0..errors.len()).filter(|row| !apart[row / 2]);
        rms(rows.map(|row| errors[row]))
    };
    let (stated_rmse, predicted_rmse) = (error(&stated), error(&predicted));
    let slack = FILE_AGREES * stated_rmse.max(first.data.noise_floor);
    let few = ((left_out.len() - before) as f64) <= LARGEST_OUTLIER_SHARE * apart.len() as f64;
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
    // On which side a loose joint rests, the file decides by its own masses.
    let loose = fit.is_loose();
    if !loose && agrees(problem, problem, fit) {
        return same();
    }
    let with = |fit: &Fit, masses: Vec<f64>| {
        let misfit = misfit(problem, fit, &masses);
        let mut fit = fit.clone();
        fit.masses = Some(masses);
        (misfit, fit)
    };
    let (mut least, mut best) = with(fit, problem.params_of(fit));
    if loose && !problem.is_wider() {
        // A prior that holds no masses lets those of light links be anything.
        let usual = with(fit, problem.usual_params(fit));
        if usual.0 < least {
            (least, best) = usual;
        }
    }
    let (mut about, mut part) = (problem.params_of(&best), 1.0);
    for _ in 0..ROUNDS {
        let own = linearised(problem, &best, &about);
        let next = own.fit(&fit.terms, Some(&best));
        let settled = !loose && agrees(problem, &own, &next);
        let masses = own.params_of(&next);
        let (misfit, next) = with(&next, masses.clone());
        if !loose || misfit < (1.0 - GAIN) * least {
            (least, best) = (misfit, next);
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
    let own = linearised(problem, &best, &problem.params_of(&best));
    let stated = stated(
        &own,
        &in_file(problem, &best, &problem.params_of(&best)),
        best,
    );
    (Cow::Owned(own), stated)
}

/// What a file with an explanation predicts of each block, where base parameters of the first are
/// `masses`, m.
fn in_file(problem: &Problem, fit: &Fit, masses: &[f64]) -> Vec<InFile> {
    let own = |block| problem.carried(block, &fit.terms, &fit.unknowns);
    let predicted = problem
        .blocks
        .iter()
        .map(|block| block.in_file(&own(block), masses));
    predicted.collect()
}

/// Whether the masses at which a fit ends predict what its linear problem, `about` some masses,
/// states.
fn agrees(problem: &Problem, about: &Problem, fit: &Fit) -> bool {
    let predicted = in_file(problem, fit, &about.params_of(fit));
    let shift = about.mass_shift_of(fit);
    let (mut apart, mut all) = (Vec::new(), Vec::new());
    let blocks = problem.blocks.iter().zip(&fit.blocks);
    for (((block, on), own), range) in blocks.zip(&predicted).zip(problem.readings()) {
        let left = on.residual.rows(0, range.len()) - shift.rows_range(range);
        apart.extend((block.residual(&own.readings) - &left).iter().copied());
        all.extend(left.iter().copied());
    }
    rms(apart.into_iter()) <= AGREES * rms(all.into_iter())
}

/// The problem about masses `r` of the first block (m), its slopes under `fit`.
fn linearised<'m>(problem: &Problem<'m>, fit: &Fit, r: &[f64]) -> Problem<'m> {
    let contexts = problem.posture_contexts(Some(fit));
    let blocks = problem.blocks.iter().zip(&contexts);
    let blocks = blocks.map(|(block, context)| {
        let own = problem.carried(block, &fit.terms, &fit.unknowns);
        block.about(&own, context, r)
    });
    problem.about(blocks.collect())
}

/// χ² that a file leaves.
fn misfit(problem: &Problem, fit: &Fit, masses: &[f64]) -> f64 {
    let predicted = in_file(problem, fit, masses);
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
    misfits.sum()
}

/// A fit, about its masses in `problem`, as its file predicts the logs.
fn stated(problem: &Problem, predicted: &[InFile], fit: Fit) -> Fit {
    let sides = backlash_sides::settle(problem, &fit.terms, &fit.unknowns, fit.is_loose());
    let blocks = || problem.blocks.iter().zip(predicted).zip(&sides);
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
    let weighting = problem.weighting(&fit.terms, fit.outliers.as_ref());
    let mut state = problem.state(&fit.terms, fit.unknowns.clone(), &contexts, &weighting);
    // Springs that give way while loose joints slide end a little elsewhere than springs
    // beside joints at rest: the file's own readings count.
    let on_blocks = state.there.iter_mut().zip(&contexts);
    for (((block, own), sides), (on, context)) in blocks().zip(on_blocks) {
        let mut readings = block.predicted(on);
        for row in (0..readings.len()).filter(|row| !sides.flipped.contains(&(row / 2))) {
            readings[row] = block.of_cad(row, own.readings[row]);
        }
        block.put_readings(&readings, on);
        on.sides = Some(block.sides_of(context));
        on.flipped.clone_from(&sides.flipped);
    }
    let covariance = problem.covariance(&state, &problem.scales(&fit.terms), &weighting);
    Fit {
        covariance,
        unknowns: state.unknowns,
        blocks: state.there,
        ..fit
    }
}

/// State for every member of the class how far its CoM is from the first one's, m RMS over
/// the postures of the log; unknown where an effect is no part of model files. Where they are far
/// apart and one leaves the CoM where CAD has it, the model holds that one: data ask for no more.
pub(super) fn state_com_apart(problem: &Problem, nothing: &Fit, found: &mut Explained) {
    let others = found.class.iter().filter(|fit| !fit.terms.is_empty());
    let coms_of_all: Vec<_> = others.map(|fit| coms(problem, fit)).collect();
    let apart = |from: &Option<Vec<f64>>| -> Vec<Option<f64>> {
        let of = |own: &Option<Vec<f64>>| Some(distance(from.as_ref()?, own.as_ref()?));
        coms_of_all.iter().map(of).collect()
    };
    let from_first = apart(&coms(problem, &found.best));
    if from_first
        .iter()
        .flatten()
        .any(|apart| *apart > COM_APART_M)
    {
        let moved = apart(&coms(problem, nothing)).into_iter().enumerate();
        let moved = moved.filter_map(|(k, moved)| Some((k, moved?)));
        let moved = moved.filter(|(_, moved)| *moved <= COM_APART_M);
        if let Some((least, _)) = moved.min_by(|a, b| a.1.total_cmp(&b.1)) {
            found.written = found.class[least].clone();
        }
    }
    for (member, apart) in found.diagnosis.class.iter_mut().zip(from_first) {
        member.com_apart = apart;
    }
}

/// The sentence where CoMs differ by more than a controller may overlook: with a sensor that is off
/// the CoM is where CAD has it, with a payload that leaves the same readings it is not.
pub(super) fn com_sentence(found: &Explained) -> Option<String> {
    let members = found.diagnosis.class.iter().skip(1);
    let far = members.filter_map(|member| Some((member.com_apart?, member)));
    let (apart, member) = far.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (apart > COM_APART_M).then(|| {
        let written = found.class.iter().zip(&found.diagnosis.class);
        let mut written = written.filter(|(fit, _)| fit.terms == found.written.terms);
        let held = written.next().map_or_else(String::new, |(_, own)| {
            format!("; the model holds {}", own.subjects)
        });
        format!(
            "These explanations do not agree on the CoM: with {} it lies {:.1} mm RMS away; \
             take the next postures before a controller relies on it{held}.",
            member.subjects,
            1e3 * apart
        )
    })
}

/// CoM (x, y, z) of every posture under an explanation, m.
fn coms(problem: &Problem, fit: &Fit) -> Option<Vec<f64>> {
    let model = problem.first().model.clone();
    let model = model.with_file(model_file(problem, fit)).ok()?;
    let n = problem.data().len();
    Some(Evaluator::new(&model, Function::Com).run(&problem.data().q, n))
}

/// RMS distance of points, x, y, z after each other.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    (3.0 * squares / a.len().max(1) as f64).sqrt()
}
