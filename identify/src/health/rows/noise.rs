//! Noise that is stated beside what CAD leaves of the rows, with nothing fitted, and beside what is
//! left by the best that explains a log.
//!
//! ```text
//! e = y − p_CAD(q)        χ² = mean of (e/σ)²        n: independent samples of e
//! s = σ √(χ² / ν)         ν: rows less what was fitted, χ² in units of σ
//! ```
//!
//! What CAD leaves is the noise and whatever CAD does not know: an upper bound of the noise that no
//! fit has taken anything of. Noise that lasts for seconds leaves fewer independent samples than a
//! fit has unknowns; then only this bound tells. Readings of a robot that moves are compared with
//! the CoP and, where that leaves too much, with the ZMP.

use nalgebra::{DMatrix, DVector};
use sesc_model::Model;
use statrs::distribution::{ChiSquared, ContinuousCDF as _};

use super::{LeftOut, LogRows};
use crate::health::criteria::{OVERSTATED, OVERSTATED_BY_CHANCE, SAMPLES_PER_UNKNOWN};
use crate::health::view::evenly;
use crate::health::{Finding, Kind, Picture};
use crate::observations::correlation::Correlation;
use crate::observations::noise::NoiseSource;

/// A finding where the noise is several times what CAD leaves of the rows that are kept.
pub(super) fn beside_cad(rows: &LogRows, model: &Model, left_out: &LeftOut) -> Option<Finding> {
    rows.noise?;
    let kept = evenly(rows.kept(left_out).into_iter(), 10_000);
    told(rows, rows.as_read(&kept)).or_else(|| told(rows, rows.still(&kept, model)?))
}

/// A finding by what CAD leaves of some rows with these readings, m.
fn told(rows: &LogRows, mut all: Vec<(usize, [f64; 2])>) -> Option<Finding> {
    for (k, y) in &mut all {
        (0..2).for_each(|axis| y[axis] -= rows.cad[*k][axis]);
    }
    let count = all.len();
    let noise = rows.noise?;
    let axes = [0, 1].map(|axis| {
        let sigma = |k: usize| rows.block.std.as_ref().map_or(noise, |std| std[k][axis]);
        let over = all.iter().map(|(k, gap)| gap[axis] / sigma(*k));
        DVector::from_iterator(count, over)
    });
    let square = axes.iter().map(|e| e.norm_squared()).sum::<f64>() / (2 * count) as f64;
    let source = match rows.block.std {
        Some(_) => NoiseSource::Stated,
        None => NoiseSource::Given,
    };
    let finding = overstated(noise, source, noise * square.sqrt())?;
    // Without times of all rows nothing tells which follow each other.
    let t = rows.block.t.as_ref();
    let t: Option<Vec<f64>> = t.map(|t| all.iter().map(|(k, _)| t[*k]).collect());
    let samples = axes.iter().map(|gaps| {
        let nothing_fitted = DMatrix::zeros(count, 0);
        let known = t.as_ref();
        let known = known.map(|t| Correlation::of(t, gaps, &nothing_fitted));
        count as f64 / known.unwrap_or(Correlation::NONE).rows_per_sample
    });
    let samples: f64 = samples.sum();
    is_no_chance(square * samples, samples).then(|| {
        let title = "What CAD leaves of the CoP, mm";
        let row = |k: usize| rows.row(all[k].0);
        let left = |k: usize| all[k].1.map(|gap| (1e3 * gap, true)).to_vec();
        finding.showing(Picture::new(title, count, row, left))
    })
}

/// What a fit leaves.
#[derive(Debug, Clone, Copy)]
pub struct FitResiduals {
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

impl FitResiduals {
    /// A finding where the noise is stated and several times what is left, and nothing that was
    /// found `before` says or explains it: beside an encoder that is stuck, rows are told
    /// deviations that the log does not state, and data that cannot be used leave anything.
    pub fn overstated_noise(&self, before: &[Finding]) -> Option<Finding> {
        let explains = |kind: Kind| {
            matches!(kind, Kind::EncoderStuck | Kind::NoiseOverstated) || kind.makes_unusable()
        };
        if before.iter().any(|finding| explains(finding.kind)) {
            return None;
        }
        let left = self.floor_m * (self.chi2 / self.expected.max(1.0)).sqrt();
        overstated(self.noise_m, self.source, left).filter(|_| self.is_known())
    }

    /// Whether as little as is left says that noise is less than it should be, and not that
    /// the fit took it.
    fn is_known(&self) -> bool {
        if self.samples > SAMPLES_PER_UNKNOWN * self.taken.max(5.0) {
            return true;
        }
        // How many samples correlated rows are worth is an estimate; too many, and what the
        // fit took of them is counted too low.
        let independent = self.samples >= 0.99 * (self.expected + self.taken);
        independent && is_no_chance(self.chi2, self.expected)
    }
}

/// A finding where noise is told and several times what is `left_m` of the readings.
pub(super) fn overstated(noise_m: f64, source: NoiseSource, left_m: f64) -> Option<Finding> {
    let is_told = matches!(source, NoiseSource::Given | NoiseSource::Stated);
    (is_told && OVERSTATED * left_m < noise_m).then(|| {
        Finding::new(
            Kind::NoiseOverstated,
            "-",
            format!(
                "The noise is {:.2} mm {} and readings scatter by {:.2} mm: widths and thresholds \
                 are larger than they need be. State the deviation of a single reading, or leave \
                 it out.",
                1e3 * noise_m,
                source.phrase(),
                1e3 * left_m
            ),
        )
    })
}

/// Whether chance leaves no χ² as small as this of so many degrees of freedom.
pub(super) fn is_no_chance(chi2: f64, freedom: f64) -> bool {
    ChiSquared::new(freedom).is_ok_and(|law| law.cdf(chi2) < OVERSTATED_BY_CHANCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of 1 mm stated as 4 mm, with `expected` rows beside 80 unknowns.
    fn four_times(expected: f64, rows_per_sample: f64) -> FitResiduals {
        FitResiduals {
            chi2: expected / 16.0,
            expected,
            taken: 80.0,
            samples: (expected + 80.0) / rows_per_sample,
            noise_m: 4e-3,
            floor_m: 4e-3,
            source: NoiseSource::Stated,
        }
    }

    #[test]
    fn few_rows_tell_what_chance_does_not() {
        // A χ² of 1/16 of its mean: once in 10⁴ with six rows, once in 10¹⁰ with fifteen.
        assert!(four_times(3.0, 1.0).overstated_noise(&[]).is_none());
        assert!(four_times(15.0, 1.0).overstated_noise(&[]).is_some());
        assert!(four_times(120.0, 1.0).overstated_noise(&[]).is_some());
        // 200 rows of correlated noise may be worth no more than what was fitted.
        assert!(four_times(120.0, 2.0).overstated_noise(&[]).is_none());
        assert!(four_times(1000.0, 2.0).overstated_noise(&[]).is_some());
        // A fifth less than stated is no finding, however well it is known.
        let mut known = four_times(1e5, 1.0);
        known.chi2 = 0.64 * known.expected;
        assert!(known.overstated_noise(&[]).is_none());
    }

    #[test]
    fn what_another_finding_explains_is_not_said() {
        let left = four_times(120.0, 1.0);
        let beside = |kind| left.overstated_noise(&[Finding::new(kind, "-", String::new())]);
        assert!(beside(Kind::EncoderStuck).is_none());
        assert!(beside(Kind::FrameTurned).is_none());
        assert!(beside(Kind::NoiseOverstated).is_none());
        assert!(beside(Kind::RowsCopied).is_some());
    }
}
