//! How many independent readings a log is worth under an explanation.
//!
//! Evidence counts samples: noise that is correlated over many rows would let every effect
//! look certain. Each axis counts `n_eff` of its `n` readings, as if each were known
//! `√(n/n_eff)` times as badly.

use nalgebra::{DMatrix, DVector};

use super::criteria::{COUNTS, LONGER, SIZES, STAYED};
use super::findings::{About, Explained};
use super::hypothesis::{Term, effect_terms};
use super::problem::{Block, Fit, OnBlock, Problem};
use super::search::Beyond;
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
    // Noise of a robot that moves lasts for how long is told beside the list alone.
    let moves = first.data().motion.is_some();
    let beyond = if moves { Beyond::Left } else { Beyond::Tried };
    let mut found = diagnosis::find(&mut problem, about, beyond, watch)?;
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
        found = diagnosis::find(&mut problem, about, beyond, watch)?;
        correlation = correlations(&problem, &found.best);
    }
    // Where rows are independent, a log stays as it is.
    let correlated = |correlation: &[[Correlation; 2]], times: &[[f64; 2]]| {
        let mut problem = first.clone();
        let logs = correlation.iter().zip(times).enumerate();
        for (block, (own, times)) in logs.filter(|(_, (own, _))| counts(own)) {
            problem.correlate_noise(block, *times, own);
        }
        problem
    };
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
        problem = correlated(&correlation, &times);
        found = diagnosis::find(&mut problem, about, beyond, watch)?;
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
    if moves && about.usable {
        problem = correlated(&correlation, &times);
        found = diagnosis::find(&mut problem, about, Beyond::Tried, watch)?;
    }
    Ok((problem, found, correlation))
}

/// Correlation of what a fit leaves on each axis, log by log, beside masses within the usual
/// tolerances of CAD at least, and whatever the sensor and the ground may do: a gap that nothing
/// explains yet would pass for noise that lasts for ever. They do so by a few of their
/// ordinary sizes: columns hold the noise of joints, and a gain of −1 would take that from readings.
fn correlations(problem: &Problem, fit: &Fit) -> Vec<[Correlation; 2]> {
    let masses = match problem.is_wider() {
        true => problem.masses(&[Term::Masses]),
        false => problem.masses(&fit.terms),
    };
    let (context, contexts) = (problem.context(), problem.posture_contexts(Some(fit)));
    let scales = fit.terms.iter().flat_map(|term| term.scales(context));
    let mut slopes = vec![(fit.blocks.clone(), scales.collect::<Vec<f64>>())];
    for term in effect_terms(context) {
        let is_new = term.is_of_all_readings() && !fit.terms.contains(&term);
        if let ([start], true) = (&term.starts(context)[..], is_new) {
            let own = problem.predict(std::slice::from_ref(&term), start, &contexts, None);
            slopes.push((own, term.scales(context)));
        }
    }
    let blocks = problem.blocks.iter().zip(&fit.blocks).enumerate();
    let blocks = blocks.zip(problem.readings());
    let blocks = blocks.map(|((at, (block, own)), range)| {
        let of = |(blocks, scales): &(Vec<OnBlock>, Vec<f64>)| {
            let mut slopes = (*blocks[at].slopes).clone();
            let columns = slopes.column_iter_mut().zip(scales);
            columns.for_each(|(mut column, scale)| column *= SIZES * scale);
            slopes
        };
        let mut held: Vec<DMatrix<f64>> = slopes.iter().map(of).collect();
        if !masses.is_negligible() {
            let columns = masses.columns();
            held.push(columns.rows(range.start, range.len()).into_owned());
        }
        correlation(block, own, &held)
    });
    blocks.collect()
}

/// Correlation of what a fit leaves of a log, about a shift of each axis and beside whitened columns
/// whose coefficients have deviation one.
fn correlation(block: &Block, own: &OnBlock, held: &[DMatrix<f64>]) -> [Correlation; 2] {
    let Some(t) = &block.data.t else {
        return [Correlation::NONE; 2];
    };
    let held: Vec<_> = held.iter().flat_map(DMatrix::column_iter).collect();
    [0, 1].map(|axis| {
        let row = |k: usize| 2 * k + axis;
        let y = DVector::from_fn(t.len(), |k, _| own.residual[row(k)]);
        let x = DMatrix::from_fn(t.len(), 1 + held.len(), |k, c| match c.checked_sub(1) {
            None => block.weight[row(k)],
            Some(c) => held[c][row(k)],
        });
        Correlation::with_held(t, &y, &x, held.len())
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
    let (mut sum, mut rows) = (Sum::default(), 0);
    for (block, correlation) in problem.blocks.iter().zip(correlation) {
        let data = &block.data;
        let timed = data.t.as_ref().is_some_and(|t| step(t).is_some());
        // Rows of the log for one that was looked at.
        let looked_at = data.rows_per_posture * data.len() as f64;
        let every = (data.rows as f64 / looked_at).max(1.0);
        // Postures count by what their stays are worth, and may be correlated themselves.
        let axes = [0, 1].map(|axis| {
            let (within, mut own) = (data.within_stays[axis], correlation[axis]);
            if own.process.is_some() {
                own.rows_per_sample *= every;
            }
            if within.rows_per_sample > 1.0 && data.rows_per_posture > STAYED {
                own.rows_per_sample *= within.rows_per_sample;
                own.time_s = own.time_s.max(within.time_s);
            }
            own
        });
        sum.push(data.rows, &axes, timed);
        rows += data.rows;
    }
    sum.of(rows)
}
