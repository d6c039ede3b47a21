//! How many independent samples a log in time is worth.
//!
//! ```text
//! y = X b + e        e an AR(1) process: corr(e_j, e_k) = exp(−|t_j − t_k|/τ)
//! n_eff = n / (1 + 2 Σ_k ρ_k) = n (1 − a)/(1 + a),   a = exp(−Δt/τ)
//! ```
//!
//! τ by restricted maximum likelihood (Patterson and Thompson, Biometrika 58, 1971): the
//! residuals of a fit have lost their slow part to the fit's own columns X, and their plain
//! autocorrelation would count two to three times too many samples. Stamps may be uneven.

use nalgebra::{DMatrix, DVector};

/// Twice the log likelihood that correlation must gain over none.
const SIGNIFICANT: f64 = 10.0;
/// Correlation times that are tried, as parts of the step and of the log's length.
const SHORTEST: f64 = 0.2;
const LONGEST: f64 = 0.5;
const TRIED: usize = 48;
/// Singular values of the scaled columns of X below this part of the largest are rounding.
const DEPENDENT: f64 = 1e-6;
/// Rows that correlation can be seen in, at least, beyond the columns of X.
const ENOUGH: usize = 20;

/// What a log's residuals say of its noise, on one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correlation {
    /// Integrated correlation time, s; zero where samples are independent.
    pub time_s: f64,
    /// Samples per independent one, n/n_eff, 1 and more.
    pub rows_per_sample: f64,
}

impl Correlation {
    /// Of samples that are independent.
    pub const NONE: Correlation = Correlation {
        time_s: 0.0,
        rows_per_sample: 1.0,
    };

    /// Estimate it from what a fit leaves of `y` (whitened), whose columns are `x`, at
    /// times `t` (s, rising).
    pub fn of(t: &[f64], y: &DVector<f64>, x: &DMatrix<f64>) -> Correlation {
        let n = t.len();
        let rising = t.windows(2).all(|pair| pair[1] > pair[0]);
        if !rising || n < x.ncols() + ENOUGH {
            return Correlation::NONE;
        }
        let x = &basis(x);
        let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let step = sorted[sorted.len() / 2];
        let (low, high) = (SHORTEST * step, LONGEST * (t[n - 1] - t[0]));
        let white = likelihood(&steps, 0.0, y, x);
        let ratio = (high / low).ln();
        let tried = (0..TRIED).map(|k| low * (ratio * k as f64 / (TRIED - 1) as f64).exp());
        let best = tried
            .map(|tau| (likelihood(&steps, tau, y, x), tau))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((found, tau)) if 2.0 * (found - white) > SIGNIFICANT => {
                let a = (-step / tau).exp();
                let rows_per_sample = (1.0 + a) / (1.0 - a);
                Correlation {
                    time_s: 0.5 * step * rows_per_sample,
                    rows_per_sample: rows_per_sample.min(n as f64),
                }
            }
            _ => Correlation::NONE,
        }
    }
}

/// An orthonormal basis of the columns of X that are not tiny or copies of others.
fn basis(x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = x.clone();
    for mut column in scaled.column_iter_mut() {
        let size = column.norm();
        if size > 0.0 {
            column /= size;
        }
    }
    let svd = scaled.svd(true, false);
    let u = svd.u.expect("asked for");
    let least = DEPENDENT * svd.singular_values.max();
    let kept: Vec<usize> = (0..u.ncols())
        .filter(|&k| svd.singular_values[k] > least)
        .collect();
    u.select_columns(&kept)
}

/// Restricted log likelihood of an AR(1) process of correlation time `tau`, its size
/// profiled out, less a constant.
fn likelihood(steps: &[f64], tau: f64, y: &DVector<f64>, x: &DMatrix<f64>) -> f64 {
    let (n, p) = x.shape();
    let (mut wy, mut wx) = (y.clone(), x.clone());
    let mut log_det = 0.0;
    for k in (1..n).rev() {
        let rho = if tau > 0.0 {
            (-steps[k - 1] / tau).exp()
        } else {
            0.0
        };
        let left = (1.0 - rho * rho).max(1e-12);
        let scale = 1.0 / left.sqrt();
        log_det += left.ln();
        wy[k] = (wy[k] - rho * wy[k - 1]) * scale;
        for column in 0..p {
            wx[(k, column)] = (wx[(k, column)] - rho * wx[(k - 1, column)]) * scale;
        }
    }
    let Some(factor) = wx.tr_mul(&wx).cholesky() else {
        return f64::NEG_INFINITY;
    };
    let gradient = wx.tr_mul(&wy);
    let left = wy.dot(&wy) - gradient.dot(&factor.solve(&gradient));
    let log_det_x: f64 = factor.l().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
    let freedom = (n - p) as f64;
    -0.5 * (freedom * (left.max(f64::MIN_POSITIVE) / freedom).ln() + log_det + log_det_x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// Normal deviates by Box and Muller.
    fn gauss(rng: &mut ChaCha8Rng) -> f64 {
        let unit = |rng: &mut ChaCha8Rng| (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let (u, v) = (unit(rng).max(1e-300), unit(rng));
        (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }

    /// Slow sines that a fit takes away, and AR(1) noise.
    fn log(n: usize, step: f64, tau: f64, seed: u64) -> (Vec<f64>, DVector<f64>, DMatrix<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let t: Vec<f64> = (0..n)
            .map(|k| step * (k as f64 + 0.2 * gauss(&mut rng).tanh()))
            .collect();
        let mut y = DVector::zeros(n);
        let mut e = gauss(&mut rng);
        for k in 0..n {
            if k > 0 {
                let rho = if tau > 0.0 {
                    (-(t[k] - t[k - 1]) / tau).exp()
                } else {
                    0.0
                };
                e = rho * e + (1.0 - rho * rho).sqrt() * gauss(&mut rng);
            }
            y[k] = e;
        }
        let wave = |k: usize, c: usize| (0.1 * (c + 1) as f64 * t[k] + c as f64).sin();
        (t.clone(), y, DMatrix::from_fn(n, 20, wave))
    }

    #[test]
    fn independent_samples_are_counted_as_such() {
        for seed in 0..40 {
            let (t, y, x) = log(400, 0.1, 0.0, seed);
            assert_eq!(Correlation::of(&t, &y, &x), Correlation::NONE, "{seed}");
        }
    }

    /// The number of independent samples is that of the process, though a fit of 20
    /// columns has eaten the slow part of the noise.
    #[test]
    fn samples_are_counted_by_the_correlation_of_the_process() {
        for tau in [0.2, 0.5, 1.0] {
            let mut ratios: Vec<f64> = (0..15)
                .map(|seed| {
                    let (t, y, x) = log(600, 0.1, tau, 100 + seed);
                    let a = (-0.1_f64 / tau).exp();
                    Correlation::of(&t, &y, &x).rows_per_sample * (1.0 - a) / (1.0 + a)
                })
                .collect();
            ratios.sort_by(f64::total_cmp);
            assert!((0.8..1.25).contains(&ratios[7]), "{tau}: {ratios:?}");
            assert!(ratios[0] > 0.4 && ratios[14] < 2.5, "{tau}: {ratios:?}");
        }
    }

    #[test]
    fn times_that_run_backwards_say_nothing() {
        let (mut t, y, x) = log(200, 0.1, 0.5, 3);
        t.swap(10, 20);
        assert_eq!(Correlation::of(&t, &y, &x), Correlation::NONE);
    }
}
