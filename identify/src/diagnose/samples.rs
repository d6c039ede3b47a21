//! How many independent readings a log is worth under an explanation.
//!
//! Evidence counts samples: noise that is correlated over many rows would let every effect
//! look certain. Each axis counts `n_eff` of its `n` readings, as if each were known
//! `√(n/n_eff)` times as badly.

use nalgebra::{DMatrix, DVector};

use super::criteria::{COUNTS, LONGER, STAYED};
use super::findings::{About, Explained};
use super::nuisance::Nuisance;
use super::problem::{Block, Fit, OnBlock, Problem};
use super::{diagnosis, noise};
use crate::Error;
use crate::observations::correlation::{Correlation, step};
use crate::observations::noise::NoiseSource;
use crate::observations::sample_count::{SampleCount, Sum};
use crate::watch::Watch;

/// Rounds in which the number of independent readings and the explanation settle.
const ROUNDS: usize = 3;

/// The best explanation of all logs, with noise counted for as long as it lasts in each; with the
/// correlation of what is left, log by log.
pub(super) fn explained<'m>(
    mut first: Problem<'m>,
    about: &About<'_>,
    watch: &mut dyn Watch,
) -> Result<(Problem<'m>, Explained, Vec<[Correlation; 2]>), Error> {
    let mut problem = first.clone();
    let mut found = diagnosis::find(&mut problem, about, watch)?;
    let mut correlation = correlations(&problem, &found.best);
    // What free masses leave is noise and what they cannot explain; the best explanation can.
    // Where noise lasts, it is no explanation yet.
    for _ in 0..ROUNDS {
        let own = noise::beside(&problem, &found);
        let own = own.filter(|_| about.usable && !counts(&correlation[0]));
        let Some((left, taken)) = own else {
            break;
        };
        first.take_noise(&left, taken);
        problem = first.clone();
        found = diagnosis::find(&mut problem, about, watch)?;
        correlation = correlations(&problem, &found.best);
    }
    let mut times = vec![[1.0; 2]; correlation.len()];
    let mut unknowns = found.best.unknowns.len();
    // What an explanation too many has taken from the noise shows when it is gone, and so does
    // what a wrong one has added to it: a gap that an effect bends wrongly looks like noise that
    // lasts for ever. What fewer unknowns leave has all of the noise in it.
    for _ in 0..ROUNDS {
        if !correlation.iter().any(counts) || !about.usable {
            break;
        }
        for ((times, own), block) in times.iter_mut().zip(&correlation).zip(&problem.blocks) {
            *times = noise_factors(block, *times, own);
        }
        problem = first.clone();
        // Where rows are independent, a log stays as it is.
        for (block, own) in correlation
            .iter()
            .enumerate()
            .filter(|(_, own)| counts(own))
        {
            problem.correlate_noise(block, times[block], own);
        }
        found = diagnosis::find(&mut problem, about, watch)?;
        let again = correlations(&problem, &found.best);
        let fewer = found.best.unknowns.len() < unknowns;
        let pairs = again.iter().flatten().zip(correlation.iter().flatten());
        let changed = pairs.into_iter().any(|(again, before)| {
            let ratio = again.rows_per_sample / before.rows_per_sample;
            ratio > LONGER || fewer && ratio < 1.0 / LONGER
        });
        if !changed {
            break;
        }
        unknowns = found.best.unknowns.len();
        correlation = again;
    }
    Ok((problem, found, correlation))
}

/// Correlation of what a fit leaves on each axis, log by log.
fn correlations(problem: &Problem, fit: &Fit) -> Vec<[Correlation; 2]> {
    let masses = problem.masses(&fit.terms);
    let blocks = problem.blocks.iter().zip(&fit.blocks);
    let blocks = blocks.zip(problem.readings());
    let blocks = blocks.map(|((block, own), range)| correlation(block, own, masses, range.start));
    blocks.collect()
}

/// Correlation of what a fit leaves of a log whose readings begin at a row of those of all.
fn correlation(block: &Block, own: &OnBlock, masses: &Nuisance, from: usize) -> [Correlation; 2] {
    let Some(t) = &block.data.t else {
        return [Correlation::NONE; 2];
    };
    [0, 1].map(|axis| {
        let n = block.data.len();
        let y = DVector::from_fn(n, |k, _| own.residual[2 * k + axis]);
        let unknowns = own.slopes.ncols();
        let columns = masses.columns();
        // Their coefficients have deviation one.
        let held = match masses.is_negligible() {
            true => 0,
            false => columns.ncols(),
        };
        let x = DMatrix::from_fn(n, 1 + unknowns + held, |k, c| match c {
            0 => 1.0,
            c if c <= unknowns => own.slopes[(2 * k + axis, c - 1)],
            c => columns[(from + 2 * k + axis, c - 1 - unknowns)],
        });
        Correlation::with_held(t, &y, &x, held)
    })
}

/// Whether the readings of an axis are not independent enough.
fn counts(correlation: &[Correlation; 2]) -> bool {
    let factors = correlation.map(|axis| axis.rows_per_sample.sqrt());
    factors[0].max(factors[1]) > COUNTS
}

/// How many times as large as residuals of a first fit showed it the noise of each axis is;
/// 1 where it is known from elsewhere. Slow noise hides in that fit: `block`, whose noise is
/// `now` times as large, has what it leaves beside masses that a prior holds.
fn noise_factors(block: &Block, now: [f64; 2], correlation: &[Correlation; 2]) -> [f64; 2] {
    match block.data.noise_source {
        NoiseSource::Residuals => {
            [0, 1].map(|k| now[k] * block.widened[k] * correlation[k].variance.max(0.0).sqrt())
        }
        _ => now,
    }
    .map(|factor| factor.max(1.0))
}

/// Samples of all logs.
pub(super) fn of_logs(problem: &Problem, correlation: &[[Correlation; 2]]) -> SampleCount {
    let mut sum = Sum::default();
    let mut rows = 0;
    for (block, correlation) in problem.blocks.iter().zip(correlation) {
        add(block, correlation, &mut sum);
        rows += block.data.rows;
    }
    sum.of(rows)
}

fn add(block: &Block, correlation: &[Correlation; 2], sum: &mut Sum) {
    let data = &block.data;
    let timed = data.t.as_ref().is_some_and(|t| step(t).is_some());
    // Postures count by what their stays are worth, and may be correlated themselves.
    let rows_of = |k: usize| {
        let (within, beside) = (data.within_stays[k], correlation[k]);
        match within.rows_per_sample > 1.0 && data.rows_per_posture > STAYED {
            true => Correlation {
                rows_per_sample: within.rows_per_sample * beside.rows_per_sample,
                time_s: within.time_s.max(beside.time_s),
                ..beside
            },
            false => beside,
        }
    };
    sum.push(data.rows, &[0, 1].map(rows_of), timed);
}
