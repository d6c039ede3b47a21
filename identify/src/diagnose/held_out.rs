//! Errors on postures that a fit did not see.

use super::hypothesis::Term;

use super::criteria;
use super::findings::{Gap, HeldOut};
use super::problem::{Fit, Problem};
use crate::fit::HELD_OUT_TIMES;
use crate::observations::correlation::step;
use crate::observations::postures::rms;

/// Part that each posture is held out with: stretches of a log in time, several times as
/// long as noise lasts; of a log without times every 20th posture. Visits of a posture are held
/// out together.
pub(super) fn parts(problem: &Problem) -> Vec<usize> {
    let data = problem.data();
    let n = data.len();
    let most = criteria::FOLDS.min(n);
    let timed = data.t.as_deref().is_some_and(|t| step(t).is_some());
    // Noise lasts half as many rows as an independent one takes.
    let lasts = 0.5 * problem.rows_per_sample();
    let stretches = (n as f64 / (HELD_OUT_TIMES * lasts)) as usize;
    let folds = stretches.clamp(2.min(n), most);
    let part = |k: usize, n: usize| if timed { k * folds / n } else { k % most };
    let first = &data.first_visits;
    if first.is_empty() {
        return (0..n).map(|k| part(k, n)).collect();
    }
    let firsts: Vec<usize> = (0..n).filter(|k| first[*k] == *k).collect();
    let posture = |k: &usize| firsts.partition_point(|at| at < k);
    let parts = first.iter().map(|k| part(posture(k), firsts.len()));
    parts.collect()
}

/// Cross-validation of a hypothesis: each posture predicted without itself. Postures
/// that are `apart` do not count.
pub(super) fn cross_validate(problem: &Problem, whole: &Fit, apart: &[bool]) -> HeldOut {
    let n = problem.data().len();
    if whole.terms.is_empty() && problem.masses(&[]).is_negligible() {
        return of_errors(errors_of(problem, whole), apart);
    }
    let parts = parts(problem);
    let mut errors = vec![f64::NAN; 2 * n];
    for fold in 0..=parts.iter().copied().max().unwrap_or(0) {
        let keep: Vec<bool> = parts.iter().map(|part| *part != fold).collect();
        let mut others = problem.clone();
        others.kept = Some(keep);
        let own = errors_of(&others, &others.fit(&whole.terms, Some(whole)));
        for row in (0..2 * n).filter(|row| parts[row / 2] == fold) {
            errors[row] = own[row];
        }
    }
    of_errors(errors, apart)
}

/// Errors of the robot with CAD masses.
pub(super) fn of_cad(problem: &Problem) -> HeldOut {
    let (first, data) = (problem.first(), problem.data());
    let out = first.evaluate(&[], &[], &data.q, &data.posture_context);
    let errors = data.reading.iter().zip(&out).map(|(y, p)| y - p);
    of_errors(errors.collect(), &vec![false; data.len()])
}

/// reading − prediction, masses as the kept postures suggest, or as `fit` is stated with.
pub(super) fn errors_of(problem: &Problem, fit: &Fit) -> Vec<f64> {
    let shift = match &fit.masses {
        Some(_) => problem.mass_shift(fit),
        None => problem.mass_shift_of(fit),
    };
    let left = fit.blocks[0].residual.iter().zip(shift.iter());
    let left = left.zip(&problem.first().weight);
    left.map(|((e, s), w)| (e - s) / w).collect()
}

/// Postures that no prediction is to be judged by.
pub(super) fn apart(problem: &Problem, fit: &Fit) -> Vec<bool> {
    apart_on_the_way(problem, fit, fit)
}

/// Postures that a step towards `best` is not judged by: where it has outliers or dead
/// bands, those that `best` leaves out for them. The step's own would not do: an effect
/// that is still missing makes every posture look like an outlier.
pub(super) fn apart_on_the_way(problem: &Problem, step: &Fit, best: &Fit) -> Vec<bool> {
    let outlying = step.terms.contains(&Term::Outliers);
    let mut apart = vec![false; problem.data().len()];
    if let Some(outliers) = best.outliers.as_ref().filter(|_| outlying) {
        outliers.named().into_iter().for_each(|k| apart[k] = true);
    }
    if step.is_loose() {
        best.blocks[0].flipped.iter().for_each(|&k| apart[k] = true);
    }
    apart
}

fn of_errors(mut errors: Vec<f64>, apart: &[bool]) -> HeldOut {
    for row in (0..errors.len()).filter(|row| apart[row / 2]) {
        errors[row] = f64::NAN;
    }
    let axis = |a: usize| {
        let own = errors.iter().skip(a).step_by(2).copied();
        own.filter(|e| !e.is_nan()).collect::<Vec<f64>>()
    };
    let (x, y) = (axis(0), axis(1));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    HeldOut {
        gap: Gap {
            rmse: rms(x.iter().chain(&y).copied()),
            rmse_x: rms(x.iter().copied()),
            rmse_y: rms(y.iter().copied()),
            bias: [mean(&x), mean(&y)],
        },
        left_out: apart.iter().filter(|a| **a).count(),
        errors,
    }
}

/// Effects in the order in which they close the gap, each by its place among those of `best` and
/// with those before it: the next one is the one that lowers the objective most beside them.
pub(super) fn order(best: &Fit, fit: &mut dyn FnMut(&[Term]) -> Fit) -> Vec<(usize, Fit)> {
    let mut left: Vec<usize> = (0..best.terms.len()).collect();
    let mut taken: Vec<Term> = Vec::new();
    let mut steps = Vec::new();
    while !left.is_empty() {
        let tried = left.iter().enumerate().map(|(k, &place)| {
            let terms = [&taken[..], &best.terms[place..=place]].concat();
            (k, fit(&terms))
        });
        let (k, next) = tried
            .min_by(|a, b| a.1.score().total_cmp(&b.1.score()))
            .expect("something is left");
        let place = left.remove(k);
        taken.push(best.terms[place].clone());
        steps.push((place, next));
    }
    steps
}
