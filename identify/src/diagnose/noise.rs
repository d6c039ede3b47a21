//! Whether the noise that is stated is far larger than what an explanation leaves.

use super::findings::{Found, Verdict};
use super::leftover::Misfit;
use super::problem::Problem;
use crate::health::{Finding, Leftover};

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
}
