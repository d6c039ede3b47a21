//! What no effect of the list explains: how much is left of readings and of soles, and what it
//! goes with.
//!
//! ```text
//! share = 1 − Σ_bins Σ (e − ē_bin)² / Σ (e − ē)² · (n − 1)/(n − bins)
//! ```
//!
//! Postures are sorted by the position of a joint, by its gravity moment or by their place in the
//! log, and cut into bins of equally many; e are residuals in units of their noise.

use std::ops::Range;

use sesc_model::effects::PostureContext;

use super::criteria::{BINS, PER_BIN};
use super::findings::Suspect;
use super::outliers::Outliers;
use super::problem::{Fit, Problem};
use super::{criteria, held_out};
use crate::feet::ClosureFound;

/// Suspects that are listed.
const LISTED: usize = 3;

/// χ² of what is left against what noise leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Misfit {
    pub chi2: f64,
    pub expected: f64,
    /// Rows per independent one: χ² scatters as much more.
    pub rows_per_sample: f64,
}

impl Misfit {
    pub(super) fn of(problem: &Problem, fit: &Fit) -> Misfit {
        let masses = problem.masses(&fit.terms);
        let shift = problem.mass_shift(fit);
        let outliers = fit.outliers.iter().flat_map(Outliers::named);
        let outliers: Vec<usize> = outliers.collect();
        let (mut chi2, mut rows) = (0.0, 0.0);
        let blocks = problem.blocks.iter().zip(&fit.blocks);
        for (at, ((block, own), range)) in blocks.zip(problem.readings()).enumerate() {
            let is_apart = |k: usize| own.flipped.contains(&k) || at == 0 && outliers.contains(&k);
            for (row, at) in range.enumerate().filter(|(row, _)| !is_apart(row / 2)) {
                // Against the noise as it is, however few samples the rows are worth.
                let left = (own.residual[row] - shift[at]) * block.widened[row % 2];
                chi2 += left.powi(2);
                rows += 1.0;
            }
        }
        Misfit {
            chi2,
            expected: (rows - fit.unknowns.len() as f64 - masses.directions()).max(1.0),
            rows_per_sample: problem.rows_per_sample(),
        }
    }

    /// Standard deviations beyond what noise leaves.
    pub(super) fn deviations(self) -> f64 {
        (self.chi2 - self.expected) / (2.0 * self.expected * self.rows_per_sample).sqrt()
    }

    pub(super) fn is_clear(self) -> bool {
        self.deviations() > criteria::LEFTOVER_DEVIATIONS
            && self.chi2 > criteria::LEFTOVER_RATIO * self.expected
    }
}

/// What the residual goes with, each with its share of the scatter, the strongest first.
pub(super) fn suspects(problem: &Problem, fit: &Fit) -> Vec<(Suspect, f64)> {
    let (shift, apart) = (problem.mass_shift(fit), held_out::apart(problem, fit));
    // Whitened, without what masses take, of the postures that judge.
    let left = |row: usize| fit.blocks[0].residual[row] - shift[row];
    let postures: Vec<usize> = (0..apart.len()).filter(|&k| !apart[k]).collect();
    let share = |of: &dyn Fn(usize) -> f64| Bins::new(postures.clone(), of).share(left, 0..2).0;
    let data = problem.data();
    let robot = problem.context().robot;
    let (layout, dofs) = (PostureContext::of(robot), &robot.tree.dofs);
    let moments = problem.first().moments_at(&data.q);
    let place = |k: usize| data.posture_context[k * layout.len() + layout.place()];
    let mut found = vec![(Suspect::Place, share(&place))];
    for (j, dof) in dofs.iter().enumerate() {
        let position = |k: usize| data.q[k * dofs.len() + j];
        let moment = |k: usize| moments[k * 3 * dofs.len() + j];
        let joint = || dof.joint.clone();
        found.push((Suspect::Position(joint()), share(&position)));
        found.push((Suspect::Moment(joint()), share(&moment)));
    }
    found.retain(|(_, share)| *share > 0.0);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.truncate(LISTED);
    found
}

/// Postures by the size of a quantity, equally many in each bin.
pub(super) struct Bins(pub Vec<Vec<usize>>);

impl Bins {
    pub(super) fn new(mut postures: Vec<usize>, of: impl Fn(usize) -> f64) -> Bins {
        postures.sort_by(|&a, &b| of(a).total_cmp(&of(b)));
        let count = (postures.len() / PER_BIN).clamp(1, BINS);
        let cut = |bin: usize| bin * postures.len() / count;
        let bins = (0..count).map(|bin| postures[cut(bin)..cut(bin + 1)].to_vec());
        Bins(bins.collect())
    }

    /// Share of the scatter of residuals (x, y per posture) on some axes that the bins' means
    /// explain, and how much of it that is.
    pub(super) fn share(&self, residual: impl Fn(usize) -> f64, axes: Range<usize>) -> (f64, f64) {
        let scatter = |postures: &[usize]| -> f64 {
            let of_axis = |axis: usize| {
                let rows = || postures.iter().map(|k| residual(2 * k + axis));
                let mean = rows().sum::<f64>() / postures.len() as f64;
                rows().map(|e| (e - mean).powi(2)).sum::<f64>()
            };
            axes.clone().map(of_axis).sum()
        };
        let all = self.0.concat();
        let within: f64 = self.0.iter().map(|bin| scatter(bin)).sum();
        let (whole, n, bins) = (scatter(&all), all.len(), self.0.len());
        if !(whole > 0.0 && n > bins) {
            return (0.0, 0.0);
        }
        let share = 1.0 - within / whole * (n - 1) as f64 / (n - bins) as f64;
        (share.max(0.0), share.max(0.0) * whole)
    }
}

/// Whether more is left of the soles than noise leaves.
pub(super) fn is_open(problem: &Problem, fit: &Fit) -> bool {
    closure_found(problem, fit, fit).is_some_and(|found| !found.closes)
}

/// What is said of the soles, by CAD (`null`) and with the explanation.
pub(super) fn closure_found(problem: &Problem, null: &Fit, best: &Fit) -> Option<ClosureFound> {
    let first = problem.first();
    let [before, after] = [null, best].map(|fit| first.soles_of(&fit.blocks[0]));
    let found = first.closure.as_ref()?.said(&before, &after);
    let changed = !best.terms.is_empty() && found.after != found.before;
    Some(found.explained(changed))
}
