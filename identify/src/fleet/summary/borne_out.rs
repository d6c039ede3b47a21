//! Whether the data of a robot changed where its explanation did.
//!
//! An explanation is chosen among many, and another one is chosen on another day by chance. What
//! is fitted without effects is no choice: an effect that comes moves base parameters, or leaves
//! a gap that they do not follow.
//!
//! ```text
//! parameters   δᵀ (C_before + C_after)⁻¹ δ / (n s²)   against Fisher's law
//! gap          Σν e²/Σν after over before             against Fisher's law, to both sides
//! ```
//!
//! δ is the difference between the means θ̄ = C Σ C_d⁻¹ θ_d of the n base parameters, C⁻¹ =
//! Σ C_d⁻¹ over the days d before or after; s widens deviations by what days of the fleet scatter
//! between which no explanation changes. Together parameters tell more than each alone: an offset
//! of a joint moves many of them along a direction that is known far better than any of them.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF as _, FisherSnedecor};

use super::course::freedom;
use super::criteria::changes::{BORNE_OUT, PAIRS};
use super::history::History;
use crate::fleet::row::{Row, Size};

/// Median of the square of a standard normal number.
pub(super) const MEDIAN_OF_SQUARES: f64 = 0.454_936;
/// A parameter of which a fit claims a smaller deviation is known exactly, m.
const EXACT: f64 = 1e-9;

/// Whether what is fitted without effects differs between the days `before` and those `after`,
/// of deviations that are `widening` times as large as fits say.
pub(super) fn is_borne_out(before: &[&Row], after: &[&Row], widening: f64) -> bool {
    let parameters = chance_of_parameters(before, after, widening);
    let least = parameters.min(chance_of_gaps(before, after));
    // Of two kinds of numbers.
    2.0 * least < BORNE_OUT
}

/// How many times as much days scatter as their deviations say, of neighbouring days with the
/// same explanation; 1 at least, and where there are too few of them.
pub(super) fn scatter(histories: &[History]) -> f64 {
    let (mut squares, mut pairs) = (Vec::new(), 0);
    for stretch in histories.iter().flat_map(History::stretches) {
        let same = stretch.windows(2).filter(|pair| {
            pair[0].params.len() == pair[1].params.len() && explained(pair[0]) == explained(pair[1])
        });
        for pair in same {
            pairs += 1;
            squares.extend(squares_between(pair[0], pair[1]).flatten());
        }
    }
    match pairs < PAIRS {
        true => 1.0,
        false => widening_of(squares),
    }
}

/// The effects of a row's explanation with their targets.
fn explained(row: &Row) -> BTreeSet<(&str, &str)> {
    let effects = row.effects.iter();
    effects
        .map(|found| (found.effect.as_str(), found.target.as_str()))
        .collect()
}

/// The factor by which deviations are too small of which these are the squared differences over
/// their variance; 1 at least.
pub(super) fn widening_of(mut squares: Vec<f64>) -> f64 {
    if squares.is_empty() {
        return 1.0;
    }
    let middle = squares.len() / 2;
    let (_, median, _) = squares.select_nth_unstable_by(middle, f64::total_cmp);
    (*median / MEDIAN_OF_SQUARES).max(1.0).sqrt()
}

/// Squared differences of two days over their variance, parameter by parameter; none where a day
/// does not know it.
pub(super) fn squares_between<'r>(
    one: &'r Row,
    other: &'r Row,
) -> impl Iterator<Item = Option<f64>> + 'r {
    (0..one.params.len()).map(move |k| {
        let (a, b) = (size(one, k, 1.0)?, size(other, k, 1.0)?);
        Some((a.value - b.value).powi(2) / (a.std.powi(2) + b.std.powi(2)))
    })
}

/// A parameter of a row with its widened deviation.
pub(super) fn size(row: &Row, k: usize, widening: f64) -> Option<Size> {
    let (value, std) = (*row.params.get(k)?, (*row.std.get(k)?)?);
    (std > 0.0).then_some(Size {
        value,
        std: widening * std,
    })
}

/// The chance that base parameters differ so much where none changed.
fn chance_of_parameters(before: &[&Row], after: &[&Row], widening: f64) -> f64 {
    let differing = || {
        let uncertain = uncertain(before.iter().chain(after).copied())?;
        let (one, other) = (mean(before, &uncertain)?, mean(after, &uncertain)?);
        let n = uncertain.len() as f64;
        let gap = other.value - one.value;
        let together = (one.covariance + other.covariance).cholesky()?;
        let ratio = gap.dot(&together.solve(&gap)) / (n * widening * widening);
        let law = FisherSnedecor::new(n, freedom(before) + freedom(after)).ok()?;
        Some(law.sf(ratio))
    };
    differing().unwrap_or(1.0)
}

/// The parameters that days differ by, of those rows that have covariances: a parameter of links
/// without mass is known exactly, and would make every covariance singular.
///
/// None where no row has a covariance or rows have other parameters, and where all are exact.
fn uncertain<'r>(rows: impl Iterator<Item = &'r Row>) -> Option<Vec<usize>> {
    let known: Vec<DMatrix<f64>> = rows.filter_map(Row::covariance).collect();
    let n = known.first()?.nrows();
    if known.iter().any(|covariance| covariance.nrows() != n) {
        return None;
    }
    let is_uncertain = |&k: &usize| known.iter().all(|c| c[(k, k)] > EXACT * EXACT);
    let uncertain: Vec<usize> = (0..n).filter(is_uncertain).collect();
    (!uncertain.is_empty()).then_some(uncertain)
}

/// Mean of some parameters of several days, and its covariance.
struct Mean {
    value: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The mean of the parameters `of` these rows; none where no day has a covariance of them.
fn mean(rows: &[&Row], of: &[usize]) -> Option<Mean> {
    let mut sums: Option<(DMatrix<f64>, DVector<f64>)> = None;
    for row in rows {
        let own = row.covariance();
        let own = own.map(|covariance| covariance.select_rows(of).select_columns(of));
        let Some(factor) = own.and_then(|covariance| covariance.cholesky()) else {
            continue;
        };
        let precision = factor.inverse();
        let values = DVector::from_iterator(of.len(), of.iter().map(|&k| row.params[k]));
        let vector = &precision * values;
        sums = match sums {
            None => Some((precision, vector)),
            Some((sum, of_vectors)) => Some((sum + precision, of_vectors + vector)),
        };
    }
    let (precision, vector) = sums?;
    let factor = precision.cholesky()?;
    Some(Mean {
        value: factor.solve(&vector),
        covariance: factor.inverse(),
    })
}

/// The chance that held-out gaps differ so much where nothing changed.
fn chance_of_gaps(before: &[&Row], after: &[&Row]) -> f64 {
    let pooled = |rows: &[&Row]| {
        let known = rows
            .iter()
            .filter_map(|row| Some((*row, row.held_out_rmse?)));
        let (mut squares, mut free) = (0.0, 0.0);
        for (row, rmse) in known {
            let own = freedom(&[row]);
            squares += own * rmse * rmse;
            free += own;
        }
        (free > 0.0).then_some((squares / free, free))
    };
    let (Some((one, free_one)), Some((other, free_other))) = (pooled(before), pooled(after)) else {
        return 1.0;
    };
    let (larger, smaller) = match one > other {
        true => ((one, free_one), (other, free_other)),
        false => ((other, free_other), (one, free_one)),
    };
    if smaller.0 <= 0.0 {
        return if larger.0 > 0.0 { 0.0 } else { 1.0 };
    }
    let law = FisherSnedecor::new(larger.1, smaller.1);
    law.map_or(1.0, |law| 2.0 * law.sf(larger.0 / smaller.0))
}
