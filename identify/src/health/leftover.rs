//! Noise that is stated beside what is left by the best that explains a log.
//!
//! ```text
//! s = σ √(χ² / ν)          ν: rows less what was fitted, χ² in units of σ
//! ```

use super::criteria::{OVERSTATED, SAMPLES_PER_UNKNOWN};
use super::{Finding, Kind};
use crate::observations::noise::NoiseSource;

/// What a fit leaves.
#[derive(Debug, Clone, Copy)]
pub struct Leftover {
    /// χ² of the rows, in units of `floor_m`.
    pub chi2: f64,
    /// What noise alone leaves of it.
    pub expected: f64,
    /// What the fit took of it.
    pub taken: f64,
    /// Independent samples among the rows.
    pub samples: f64,
    /// Noise of a row on one axis, m.
    pub noise_m: f64,
    /// The same with all that was added to it, m.
    pub floor_m: f64,
    /// Where it is known from.
    pub source: NoiseSource,
}

impl Leftover {
    /// A finding where the noise is stated and several times what is left.
    pub fn overstated_noise(&self) -> Option<Finding> {
        let told = matches!(self.source, NoiseSource::Given | NoiseSource::Stated);
        let enough = self.samples > SAMPLES_PER_UNKNOWN * self.taken.max(5.0);
        let left = self.floor_m * (self.chi2 / self.expected.max(1.0)).sqrt();
        (told && enough && OVERSTATED * left < self.noise_m).then(|| {
            Finding::new(
                Kind::NoiseOverstated,
                "-",
                format!(
                    "The noise is {:.2} mm {} and readings scatter by {:.2} mm: widths and \
                     thresholds are larger than they need be. State the deviation of a single \
                     reading, or leave it out.",
                    1e3 * self.noise_m,
                    self.source.phrase(),
                    1e3 * left
                ),
            )
        })
    }
}
