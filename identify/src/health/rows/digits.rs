//! Digits of a log: what tells rows apart, and steps that a channel moves in.

use sesc_model::hash::{START, fnv1a};

/// What tells a row: its joints and what was read, to the last bit.
pub(super) fn key(q: &[f64], reading: &[f64]) -> u64 {
    let values = q.iter().chain(reading);
    values.fold(START, |hash, value| {
        fnv1a(hash, &value.to_bits().to_le_bytes())
    })
}

/// What was read: the forces where there are cells, else the CoP.
pub(super) fn reading_of(cop: [f64; 2], force: &[f64]) -> Vec<f64> {
    match force {
        [] => cop.to_vec(),
        force => force.to_vec(),
    }
}

/// The step that all values are multiples of, if there is one.
pub(super) fn step(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let gaps: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).collect();
    let least = gaps
        .iter()
        .copied()
        .filter(|g| *g > 1e-9)
        .fold(f64::INFINITY, f64::min);
    let whole = |gap: &f64| {
        let times = gap / least;
        (times - times.round()).abs() < 0.01 * times.clamp(1.0, 10.0)
    };
    let regular = least.is_finite() && gaps.len() >= 2 && gaps.iter().all(whole);
    // Few values far apart have a step only if some of them share it.
    let shared = gaps.iter().filter(|g| **g < 1.5 * least).count();
    (regular && 4 * shared >= gaps.len() && shared >= 2).then_some(least)
}
