//! How large the noise of a reading is, where that comes from, and how well it
//! is known.
//!
//! ```text
//! s² = SS_pe / df_pe             pure error, where readings repeat
//! s² = RSS / df                  what a fit with free masses leaves, where nothing else tells
//! interval of 95 %               ± t_{0.975}(df of s) s √C = ± 1.96 σ √C,  σ = w(df) s
//! ```
//!
//! A noise from few repeats is itself uncertain. Deviations of parameters are
//! widened by `w`, so that ± 1.96 of them hold the truth as often as they say.

use super::criteria::noise::{ROWS, SHOWS};
use statrs::distribution::{Continuous as _, ContinuousCDF as _, Normal, StudentsT};

use serde::Serialize;

use super::criteria::repeats::{FEWEST, UNLIKELY};
use super::repeats::{self, LackOfFit};

/// Stated deviations below this are taken for it, m: a row that weighs more would drown all others
/// in rounding, and a noise of zero would leave nothing to weigh a prior against.
pub(crate) const LEAST_STD: f64 = 1e-9;
/// Rounds of an estimate without odd values.
const ROUNDS: usize = 10;

/// What a fit without prior leaves over.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FreeResiduals {
    /// Σ of squared residuals, in units of the rows' deviations (m² where none are stated).
    pub sum: f64,
    /// Its degrees of freedom.
    pub df: f64,
    /// RMS of what CAD leaves about its mean, in the unit of `sum`'s root: a shift of all readings is
    /// no noise.
    pub of_cad: f64,
}

/// Where the size of the noise comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum NoiseSource {
    /// Given by the user.
    Given,
    /// Columns of standard deviations.
    Stated,
    /// Repeated readings.
    Repeats,
    /// What a fit with free masses leaves.
    Residuals,
    /// CAD's prediction is all there is: too few rows.
    Unknown,
}

impl NoiseSource {
    /// Its name in reports.
    pub fn phrase(self) -> &'static str {
        match self {
            NoiseSource::Given => "as given",
            NoiseSource::Stated => "as the log states",
            NoiseSource::Repeats => "from repeated readings",
            NoiseSource::Residuals => "from what a fit without prior leaves",
            NoiseSource::Unknown => "not known",
        }
    }
}

/// What is known of the noise of a row before anything is fitted.
#[derive(Debug, Clone, Copy)]
pub struct Known {
    /// Noise that the user states, m.
    pub given: Option<f64>,
    /// RMS of stated deviations over rows and axes, m.
    pub stated: Option<f64>,
    /// Sum of squares about the means of repeats, in units of stated variances (m²
    /// where none are stated), and its degrees of freedom.
    pub repeats: (f64, u64),
}

/// The noise of a row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    /// In units of stated deviations; m where none are stated.
    pub sigma: f64,
    /// RMS over rows and axes, m.
    pub floor: f64,
    /// Where it was taken from.
    pub source: NoiseSource,
    /// Degrees of freedom that it was estimated with; infinite where it was stated.
    pub df: f64,
    /// How many times the stated noise repeated readings scatter, where that is no chance.
    pub understated: f64,
}

impl Noise {
    fn new(seen: f64, df: f64, source: NoiseSource) -> Noise {
        Noise {
            sigma: seen,
            floor: seen,
            source,
            df,
            understated: 1.0,
        }
    }

    /// Given, stated or repeated, in this order; larger where repeats scatter more and
    /// that is no chance. `None` where nothing is known. What a model leaves is no part of it:
    /// it is tested against it.
    pub(crate) fn known(known: &Known) -> Option<Noise> {
        let Known {
            given,
            stated,
            repeats,
        } = *known;
        match (given, stated) {
            // A given noise rescales what rows state of themselves.
            (Some(given), stated) => Some(Noise {
                sigma: given / stated.unwrap_or(1.0),
                ..Noise::new(given, f64::INFINITY, NoiseSource::Given)
            }),
            (None, Some(stated)) => Some(Noise {
                sigma: 1.0,
                ..Noise::new(stated, f64::INFINITY, NoiseSource::Stated)
            }),
            (None, None) if repeats.1 >= FEWEST && repeats.0 > 0.0 => {
                let df = repeats.1 as f64;
                let sigma = (repeats.0 / df).sqrt();
                return Some(Noise::new(sigma, df, NoiseSource::Repeats));
            }
            (None, None) => None,
        }
        .map(|noise| noise.unless_repeats_scatter_more(repeats))
    }

    /// From what a fit leaves, or from what CAD leaves where a fit of few rows leaves
    /// nothing.
    pub(crate) fn left_over(left: FreeResiduals) -> Noise {
        match left.df >= ROWS && left.sum > 0.0 {
            true => Noise::new((left.sum / left.df).sqrt(), left.df, NoiseSource::Residuals),
            false => Noise::new(
                left.of_cad.max(LEAST_STD),
                f64::INFINITY,
                NoiseSource::Unknown,
            ),
        }
    }

    /// The noise that repeats show, where it is larger than this one and that is no chance.
    fn unless_repeats_scatter_more(self, (pure, df): (f64, u64)) -> Noise {
        let (unit, df) = (self.sigma * self.sigma, df as f64);
        let test = repeats::against_stated(pure / unit, df);
        if test.is_none_or(|test| test.p_value >= UNLIKELY || test.ratio <= 1.0) {
            return self;
        }
        let understated = (pure / df / unit).sqrt();
        Noise {
            sigma: self.sigma * understated,
            floor: self.floor * understated,
            source: NoiseSource::Repeats,
            df,
            understated,
        }
    }

    /// That repeats scatter more than is stated, if they do.
    pub(crate) fn warning(&self) -> Option<String> {
        let times = self.understated;
        (times > 1.0).then(|| {
            format!("repeated readings scatter {times:.1} times as much as is stated; the scatter is taken")
        })
    }

    /// Does the fit leave more than this noise? Tested with the degrees of freedom that the noise
    /// is known with.
    pub(crate) fn lack_of_fit(
        &self,
        repeats: (f64, u64),
        left: FreeResiduals,
    ) -> Option<LackOfFit> {
        match self.source {
            NoiseSource::Residuals | NoiseSource::Unknown => None,
            NoiseSource::Repeats => repeats::lack_of_fit(left.sum, left.df, repeats),
            NoiseSource::Given | NoiseSource::Stated => {
                repeats::against_stated(left.sum / self.sigma.powi(2), left.df)
            }
        }
    }
}

/// The value below which a part of values lies; the upper one of two in the middle.
pub(crate) fn quantile(values: impl Iterator<Item = f64>, part: f64) -> Option<f64> {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let at = part * (sorted.len() as f64 - 1.0);
    sorted.get(at.round() as usize).copied()
}

/// Deviation of normal values about zero, of which a few may be odd: the RMS of those within
/// `SHOWS` of it, for what normal values have there; it begins at the median size.
///
/// ```text
/// σ² = mean(x² | |x| < c σ) / (1 − 2 c φ(c) / (2Φ(c) − 1))
/// ```
pub(crate) fn scale(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|x| x.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let Some(median) = sizes.get(sizes.len() / 2) else {
        return 0.0;
    };
    let normal = Normal::standard();
    let inside = 2.0 * normal.cdf(SHOWS) - 1.0;
    let kept = 1.0 - 2.0 * SHOWS * normal.pdf(SHOWS) / inside;
    let mut scale = median / normal.inverse_cdf(0.75);
    for _ in 0..ROUNDS {
        let near = sizes.partition_point(|x| *x <= SHOWS * scale);
        let square = sizes[..near].iter().map(|x| x * x).sum::<f64>() / near.max(1) as f64;
        scale = (square / kept).sqrt();
    }
    scale
}

/// How many times wider than normal 95 % intervals those are whose noise was
/// estimated with `df` degrees of freedom.
pub(crate) fn widening(df: f64) -> f64 {
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

    /// Quantiles of a normal of deviation 2 and, of 5 in 100, values far away: an RMS would be 11.
    #[test]
    fn odd_values_do_not_count() {
        let normal = Normal::new(0.0, 2.0).unwrap();
        let quantile = |k: usize| normal.inverse_cdf((k as f64 + 0.5) / 1000.0);
        let mut values: Vec<f64> = (0..1000).map(quantile).collect();
        assert!((scale(&values) - 2.0).abs() < 0.01, "{}", scale(&values));
        values.extend([50.0; 53]);
        assert!((scale(&values) - 2.0).abs() < 0.01, "{}", scale(&values));
        assert_eq!(scale(&[0.0; 5]), 0.0);
        assert_eq!(scale(&[]), 0.0);
    }
}
