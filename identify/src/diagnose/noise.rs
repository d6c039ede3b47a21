//! Noise beside the best explanation: what it is where nothing states it, whether what is stated is
//! far larger, and what of it only a posture that is reached again tells.

use super::criteria::FALLS;
use super::findings::{Explained, Verdict};
use super::leftover::Misfit;
use super::problem::Problem;
use crate::health::{Finding, FitResiduals, Picture, Row};
use crate::observations::noise::{NoiseSource, scale};
use crate::observations::revisits::Untold;

/// What the best explanation and free masses leave, m, and how many of the readings they take
/// up, where the noise is known from what free masses alone leave and this is less.
pub(super) fn beside(problem: &Problem, found: &Explained) -> Option<(Vec<f64>, f64)> {
    let data = problem.data();
    if data.noise_source != NoiseSource::Residuals || found.best.terms.is_empty() {
        return None;
    }
    let (left, taken) = problem.left_beside_masses(&found.best);
    let share = (1.0 - taken / left.len() as f64).max(0.1).sqrt();
    let own = scale(&left) / share;
    (own < (1.0 - FALLS) * data.noise).then_some((left, taken))
}

/// What a log does not tell of its noise, where a posture that is reached again would: its size, or
/// what visits of one posture differ by, where more is left than readings of single visits scatter.
pub(super) fn untold(problem: &Problem, verdict: Verdict) -> Option<Untold> {
    let data = problem.data();
    let repeats = data.rows_per_posture > 1.0;
    match (verdict, data.noise_source) {
        (Verdict::Unusable, _) => None,
        (_, NoiseSource::Residuals) => Some(Untold::Noise),
        (Verdict::Unexplained, _) if repeats && data.visits.is_none() => Some(Untold::Visits),
        _ => None,
    }
}

/// A finding where it is, and where there are samples enough to know.
pub(super) fn overstated(problem: &Problem, found: &Explained) -> Option<Finding> {
    // Readings from which a joint's position was taken say little of their noise.
    let spent = !problem.data().spent.is_empty();
    if spent || found.diagnosis.verdict == Verdict::Unusable {
        return None;
    }
    let misfit = Misfit::of(problem, &found.best);
    let rows = 2.0 * problem.data().len() as f64;
    FitResiduals {
        chi2: misfit.chi2,
        expected: misfit.expected,
        taken: rows - misfit.expected,
        samples: rows / misfit.rows_per_sample,
        noise_m: problem.data().noise,
        floor_m: problem.data().noise_floor,
        source: problem.data().noise_source,
    }
    .overstated_noise(&found.diagnosis.health)
    .map(|finding| Finding {
        picture: Some(left(problem, found)),
        ..finding
    })
}

/// What is left of each posture, mm.
fn left(problem: &Problem, found: &Explained) -> Picture {
    let left = |row: usize| 1e3 * found.best.blocks[0].residual[row] / problem.first().weight[row];
    let data = problem.data();
    let row = |k: usize| Row::among(&data.pose, &data.q, k);
    Picture::new("What is left of the CoP, mm", data.len(), row, |k| {
        vec![(left(2 * k), true), (left(2 * k + 1), true)]
    })
}
