//! How well two soles on one floor close.
//!
//! ```text
//! y_c = c + Σ_j slope_cj (δ_j + s_j q_j) + noise        c: height, roll, pitch
//! σ_c = max(what this leaves, floor), at most a limit
//! ```
//!
//! Offsets and scales of all joints take what any of them could; what they leave is noise:
//! ticks of encoders, soles that give way. Beside it soles and floor are not exactly flat,
//! the same in every posture: a tolerance common to all of them.

use nalgebra::{DMatrix, DVector};

use crate::observations::correlation::{Correlation, left};

/// Equations per posture: height (m), roll and pitch (rad) of the other sole.
pub const ROWS: usize = 3;
/// Noise of a posture is no smaller, m, rad, rad: ticks of encoders add up to about as much.
pub(super) const FLOOR: [f64; ROWS] = [3e-4, 1e-3, 1e-3];
/// … and no larger: soles that move more than this do not stand flat.
pub(super) const LIMIT: [f64; ROWS] = [5e-3, 0.02, 0.02];
/// Soles and floor are flat and parallel to this, m, rad, rad.
pub(super) const COMMON: [f64; ROWS] = [1e-3, 2.5e-3, 2.5e-3];
/// Postures per column of a fit, so that what it leaves is noise.
const PER_COLUMN: usize = 2;

/// Noise of one equation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Standard deviation of a posture.
    pub std: f64,
    /// Whether the log has it: else it is the floor, or the limit.
    pub from_log: bool,
    /// Postures per independent one.
    pub rows_per_sample: f64,
}

/// Noise of equation `row` from its values in every posture and its slopes by every joint
/// that moves the sole, at positions `q` of those joints.
pub(super) fn of(
    row: usize,
    values: &[f64],
    slopes: &DMatrix<f64>,
    q: &DMatrix<f64>,
    t: Option<&[f64]>,
) -> Noise {
    let n = values.len();
    let joints = slopes.ncols();
    let y = DVector::from_column_slice(values);
    let columns = |count: usize| {
        DMatrix::from_fn(n, count, |k, c| match c {
            0 => 1.0,
            c if c <= joints => slopes[(k, c - 1)],
            c => slopes[(k, c - 1 - joints)] * q[(k, c - 1 - joints)],
        })
    };
    let counts = [1 + 2 * joints, 1 + joints];
    let count = counts.into_iter().find(|count| n >= PER_COLUMN * count);
    let Some(x) = count.map(columns) else {
        return Noise {
            std: FLOOR[row],
            from_log: false,
            rows_per_sample: 1.0,
        };
    };
    let (square, _) = left(&x, &y);
    let std = square.sqrt();
    let known = if std.is_finite() { std } else { LIMIT[row] };
    let correlation = match t {
        Some(t) => Correlation::of(t, &y, &x),
        None => Correlation::NONE,
    };
    Noise {
        std: known.clamp(FLOOR[row], LIMIT[row]),
        from_log: (FLOOR[row]..=LIMIT[row]).contains(&known),
        rows_per_sample: correlation.rows_per_sample,
    }
}
