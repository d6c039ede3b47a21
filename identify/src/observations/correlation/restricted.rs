//! Restricted likelihood of an AR(1) process, at the cost of a few products of matrices.
//!
//! ```text
//! z_k = (x_k, y_k)      M(τ) = Σ_k (z_k − ρ_k z_{k−1})(z_k − ρ_k z_{k−1})ᵀ / (1 − ρ_k²)
//! ρ_k = exp(−(t_k − t_{k−1})/τ)      RSS = M_yy − M_yx M_xx⁻¹ M_xy      σ² = RSS/(n − p)
//! −2 log L = (n − p) log σ² + Σ log(1 − ρ_k²) + log det M_xx
//! ```
//!
//! Steps of about one length share their ρ: the sums of `z_k z_kᵀ`, `z_k z_{k−1}ᵀ` and
//! `z_{k−1} z_{k−1}ᵀ` over them are taken once, and every τ costs p³ more, however many
//! rows there are. X is replaced by an orthonormal basis of its columns, so that squaring
//! it loses nothing.

use std::collections::BTreeMap;

use crate::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Singular values of the scaled columns of X below this part of the largest are rounding.
const DEPENDENT: f64 = 1e-6;
/// Steps whose lengths differ by less than this part are one.
const ALIKE: f64 = 0.15;
/// Correlation times that are tried, and how often the best is refined.
const TRIED: usize = 40;
const REFINED: usize = 12;
/// The shortest that is tried, in steps; the longest, as a part of the length.
const SHORTEST: f64 = 0.2;
const LONGEST: f64 = 0.5;
/// 1 − ρ² is no smaller.
const LEAST: f64 = 1e-12;

/// An AR(1) process that residuals look like.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ar1Process {
    /// s; zero where residuals are white.
    pub tau: f64,
    /// Variance of one row.
    pub variance: f64,
    /// Twice the log likelihood that correlation gains over none.
    pub gain: f64,
    /// Rows beyond the columns of X.
    pub freedom: f64,
    /// Coefficients of the columns of X.
    pub params: DVector<f64>,
}

/// Sums over steps of about one length.
struct Lag {
    /// Σ of lengths, s, and number.
    length: f64,
    count: f64,
    here: DMatrix<f64>,
    cross: DMatrix<f64>,
    before: DMatrix<f64>,
}

/// Rows of one axis as sums.
struct Sums {
    rows: usize,
    /// Rows that begin a stretch.
    first: DMatrix<f64>,
    lags: Vec<Lag>,
}

/// Estimate the process from rows (x, y) at times `t`; `joined[k]` says whether row k
/// follows row k − 1 within a stretch. Coefficients of the last `held` columns have deviation
/// one where a row has `deviation`: rows of their own say so.
pub(super) fn estimate(
    t: &[f64],
    joined: &[bool],
    x: &DMatrix<f64>,
    y: &DVector<f64>,
    (held, deviation): (usize, f64),
) -> Option<Ar1Process> {
    if held > 0 && deviation > 0.0 {
        let all = with_coefficients(t, joined, x, y, (held, deviation));
        return estimate(&all.t, &all.joined, &all.x, &all.y, (0, 0.0));
    }
    let turn = basis(x);
    let q = x * &turn;
    let (n, p) = q.shape();
    if n < p + 3 {
        return None;
    }
    let mut z = q.insert_column(p, 0.0);
    z.set_column(p, y);
    let sums = Sums::of(t, joined, &z);
    let white = sums.likelihood(0.0)?;
    let freedom = (n - p) as f64;
    let none = Ar1Process {
        tau: 0.0,
        variance: white.variance,
        gain: 0.0,
        freedom,
        params: &turn * &white.params,
    };
    let steps = steps(t, joined);
    if steps.is_empty() {
        return Some(none);
    }
    let (low, high) = (
        SHORTEST * steps[steps.len() / 2],
        LONGEST * (t[n - 1] - t[0]),
    );
    if high <= low {
        return Some(none);
    }
    let at = |part: f64| low * (high / low).powf(part);
    let of = |part: f64| {
        sums.likelihood(at(part))
            .map_or(f64::NEG_INFINITY, |l| l.value)
    };
    let grid = (0..=TRIED).map(|k| k as f64 / TRIED as f64);
    let best = grid
        .map(|part| (of(part), part))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut best = best;
    let mut step = 0.5 / TRIED as f64;
    for _ in 0..REFINED {
        for part in [best.1 - step, best.1 + step] {
            let tried = of(part.clamp(0.0, 1.0));
            if tried > best.0 {
                best = (tried, part.clamp(0.0, 1.0));
            }
        }
        step *= 0.6;
    }
    let tau = at(best.1);
    let found = sums.likelihood(tau)?;
    match found.value > white.value {
        true => Some(Ar1Process {
            tau,
            variance: found.variance,
            gain: 2.0 * (found.value - white.value),
            freedom,
            params: turn * found.params,
        }),
        false => Some(none),
    }
}

/// Rows of the log, and behind them one for each coefficient that is known.
pub(super) struct WithCoefficients {
    pub t: Vec<f64>,
    pub joined: Vec<bool>,
    pub x: DMatrix<f64>,
    pub y: DVector<f64>,
}

/// Rows that say that the coefficients of the last `held` columns are zero, within one where
/// a row is known within `deviation`.
pub(super) fn with_coefficients(
    t: &[f64],
    joined: &[bool],
    x: &DMatrix<f64>,
    y: &DVector<f64>,
    (held, deviation): (usize, f64),
) -> WithCoefficients {
    let (n, p) = x.shape();
    let last = t.last().copied().unwrap_or_default();
    let mut own = x.clone().insert_rows(n, held, 0.0);
    (0..held).for_each(|k| own[(n + k, p - held + k)] = deviation);
    WithCoefficients {
        t: [t, &vec![last; held]].concat(),
        joined: [joined, &vec![false; held]].concat(),
        x: own,
        y: y.clone().insert_rows(n, held, 0.0),
    }
}

/// Distances of neighbouring rows of a stretch, s, the shortest first.
pub(super) fn steps(t: &[f64], joined: &[bool]) -> Vec<f64> {
    let mut steps: Vec<f64> = (1..t.len())
        .filter(|&k| joined[k])
        .map(|k| t[k] - t[k - 1])
        .collect();
    steps.sort_by(f64::total_cmp);
    steps
}

/// What rows say of one process.
pub(super) struct Likelihood {
    /// Restricted log likelihood less a constant.
    pub value: f64,
    /// Variance of one row.
    pub variance: f64,
    /// Estimates of the basis columns' coefficients.
    pub params: DVector<f64>,
}

/// Mean square of what a fit leaves, and its degrees of freedom, of independent rows.
pub(super) fn white(x: &DMatrix<f64>, y: &DVector<f64>) -> Option<(f64, f64)> {
    let q = x * basis(x);
    let (n, p) = q.shape();
    let taken = q.transpose() * y;
    let rest = (y.norm_squared() - taken.norm_squared()).max(0.0);
    (n > p).then(|| (rest / (n - p) as f64, (n - p) as f64))
}

impl Sums {
    fn of(t: &[f64], joined: &[bool], z: &DMatrix<f64>) -> Sums {
        let n = z.nrows();
        let mut classes: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        let mut first = Vec::new();
        for k in 0..n {
            match k > 0 && joined[k] {
                true => {
                    let step = (t[k] - t[k - 1]).ln() / ALIKE;
                    classes.entry(step.round() as i64).or_default().push(k);
                }
                false => first.push(k),
            }
        }
        let product = |a: &DMatrix<f64>, b: &DMatrix<f64>| a.transpose() * b;
        let lags = classes.into_values().map(|rows| {
            let here = z.select_rows(&rows);
            let previous: Vec<usize> = rows.iter().map(|k| k - 1).collect();
            let before = z.select_rows(&previous);
            let cross = product(&here, &before);
            Lag {
                length: rows.iter().map(|&k| t[k] - t[k - 1]).sum(),
                count: rows.len() as f64,
                here: product(&here, &here),
                before: product(&before, &before),
                cross: &cross + cross.transpose(),
            }
        });
        let alone = z.select_rows(&first);
        Sums {
            rows: n,
            first: product(&alone, &alone),
            lags: lags.collect(),
        }
    }

    fn likelihood(&self, tau: f64) -> Option<Likelihood> {
        let mut all = self.first.clone();
        let mut log_det = 0.0;
        for lag in &self.lags {
            let rho = match tau > 0.0 {
                true => (-lag.length / lag.count / tau).exp(),
                false => 0.0,
            };
            let left = (1.0 - rho * rho).max(LEAST);
            log_det += lag.count * left.ln();
            all += (&lag.here - &lag.cross * rho + &lag.before * (rho * rho)) / left;
        }
        Likelihood::of(&all, self.rows, log_det)
    }
}

impl Likelihood {
    /// The likelihood of so many rows (x, y), whose products M they have once their correlation
    /// is taken from them; `log_det` is that of their covariance, in units of a row's variance.
    pub fn of(products: &DMatrix<f64>, rows: usize, log_det: f64) -> Option<Likelihood> {
        let p = products.ncols() - 1;
        let of_x = products.view((0, 0), (p, p)).into_owned();
        let of_xy = products.view((0, p), (p, 1)).column(0).into_owned();
        let of_y = products[(p, p)];
        let factor = of_x.cholesky()?;
        let params = factor.solve(&of_xy);
        let rest = (of_y - of_xy.dot(&params)).max(f64::EPSILON * of_y);
        let diagonal = factor.l_dirty().diagonal();
        let log_det_x: f64 = diagonal.iter().map(|d| 2.0 * d.ln()).sum();
        let freedom = (rows - p) as f64;
        let variance = (rest / freedom).max(f64::MIN_POSITIVE);
        Some(Likelihood {
            value: -0.5 * (freedom * variance.ln() + log_det + log_det_x),
            variance,
            params,
        })
    }
}

/// T with X T an orthonormal basis of the columns of X that are not tiny or copies of
/// others.
pub(super) fn basis(x: &DMatrix<f64>) -> DMatrix<f64> {
    let sizes: Vec<f64> = x.column_iter().map(|column| column.norm()).collect();
    let unit = |size: f64| if size > 0.0 { 1.0 / size } else { 0.0 };
    let mut r = match x.nrows() > x.ncols() {
        true => x.clone().qr().r(),
        false => x.clone(),
    };
    for (mut column, size) in r.column_iter_mut().zip(&sizes) {
        column.scale_mut(unit(*size));
    }
    let svd = svd(r, false, true);
    let Some(v) = svd.v_t else {
        return DMatrix::zeros(x.ncols(), 0);
    };
    let least = DEPENDENT * svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > least)
        .collect();
    let mut turn = v.select_rows(&kept).transpose();
    for (column, &k) in kept.iter().enumerate() {
        turn.column_mut(column)
            .scale_mut(1.0 / svd.singular_values[k]);
    }
    for (mut row, size) in turn.row_iter_mut().zip(&sizes) {
        row.scale_mut(unit(*size));
    }
    turn
}
