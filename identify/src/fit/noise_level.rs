//! How large the noise of a reading is, where that comes from, and how well it
//! is known.
//!
//! ```text
//! s² = RSS / df                  where the F test finds no more in it than in repeats
//! s² = SS_pe / df_pe             where it does
//! interval of 95 %               ± t_{0.975}(df of s) s √C = ± 1.96 σ √C,  σ = w(df) s
//! ```
//!
//! A noise from few repeats is itself uncertain. Deviations of parameters are
//! widened by `w`, so that ± 1.96 of them hold the truth as often as they say.

use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};

use super::gather::Gathered;
use super::identification::NoiseSource;
use super::noise::{self, LackOfFit};

/// A model that leaves more than noise with less than this chance is said to.
pub const UNLIKELY: f64 = 1e-3;
/// A noise of zero would leave nothing to weigh a prior against, m.
const LEAST_NOISE: f64 = 1e-9;
/// Rows beyond the rank without which residuals say nothing of noise.
const FEWEST: f64 = 5.0;
/// Degrees of freedom of repeats without which residuals say more of noise.
const REPEATS: u64 = 10;

/// What a fit without prior leaves over.
#[derive(Debug, Clone, Copy)]
pub struct Leftover {
    /// Σ of squared residuals, in units of the rows' deviations (m² where none are stated).
    pub sum: f64,
    /// Its degrees of freedom.
    pub df: f64,
    /// RMS of what CAD leaves, in the unit of `sum`'s root.
    pub of_cad: f64,
}

/// The noise of a reading.
pub struct Noise {
    /// In units of the weights: 1 where rows are over their deviations.
    pub sigma: f64,
    /// RMS over readings and axes, m.
    pub floor: f64,
    pub source: NoiseSource,
    /// Degrees of freedom that it was estimated with; infinite where it was stated.
    pub df: f64,
    /// How many times the stated noise repeated readings scatter, where that is no chance.
    pub understated: f64,
}

impl Noise {
    /// `given` by the user, m, or else by what is gathered.
    pub fn of(gathered: &Gathered, given: Option<f64>, left: Leftover) -> Noise {
        let stated = stated(gathered);
        let repeats = pure(gathered);
        let noise = |seen: f64, df: f64, source: NoiseSource| Noise {
            sigma: seen,
            floor: seen,
            source,
            df,
            understated: 1.0,
        };
        match (given, stated) {
            // A given noise rescales what rows state of themselves.
            (Some(given), stated) => Noise {
                sigma: given / stated.unwrap_or(1.0),
                ..noise(given, f64::INFINITY, NoiseSource::Given)
            }
            .unless_repeats_scatter_more(repeats, left),
            (None, Some(stated)) => Noise {
                sigma: 1.0,
                ..noise(stated, f64::INFINITY, NoiseSource::Stated)
            }
            .unless_repeats_scatter_more(repeats, left),
            (None, None) if repeats.1 >= REPEATS && repeats.0 > 0.0 => {
                let (square, df) = pooled(repeats, left);
                noise(square.sqrt(), df, NoiseSource::Replicates)
            }
            (None, None) if left.df >= FEWEST && left.sum > 0.0 => {
                let seen = (left.sum / left.df).sqrt();
                noise(seen, left.df, NoiseSource::Residuals)
            }
            // All that is known: readings are off CAD by this.
            (None, None) => {
                let seen = left.of_cad.max(LEAST_NOISE);
                noise(seen, f64::INFINITY, NoiseSource::Unknown)
            }
        }
    }

    /// The noise that repeats show, where it is larger than this one and that is no chance.
    fn unless_repeats_scatter_more(self, (pure, df): (f64, u64), left: Leftover) -> Noise {
        let unit = self.sigma * self.sigma;
        let test = noise::excess(pure / unit, df as f64);
        if test.is_none_or(|test| test.p_value >= UNLIKELY || test.ratio <= 1.0) {
            return self;
        }
        let (square, df) = pooled((pure, df), left);
        let understated = (square / unit).sqrt().max(1.0);
        Noise {
            sigma: self.sigma * understated,
            floor: self.floor * understated,
            source: NoiseSource::Replicates,
            df,
            understated,
        }
    }

    /// Does the fit leave more than this noise?
    pub fn lack_of_fit(&self, gathered: &Gathered, left: Leftover) -> Option<LackOfFit> {
        let by_repeats = noise::lack_of_fit(left.sum, left.df, pure(gathered));
        match self.source {
            NoiseSource::Residuals | NoiseSource::Unknown => None,
            NoiseSource::Replicates => by_repeats,
            // Repeats know better than a statement; without them the statement is all.
            _ => by_repeats.or_else(|| noise::excess(left.sum / self.sigma.powi(2), left.df)),
        }
    }
}

/// RMS of stated deviations over readings and axes, m.
fn stated(gathered: &Gathered) -> Option<f64> {
    let axes = 2.0 * gathered.readings.max(1) as f64;
    let stated = || (gathered.stated / axes).sqrt();
    gathered.has_deviations().then(stated)
}

/// Sum of squares about the means of repeats, in units of the weights, and its
/// degrees of freedom.
fn pure(gathered: &Gathered) -> (f64, u64) {
    let replicates = &gathered.replicates;
    let sum = match gathered.has_deviations() {
        true => replicates.weighted_sum,
        false => replicates.sum,
    };
    (sum, replicates.df)
}

/// Mean square of repeats and residuals together, unless they are not of one size:
/// then of repeats alone. With its degrees of freedom.
fn pooled(repeats: (f64, u64), left: Leftover) -> (f64, f64) {
    let test = noise::lack_of_fit(left.sum, left.df, repeats);
    let alike = |test: LackOfFit| (UNLIKELY..=1.0 - UNLIKELY).contains(&test.p_value);
    match test.is_some_and(alike) {
        true => (left.sum / left.df, left.df),
        false => (repeats.0 / repeats.1 as f64, repeats.1 as f64),
    }
}

/// How many times wider than normal 95 % intervals those are whose noise was
/// estimated with `df` degrees of freedom.
pub fn widening(df: f64) -> f64 {
    const UPPER: f64 = 0.975;
    let normal = Normal::standard().inverse_cdf(UPPER);
    match StudentsT::new(0.0, 1.0, df) {
        Ok(t) if df < 1e6 => t.inverse_cdf(UPPER) / normal,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// t(0.975) from tables: 2.571, 2.179, 1.984 with 5, 12, 100 degrees of freedom.
    #[test]
    fn intervals_are_wider_by_students_t() {
        for (df, t) in [(5.0, 2.5706), (12.0, 2.1788), (100.0, 1.9840)] {
            assert!((1.959_964 * widening(df) - t).abs() < 1e-4, "{df}");
        }
        assert_eq!(widening(f64::INFINITY), 1.0);
    }

    #[test]
    fn repeats_and_residuals_are_one_noise_where_they_are_of_one_size() {
        let left = |sum: f64| Leftover {
            sum,
            df: 42.0,
            of_cad: 1.0,
        };
        // 12 of repeats at 2.0 each, 30 others at 2.2 each.
        let (square, df) = pooled((24.0, 12), left(24.0 + 66.0));
        assert_eq!((square, df), (90.0 / 42.0, 42.0));
        // Others at 60 each, and at 0.02: repeats alone.
        for others in [1800.0, 0.6] {
            assert_eq!(pooled((24.0, 12), left(24.0 + others)), (2.0, 12.0));
        }
    }
}
