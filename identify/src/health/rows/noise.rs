//! Noise that is stated beside what CAD leaves of the rows, with nothing fitted.
//!
//! ```text
//! e = y − p_CAD(q)        χ² = mean of (e/σ)²        n: independent samples of e
//! ```
//!
//! What CAD leaves is the noise and whatever CAD does not know: an upper bound of the noise that no
//! fit has taken anything of. Noise that lasts for seconds leaves fewer independent samples than a
//! fit has unknowns; then only this bound tells. Readings of a robot that moves are compared with
//! the CoP and, where that leaves too much, with the ZMP.

use nalgebra::{DMatrix, DVector};
use sesc_model::Model;

use super::{LeftOut, LogRows, standing};
use crate::health::leftover::{is_no_chance, overstated};
use crate::health::{Finding, Picture};
use crate::observations::correlation::Correlation;

/// Rows that are looked at, at most.
const ROWS: usize = 10_000;

/// A finding where the noise is several times what CAD leaves of the rows that are kept.
pub(super) fn beside_cad(rows: &LogRows, model: &Model, left_out: &LeftOut) -> Option<Finding> {
    rows.noise?;
    let kept = rows.kept(left_out);
    let stride = kept.len().div_ceil(ROWS).max(1);
    let kept: Vec<usize> = kept.into_iter().step_by(stride).collect();
    let as_read = kept.iter().map(|&k| (k, rows.reading[k])).collect();
    tell(rows, as_read).or_else(|| tell(rows, standing::still(rows, &kept, model)?))
}

/// A finding by what CAD leaves of some rows with these readings, m.
fn tell(rows: &LogRows, mut all: Vec<(usize, [f64; 2])>) -> Option<Finding> {
    for (k, y) in &mut all {
        (0..2).for_each(|axis| y[axis] -= rows.cad[*k][axis]);
    }
    let count = all.len();
    let noise = rows.noise?;
    let axes = [0, 1].map(|axis| {
        let sigma = |k: usize| rows.std.get(k).map_or(noise, |std| std[axis]);
        let over = all.iter().map(|(k, gap)| gap[axis] / sigma(*k));
        DVector::from_iterator(count, over)
    });
    let square = axes.iter().map(|e| e.norm_squared()).sum::<f64>() / (2 * count) as f64;
    let finding = overstated(noise, rows.noise_source?, noise * square.sqrt())?;
    let samples: f64 = axes.iter().map(|e| samples(rows, &all, e)).sum();
    is_no_chance(square * samples, samples).then(|| {
        let title = "What CAD leaves of the CoP, mm";
        let row = |k: usize| rows.row(all[k].0);
        let left = |k: usize| all[k].1.map(|gap| (1e3 * gap, true));
        finding.showing(Picture::chosen(title, count, row, left))
    })
}

/// How many independent samples the gaps of one axis in some rows are worth by themselves.
fn samples(rows: &LogRows, all: &[(usize, [f64; 2])], gaps: &DVector<f64>) -> f64 {
    let n = gaps.len() as f64;
    // Without times of all rows nothing tells which follow each other.
    if rows.t.len() != rows.len() {
        return n / Correlation::NONE.rows_per_sample;
    }
    let t: Vec<f64> = all.iter().map(|(k, _)| rows.t[*k]).collect();
    let nothing_fitted = DMatrix::zeros(gaps.len(), 0);
    n / Correlation::of(&t, gaps, &nothing_fitted).rows_per_sample
}
