//! Noise that lasts under white noise: a body that sways under the noise of a sensor.
//!
//! ```text
//! e_k = s_k + w_k      s_k = ρ_k s_{k−1} + N(0, a (1 − ρ_k²))      w_k ~ N(0, 1 − a)
//! P⁻ = ρ² P + a (1 − ρ²)      F = P⁻ + 1 − a      s⁺ = ρ s + P⁻/F (z − ρ s)      P = P⁻ (1 − a)/F
//! ```
//!
//! The Kalman filter (Kalman 1960) gives innovations (z − ρ s)/√F that are independent, of
//! readings and columns alike: with a = 1 those of an AR(1) process. Their restricted
//! likelihood finds τ and a.

use nalgebra::DMatrix;

use super::restricted::{Ar1Process, AxisRows, Likelihood, lasting};

/// Parts of the longest time and shares of lasting noise that are tried at first.
const TIMES: usize = 10;
const SHARES: [f64; 5] = [0.05, 0.15, 0.35, 0.6, 0.85];
/// How often the best is refined.
const REFINED: usize = 8;
/// Shares that are told from none and all.
const LEAST_SHARE: f64 = 0.01;
/// The shortest time that is tried, in steps; the longest, as a part of the length.
const SHORTEST: f64 = 0.5;
const LONGEST: f64 = 0.25;

/// What is known of the noise that lasts, from the rows so far.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filter {
    /// Estimate of the lasting part in each column.
    state: Vec<f64>,
    /// Its variance, in units of a row's.
    variance: f64,
}

impl Filter {
    /// Nothing is known of `columns` columns, whose part `share` lasts.
    pub(super) fn new(columns: usize, share: f64) -> Filter {
        Filter {
            state: vec![0.0; columns],
            variance: share,
        }
    }

    /// Turn a row into its innovation, where the part `share` of its variance has the
    /// correlation `rho` with that of the row before; gives the variance that it had.
    pub(super) fn whiten(&mut self, rho: f64, share: f64, row: &mut [f64]) -> f64 {
        let before = rho * rho * self.variance + share * (1.0 - rho * rho);
        let whole = (before + 1.0 - share).max(1e-12);
        let (gain, scale) = (before / whole, 1.0 / whole.sqrt());
        self.variance = before * (1.0 - share) / whole;
        for (state, x) in self.state.iter_mut().zip(row) {
            let told = rho * *state;
            let new = *x - told;
            *state = told + gain * new;
            *x = new * scale;
        }
        whole
    }
}

/// Innovations of rows, one a column of `z` with the reading last, and the sum of the logarithms of
/// their variances.
pub(super) fn whitened(
    rows: &AxisRows,
    mut z: DMatrix<f64>,
    tau: f64,
    share: f64,
) -> (DMatrix<f64>, f64) {
    let mut filter = Filter::new(z.nrows(), share);
    let mut log_det = 0.0;
    for (k, mut row) in z.column_iter_mut().enumerate() {
        // Correlation of the lasting parts of this row and the one before.
        let rho = match rows.joined[k] {
            true => lasting(rows.t[k] - rows.t[k - 1], tau),
            false => 0.0,
        };
        log_det += filter.whiten(rho, share, row.as_mut_slice()).ln();
    }
    (z, log_det)
}

/// Estimate noise that lasts under white noise from some rows.
pub(super) fn estimate(rows: &AxisRows) -> Option<Ar1Process> {
    let (turn, z) = rows.in_basis()?;
    let (n, z) = (z.nrows(), z.transpose());
    let (low, high) = rows.times(SHORTEST, LONGEST)?;
    let at = |tau: f64, share: f64| {
        let (z, log_det) = whitened(rows, z.clone(), tau, share);
        Likelihood::of(&(&z * z.transpose()), n, log_det)
    };
    let time = |part: f64| low * (high / low).powf(part.clamp(0.0, 1.0));
    let white = at(0.0, 1.0)?;
    let grid = (0..=TIMES).flat_map(|k| SHARES.map(|share| (k as f64 / TIMES as f64, share)));
    let mut best = ((0.0, 0.0), white.value);
    let mut steps = [0.5 / TIMES as f64, 0.1];
    for (part, share) in grid {
        if let Some(tried) = at(time(part), share).filter(|it| it.value > best.1) {
            best = ((part, share), tried.value);
        }
    }
    if best.0.1 == 0.0 {
        return None;
    }
    for _ in 0..REFINED {
        let (part, share) = best.0;
        for (part, share) in [
            (part - steps[0], share),
            (part + steps[0], share),
            (part, share - steps[1]),
            (part, share + steps[1]),
        ] {
            let share = share.clamp(LEAST_SHARE, 1.0);
            if let Some(tried) = at(time(part), share).filter(|it| it.value > best.1) {
                best = ((part, share), tried.value);
            }
        }
        steps = steps.map(|step| 0.6 * step);
    }
    let (part, share) = best.0;
    let tau = time(part);
    let best = at(tau, share)?;
    Some(Ar1Process {
        tau,
        share,
        variance: best.variance,
        gain: 2.0 * (best.value - white.value),
        freedom: (n + 1 - z.nrows()) as f64,
        params: turn * best.params,
    })
}
