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

use nalgebra::{DMatrix, DVector};

use crate::observations::noise::quantile;
use crate::svd::svd;

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
    /// Part of the variance that lasts; the rest is white noise.
    pub share: f64,
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

/// Rows (x, y) of one axis at times `t`.
pub(super) struct AxisRows {
    pub t: Vec<f64>,
    /// Whether each row follows the one before within a stretch.
    pub joined: Vec<bool>,
    pub x: DMatrix<f64>,
    pub y: DVector<f64>,
}

impl AxisRows {
    /// The same, and behind them rows that say that the coefficients of the last `held` columns
    /// are zero, within one where a row is known within `deviation`.
    pub(super) fn with_coefficients(&self, held: usize, deviation: f64) -> AxisRows {
        let (n, p) = self.x.shape();
        let last = self.t.last().copied().unwrap_or_default();
        let mut x = self.x.clone().insert_rows(n, held, 0.0);
        (0..held).for_each(|k| x[(n + k, p - held + k)] = deviation);
        AxisRows {
            t: [&self.t[..], &vec![last; held]].concat(),
            joined: [&self.joined[..], &vec![false; held]].concat(),
            x,
            y: self.y.clone().insert_rows(n, held, 0.0),
        }
    }

    /// T with X T an orthonormal basis, and rows (x T, y); none where rows are too few.
    pub(super) fn in_basis(&self) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let turn = basis(&self.x);
        let q = &self.x * &turn;
        let (n, p) = q.shape();
        let mut z = (n >= p + 3).then(|| q.insert_column(p, 0.0))?;
        z.set_column(p, &self.y);
        Some((turn, z))
    }

    /// The ordinary distance of neighbouring rows of a stretch, s.
    pub(super) fn step(&self) -> Option<f64> {
        let joined = (1..self.t.len()).filter(|&k| self.joined[k]);
        quantile(joined.map(|k| self.t[k] - self.t[k - 1]), 0.5)
    }

    /// Correlation times that can be told: the shortest, in steps, and the longest, as a part of
    /// the length; s.
    pub(super) fn times(&self, shortest: f64, longest: f64) -> Option<(f64, f64)> {
        let low = shortest * self.step()?;
        let high = longest * (self.t.last()? - self.t[0]);
        (high > low).then_some((low, high))
    }
}

/// Estimate the process of some rows.
pub(super) fn estimate(rows: &AxisRows) -> Option<Ar1Process> {
    let (turn, z) = rows.in_basis()?;
    let sums = Sums::of(rows, &z);
    let white = sums.likelihood(0.0)?;
    let process = |tau: f64, found: &Likelihood| Ar1Process {
        tau,
        share: 1.0,
        variance: found.variance,
        gain: 2.0 * (found.value - white.value),
        freedom: (sums.rows + 1 - z.ncols()) as f64,
        params: &turn * &found.params,
    };
    let Some((low, high)) = rows.times(SHORTEST, LONGEST) else {
        return Some(process(0.0, &white));
    };
    let at = |part: f64| low * (high / low).powf(part);
    let of = |part: f64| {
        let likelihood = sums.likelihood(at(part));
        likelihood.map_or(f64::NEG_INFINITY, |l| l.value)
    };
    let grid = (0..=TRIED).map(|k| k as f64 / TRIED as f64);
    let grid = grid.map(|part| (of(part), part));
    let mut best = grid.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut step = 0.5 / TRIED as f64;
    for _ in 0..REFINED {
        for part in [best.1 - step, best.1 + step] {
            let part = part.clamp(0.0, 1.0);
            let tried = of(part);
            if tried > best.0 {
                best = (tried, part);
            }
        }
        step *= 0.6;
    }
    let tau = at(best.1);
    let found = sums.likelihood(tau)?;
    Some(if found.value > white.value {
        process(tau, &found)
    } else {
        process(0.0, &white)
    })
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

/// Correlation of noise that lasts for `tau` with itself `step` later, s.
pub(super) fn lasting(step: f64, tau: f64) -> f64 {
    if tau > 0.0 { (-step / tau).exp() } else { 0.0 }
}

impl Sums {
    fn of(AxisRows { t, joined, .. }: &AxisRows, z: &DMatrix<f64>) -> Sums {
        let n = z.nrows();
        let mut classes: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        let mut first = Vec::new();
        for k in 0..n {
            if k > 0 && joined[k] {
                let step = (t[k] - t[k - 1]).ln() / ALIKE;
                classes.entry(step.round() as i64).or_default().push(k);
            } else {
                first.push(k);
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
            let rho = lasting(lag.length / lag.count, tau);
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
    pub(super) fn of(products: &DMatrix<f64>, rows: usize, log_det: f64) -> Option<Likelihood> {
        let p = products.ncols() - 1;
        let of_x = products.view((0, 0), (p, p)).into_owned();
        let of_xy = products.column(p).rows(0, p).into_owned();
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
