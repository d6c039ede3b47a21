//! How many independent samples a log in time is worth.
//!
//! ```text
//! y = X b + e        s² = Var(e_k)        n_eff = n s² / (Δt S)        S = ∫ Cov(e(t), e(t + h)) dh
//! S = h σ_h² (1 + ρ_h)/(1 − ρ_h)          σ_h², ρ_h of means over windows of h seconds
//! ```
//!
//! What counts is S, the noise at frequencies slower than the robot's motion. It is read
//! from means over windows that are about as long as the noise lasts: an AR(1) process
//! fitted to single rows takes smooth noise for one that lasts for ever, and a slow sway
//! under the white noise of a sensor for a short one. σ_h and ρ_h are found by restricted
//! maximum likelihood (Patterson and Thompson, Biometrika 58, 1971): the residuals of a
//! fit have lost their slow part to the fit's own columns X, and their plain
//! autocorrelation would count two to three times too many samples. Columns whose coefficients
//! a prior holds take less of it: they stand beside rows `0 = b_k + N(0, 1)` of their own.
//! Stamps may be uneven.
//!
//! Where an AR(1) process under white noise leaves nothing that neighbours say of each other, it is
//! used if it is likelier by far than one alone, or if one alone leaves something.

mod mixture;
mod restricted;
mod windows;

use std::borrow::Cow;
use std::ops::Range;

use super::criteria::correlation::{
    ALIKE, BACKWARDS, ENOUGH, ENOUGH_APART, FEW, FILTERED, LEAP, MEANS_S, OF_WINDOWS, ROOM, SCALED,
    UNDER_WHITE, WORTH_LESS,
};
use super::criteria::{AS_GOOD, CERTAIN};
use super::noise::quantile;
use nalgebra::{DMatrix, DVector};

use restricted::{Ar1Process, AxisRows};
pub(crate) use windows::{Cut, GAP, Independent, Process, Whitener};

/// What a log's residuals say of its noise, on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation {
    /// Integrated correlation time, s; zero where samples are independent.
    pub time_s: f64,
    /// Samples per independent one, n/n_eff, 1 and more.
    pub rows_per_sample: f64,
    /// Variance of a row, in units of y²; 1 where samples are independent.
    pub variance: f64,
    /// The process, where samples are not independent.
    pub process: Option<Process>,
}

/// The noise as windows of one length show it.
struct Scale {
    windows: usize,
    process: Process,
    rho: f64,
    rows_per_sample: f64,
    variance: f64,
    significant: bool,
    /// What the process leaves is white: it is one of this scale.
    consistent: bool,
}

impl Correlation {
    /// Correlation of independent samples.
    pub const NONE: Correlation = Correlation {
        time_s: 0.0,
        rows_per_sample: 1.0,
        variance: 1.0,
        process: None,
    };

    /// Estimate it from what a fit leaves of `y` (over its deviations), whose columns are
    /// `x`, at times `t` (s).
    pub fn of(t: &[f64], y: &DVector<f64>, x: &DMatrix<f64>) -> Correlation {
        Correlation::with_held(t, y, x, 0)
    }

    /// The same where the coefficients of the last `held` columns are drawn from N(0, 1), and columns
    /// count as means over rows that are near in time.
    pub fn with_held(t: &[f64], y: &DVector<f64>, x: &DMatrix<f64>, held: usize) -> Correlation {
        let n = t.len();
        let Some(step) = step(t).filter(|_| n >= ENOUGH) else {
            return Correlation::NONE;
        };
        let x = match held {
            0 => Cow::Borrowed(x),
            _ => Cow::Owned(without_noise(t, x)),
        };
        let fit = Fitted::new((t, y), &x, held);
        let mut chosen: Option<Scale> = None;
        let (mut rows, mut most) = (1, n);
        let mut before = f64::INFINITY;
        while let Some(scale) = Scale::cut(&fit, Cut::new(rows, step), most) {
            // A slow part under a fast one shows about twice as much in windows twice as long.
            // Where more shows, few windows beside the columns are what the fit has left; many
            // that a process describes are right, and the shorter ones were not. Which process
            // it is, is not asked of more than can be filtered.
            let described = scale.consistent || scale.windows > FILTERED;
            let known = described && scale.windows >= ROOM * fit.taken;
            if scale.rows_per_sample > LEAP * before && !known {
                break;
            }
            before = scale.rows_per_sample;
            // Windows that gaps keep from growing say nothing new.
            most = scale.windows * 3 / 4;
            let better = |chosen: &Scale| {
                let times = scale.rows_per_sample / chosen.rows_per_sample;
                let shorter = chosen.rho >= ENOUGH_APART && scale.rho > 0.0;
                scale.significant && (shorter || times > WORTH_LESS)
            };
            // An AR(1) process of rows that are close to each other needs no windows.
            let of_rows = rows == 1 && (scale.rho >= ENOUGH_APART || !scale.significant);
            let done = scale.consistent && (of_rows || scale.process.share < 1.0);
            if done || chosen.as_ref().is_none_or(better) {
                chosen = Some(scale);
            }
            if done {
                break;
            }
            rows *= 2;
        }
        Correlation::at(chosen, n, step)
    }

    /// The same where the robot holds still: rows of one stay, which `stays` are, count
    /// together as soon as they are not independent. Where stays are too few for that,
    /// rows are looked at as they are.
    pub fn of_stays(
        t: &[f64],
        y: &DVector<f64>,
        x: &DMatrix<f64>,
        stays: &[Range<usize>],
    ) -> Correlation {
        let Some(step) = step(t).filter(|_| stays.len() >= x.ncols() + ENOUGH) else {
            return Correlation::of(t, y, x);
        };
        let fit = Fitted::new((t, y), x, 0);
        let whole = Scale::of(&fit, stays, Cut::new(usize::MAX, step));
        Correlation::at(whole, t.len(), step)
    }

    fn at(chosen: Option<Scale>, rows: usize, step: f64) -> Correlation {
        match chosen.filter(|scale| scale.significant && scale.rows_per_sample > 1.0) {
            Some(scale) => Correlation {
                time_s: 0.5 * step * scale.rows_per_sample,
                rows_per_sample: scale.rows_per_sample.min(rows as f64),
                variance: scale.variance,
                process: Some(scale.process),
            },
            None => Correlation::NONE,
        }
    }
}

/// Columns as means over rows that are near in time: the noise of joints that a row holds is in its
/// column and in its residual, and would pass for what the column explains.
fn without_noise(t: &[f64], columns: &DMatrix<f64>) -> DMatrix<f64> {
    let near = |a: usize, b: usize| (0.0..=MEANS_S).contains(&(t[b] - t[a]));
    let (mut first, mut last) = (0, 0);
    let windows = (0..t.len()).map(|k| {
        first = (first..k).find(|row| near(*row, k)).unwrap_or(k);
        last = last.max(k);
        while last + 1 < t.len() && near(k, last + 1) {
            last += 1;
        }
        first..last + 1
    });
    let windows: Vec<_> = windows.collect();
    let mut means = columns.clone();
    for (mut mean, column) in means.column_iter_mut().zip(columns.column_iter()) {
        let mut sums = vec![0.0];
        sums.extend(column.iter().scan(0.0, |sum, x| {
            *sum += x;
            Some(*sum)
        }));
        for (mean, window) in mean.iter_mut().zip(&windows) {
            *mean = (sums[window.end] - sums[window.start]) / window.len() as f64;
        }
    }
    means
}

/// The ordinary step of times that run forward; `None` of others.
pub(crate) fn step(t: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let all = steps.len() as f64;
    steps.retain(|step| *step > 0.0);
    if (steps.len() as f64) < (1.0 - BACKWARDS) * all {
        return None;
    }
    quantile(steps.into_iter(), 0.5)
}

/// Mean square of what a fit of the columns `x` leaves of `y`, and its degrees of freedom.
pub(crate) fn left(x: &DMatrix<f64>, y: &DVector<f64>) -> (f64, f64) {
    let q = x * restricted::basis(x);
    let (n, p) = q.shape();
    if n <= p {
        return (f64::NAN, 0.0);
    }
    let taken = q.transpose() * y;
    let rest = (y.norm_squared() - taken.norm_squared()).max(0.0);
    (rest / (n - p) as f64, (n - p) as f64)
}

/// Rows at times `t`, and columns that are fitted, of which the last ones have known sizes.
struct Fitted<'a> {
    t: &'a [f64],
    y: &'a DVector<f64>,
    x: &'a DMatrix<f64>,
    held: usize,
    /// How much of a fit the columns take from rows of deviation one.
    taken: usize,
}

impl<'a> Fitted<'a> {
    /// The last `held` columns of `x` have coefficients of deviation one.
    fn new((t, y): (&'a [f64], &'a DVector<f64>), x: &'a DMatrix<f64>, held: usize) -> Fitted<'a> {
        let free = x.ncols() - held;
        let own = x.columns(free, held);
        let known = own.transpose() * own + DMatrix::identity(held, held);
        // tr (I + KᵀK)⁻¹ KᵀK
        let untaken = known.cholesky().map(|factor| factor.inverse().trace());
        let taken = held as f64 - untaken.unwrap_or(0.0);
        Fitted {
            t,
            y,
            x,
            held,
            taken: free + taken.ceil() as usize,
        }
    }
}

impl Scale {
    /// Estimate from windows cut like this; `None` where they are too few, or more than `most`.
    fn cut(fit: &Fitted, cut: Cut, most: usize) -> Option<Scale> {
        let windows = windows::whole(fit.t, cut);
        let times = if cut.rows == 1 { 1 } else { 2 };
        let enough = (times * fit.taken + ENOUGH..=most).contains(&windows.len());
        enough.then(|| Scale::of(fit, &windows, cut)).flatten()
    }

    /// Estimate from these windows.
    fn of(fit: &Fitted, windows: &[Range<usize>], cut: Cut) -> Option<Scale> {
        let (x, held, taken) = (fit.x, fit.held, fit.taken);
        let n = windows.len();
        let mean = |column: &[f64]| -> Vec<f64> {
            let own = windows.iter().map(|window| &column[window.clone()]);
            own.map(|own| own.iter().sum::<f64>() / own.len() as f64)
                .collect()
        };
        let middle = mean(fit.t);
        let of_y = DVector::from_vec(mean(fit.y.as_slice()));
        let mut of_x = DMatrix::zeros(n, x.ncols());
        for k in 0..x.ncols() {
            of_x.set_column(k, &DVector::from_vec(mean(x.column(k).as_slice())));
        }
        let joined: Vec<bool> = (0..n).map(|k| k > 0 && middle[k] > middle[k - 1]).collect();
        let rows = AxisRows {
            t: middle,
            joined,
            x: of_x,
            y: of_y,
        };
        // Columns that were free at first would take the noise of joints, and keep it.
        let mut with_held = (held > 0).then(|| rows.with_coefficients(held, 1.0));
        let mut found = restricted::estimate(with_held.as_ref().unwrap_or(&rows))?;
        for _ in 1..SCALED {
            if let Some(all) = &mut with_held {
                *all = rows.with_coefficients(held, found.variance.sqrt());
                found = restricted::estimate(all)?;
            }
        }
        let leaves_white = |found: &Ar1Process| {
            let left = &rows.y - &rows.x * &found.params;
            let left = DMatrix::from_row_slice(1, n, left.as_slice());
            let (innovations, _) = mixture::whitened(&rows, left, found.tau, found.share);
            is_white(innovations.as_slice(), taken)
        };
        let mut consistent = leaves_white(&found);
        if found.gain > AS_GOOD && n <= FILTERED {
            // Where both leave nothing, the simpler is taken unless it is less likely by far.
            let least = match consistent {
                true => found.gain + UNDER_WHITE,
                false => found.gain,
            };
            let mixture = mixture::estimate(with_held.as_ref().unwrap_or(&rows))
                .filter(|it| it.gain > least)
                .filter(leaves_white);
            if let Some(mixture) = mixture {
                (found, consistent) = (mixture, true);
            }
        }
        let share = found.share;
        // The ordinary distance of neighbouring windows, s.
        let step = rows.step().unwrap_or(f64::INFINITY);
        let rows = windows.iter().map(Range::len).sum::<usize>() as f64 / n as f64;
        // What varies within windows is what averaging took from the variance of a row.
        let within = match cut.rows {
            1 => 0.0,
            _ => within(&(fit.y - x * &found.params), windows),
        };
        let row = found.variance + within;
        let left = found.variance / row;
        let least = if cut.rows == 1 { AS_GOOD } else { OF_WINDOWS };
        let correlated = found.gain > least;
        let rho = restricted::lasting(step, if correlated { found.tau } else { 0.0 });
        // Beside white noise, whose share is found with it, ρ is that of the lasting part itself.
        let lasting_long = match share < 1.0 {
            true => (1.0 + rho) / (1.0 - rho),
            false => lasts(rho, rows),
        };
        let rows_per_sample = rows * left * (1.0 - share + share * lasting_long);
        let deviations = (rows * left - 1.0) / (2.0 / found.freedom).sqrt();
        let lasting = match rows > 1.0 {
            true => ((rows * left - 1.0) / (rows - 1.0)).clamp(0.0, 1.0),
            false => 1.0,
        };
        Some(Scale {
            windows: n,
            process: Process {
                cut,
                // That of AR(1) means which last as long.
                tau_s: match (lasting_long - 1.0) / (lasting_long + 1.0) {
                    same if same > 0.0 => -step / same.ln(),
                    _ => 0.0,
                },
                share,
                lasting,
            },
            rho,
            rows_per_sample,
            variance: row,
            significant: correlated || deviations > CERTAIN,
            consistent,
        })
    }
}

/// S in units of h σ_h² for windows of `rows` rows of an AR(1) process whose means have
/// the correlation `rho` with their neighbours:
///
/// ```text
/// m² σ_h² = m (1 + a)/(1 − a) − 2 a (1 − aᵐ)/(1 − a)²        m² ρ_h σ_h² = a (1 − aᵐ)²/(1 − a)²
/// ```
fn lasts(rho: f64, rows: f64) -> f64 {
    if rho <= 0.0 {
        return 1.0;
    }
    let of = |a: f64| {
        let (left, power) = (1.0 - a, a.powf(rows));
        let variance = rows * (1.0 + a) / left - 2.0 * a * (1.0 - power) / (left * left);
        let covariance = a * (1.0 - power).powi(2) / (left * left);
        (covariance / variance, rows * (1.0 + a) / left / variance)
    };
    let (mut low, mut high) = (0.0, 1.0 - 1e-9);
    for _ in 0..60 {
        let a = 0.5 * (low + high);
        match of(a).0 < rho {
            true => low = a,
            false => high = a,
        }
    }
    of(low).1
}

/// Whether neighbours say nothing of each other, and means of more of them scatter by no
/// more than those of independent ones. `p` columns have been fitted, which slow parts
/// lack.
///
/// ```text
/// VR(q) = q Var(mean of q)/Var        sd ≈ √(2 (q − 1)/n)    (Lo and MacKinlay 1988)
/// ```
fn is_white(e: &[f64], p: usize) -> bool {
    let n = e.len();
    let square = e.iter().map(|e| e * e).sum::<f64>();
    let product: f64 = e.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if product.abs() > ALIKE * square / (n as f64).sqrt() {
        return false;
    }
    let mut q = 2;
    while q * FEW * (p + 1) <= n {
        let means = e.chunks_exact(q).map(|own| own.iter().sum::<f64>());
        let ratio =
            means.map(|sum| sum * sum).sum::<f64>() / (n / q * q) as f64 * n as f64 / square;
        let part = q as f64;
        let deviation = (2.0 * (part - 1.0) / n as f64).sqrt();
        if ratio > 1.0 + CERTAIN * deviation {
            return false;
        }
        q *= 2;
    }
    true
}

/// Mean square of what residuals of rows differ from their windows' means.
fn within(left: &DVector<f64>, windows: &[Range<usize>]) -> f64 {
    let (mut sum, mut rows) = (0.0, 0);
    for window in windows {
        let own = &left.as_slice()[window.clone()];
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        sum += own.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        rows += own.len();
    }
    sum / rows as f64
}

#[cfg(test)]
mod tests;
