//! What tells rows apart.

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
