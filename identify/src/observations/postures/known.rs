//! What is known of the noise of postures before anything is fitted.
//!
//! ```text
//! std of a mean of n rows    s/√n        √(Σ s_k²)/n where rows state s_k
//! ```
//!
//! Rows of one stay that are correlated tell less: s √f(n) ([`super::super::stays`]), unless
//! what visits differ by says it all.

use super::super::correlation::Correlation;
use super::super::noise::{self, Known, NoiseSource};
use super::super::stays::of_mean;
use super::gathering::{Gathering, Posture};
use super::rms;
use crate::observations::criteria::noise::SCATTER;

/// Noise of the mean reading of each posture.
pub(super) struct Noise {
    pub per_entry: Vec<[f64; 2]>,
    pub overall: f64,
    pub source: NoiseSource,
    pub warning: Option<String>,
    /// How rows are correlated within their stays, where it counts.
    pub within: [Correlation; 2],
}

impl Noise {
    /// `given` is that of a row, m.
    /// Rows of a log that is not `timed` are independent.
    pub fn of(gathering: &Gathering, stated: bool, timed: bool, given: Option<f64>) -> Noise {
        let all = &gathering.kept;
        let rows: f64 = all.iter().map(|p| p.rows).sum();
        let variance = || all.iter().flat_map(|p| p.variance).sum::<f64>();
        let known = Known {
            given,
            stated: stated.then(|| (variance() / (2.0 * rows)).sqrt()),
            repeats: gathering.repeats.pure().both(),
        };
        let Some(noise) = noise::Noise::known(&known) else {
            // Filled in later from what is left over.
            return Noise {
                per_entry: vec![[f64::NAN; 2]; all.len()],
                overall: f64::NAN,
                source: NoiseSource::Residuals,
                warning: None,
                within: [Correlation::NONE; 2],
            };
        };
        let mut per_entry = match stated {
            true => Noise::stated(all),
            false => all.iter().map(|p| [1.0 / p.rows.sqrt(); 2]).collect(),
        };
        let repeats = noise.source == NoiseSource::Repeats;
        let of_axis = match repeats && !stated {
            true => gathering.repeats.pure().by_axis(),
            false => [1.0; 2],
        };
        for entry in &mut per_entry {
            for axis in 0..2 {
                entry[axis] *= noise.sigma * of_axis[axis];
            }
        }
        let within = match timed && !(repeats && gathering.repeats.by_visits()) {
            true => gathering.stays.correlation(),
            false => [Correlation::NONE; 2],
        };
        for axis in 0..2 {
            let Correlation {
                variance, process, ..
            } = within[axis];
            if process.is_none() {
                continue;
            }
            // The scatter about the means of stays has lost the slow part of the noise.
            let row = if repeats { variance.max(1.0) } else { 1.0 };
            for (entry, posture) in per_entry.iter_mut().zip(all) {
                let part = posture.rows * of_mean(&within[axis], posture.rows);
                entry[axis] *= (row * part).sqrt();
            }
        }
        Noise {
            overall: rms(per_entry.iter().flatten().copied()),
            per_entry,
            source: noise.source,
            warning: noise.warning(),
            within,
        }
    }

    /// Deviations that are all about alike are estimates of the same number,
    /// and their mean square is a better one than each.
    fn stated(all: &[Posture]) -> Vec<[f64; 2]> {
        let own = |p: &Posture, axis: usize| p.variance[axis].sqrt() / p.rows;
        let mut per_entry: Vec<[f64; 2]> = all.iter().map(|p| [own(p, 0), own(p, 1)]).collect();
        for axis in 0..2 {
            let together = rms(per_entry.iter().map(|s| s[axis]));
            let away = rms(per_entry.iter().map(|s| s[axis] - together));
            if away < SCATTER * together {
                per_entry.iter_mut().for_each(|s| s[axis] = together);
            }
        }
        per_entry
    }
}
