//! Whether the noise that is stated is far larger than what an explanation leaves.

use super::findings::{Found, Verdict};
use super::leftover::Misfit;
use super::problem::Problem;
use crate::health::{Finding, Leftover, Picture};

/// A finding where it is, and where there are samples enough to know.
pub(super) fn overstated(problem: &Problem, found: &Found) -> Option<Finding> {
    if found.diagnosis.verdict == Verdict::Unusable {
        return None;
    }
    let misfit = Misfit::of(problem, &found.best);
    let rows = 2.0 * problem.data.len() as f64;
    Leftover {
        chi2: misfit.chi2,
        expected: misfit.expected,
        taken: rows - misfit.expected,
        samples: rows / misfit.rows_per_sample,
        noise_m: problem.data.noise,
        floor_m: problem.data.noise_floor,
        source: problem.data.noise_source,
    }
    .overstated_noise()
    .map(|finding| Finding {
        picture: Some(left(problem, found)),
        ..finding
    })
}

/// What is left of each posture, mm.
fn left(problem: &Problem, found: &Found) -> Picture {
    let left = |row: usize| 1e3 * found.best.residual[row] / problem.weight[row];
    let postures = (0..problem.data.len()).step_by(1 + problem.data.len() / 500);
    Picture {
        title: "What is left of the CoP, mm".to_string(),
        points: postures
            .flat_map(|k| [0, 1].map(|axis| (k + 1, left(2 * k + axis), true)))
            .collect(),
    }
}
