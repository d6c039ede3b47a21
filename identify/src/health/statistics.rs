//! Columns of numbers: their scatter, and what of one another explains.
//!
//! ```text
//! s(x) = √(Σ (x − x̄)² / n)        ρ(a, b)        R² = 1 − min_c ‖y − X c‖² / ‖y − ȳ‖²
//! ```

use crate::observations::postures::{Postures, rms};

/// Every second value.
pub(super) fn axis(values: &[f64], axis: usize) -> Vec<f64> {
    values.iter().skip(axis).step_by(2).copied().collect()
}

pub(super) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Deviation from the mean, RMS.
pub(super) fn scatter(x: &[f64]) -> f64 {
    let middle = mean(x);
    rms(x.iter().map(|x| x - middle))
}

/// Correlation of two columns; zero where one of them does not move.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let both: f64 = a.iter().zip(b).map(|(a, b)| (a - ma) * (b - mb)).sum();
    let size = scatter(a) * scatter(b) * a.len() as f64;
    if size > 0.0 { both / size } else { 0.0 }
}

/// RMS over one axis.
pub(super) fn rms_of(values: &[f64], k: usize) -> f64 {
    rms(axis(values, k).into_iter())
}

/// Gap of the readings to a CoP, m RMS.
pub(super) fn gap(data: &Postures, cop: impl Iterator<Item = f64>) -> f64 {
    rms(data.reading.iter().zip(cop).map(|(y, p)| y - p))
}

/// What the best `c + a·x₁ + b·x₂` leaves of `y`, RMS.
pub(super) fn left_by_plane(y: &[f64], x: [&[f64]; 2]) -> f64 {
    let centred = |v: &[f64]| -> Vec<f64> {
        let middle = mean(v);
        v.iter().map(|v| v - middle).collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut left = centred(y);
    let mut directions: Vec<Vec<f64>> = Vec::new();
    for column in x {
        let mut own = centred(column);
        let whole = dot(&own, &own);
        for other in &directions {
            let share = dot(&own, other) / dot(other, other);
            own.iter_mut().zip(other).for_each(|(a, b)| *a -= share * b);
        }
        // A column that the other one repeats has no direction of its own.
        if dot(&own, &own) <= 1e-20 * whole || whole == 0.0 {
            continue;
        }
        let share = dot(&left, &own) / dot(&own, &own);
        left.iter_mut().zip(&own).for_each(|(a, b)| *a -= share * b);
        directions.push(own);
    }
    rms(left.into_iter())
}

/// What the best `c + a·x` with `a ≥ 0` leaves of `y`, RMS.
pub(super) fn left_by_gain(y: &[f64], x: &[f64]) -> f64 {
    let along = correlation(y, x).max(0.0);
    scatter(y) * (1.0 - along * along).max(0.0).sqrt()
}

/// Size of gaps on two axes, RMS over both.
pub(super) fn rms_of_gaps(gaps: impl Iterator<Item = [f64; 2]>) -> f64 {
    rms(gaps.flatten())
}
