//! What tells rows apart.

/// What tells a row: its joints and what was read, to the last bit.
pub(super) fn key(q: &[f64], reading: &[f64]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for value in q.iter().chain(reading) {
        hash = (hash ^ value.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        hash ^= hash >> 32;
    }
    hash
}

/// What was read: the forces where there are cells, else the CoP.
pub(super) fn reading_of(cop: [f64; 2], force: &[f64]) -> Vec<f64> {
    match force {
        [] => cop.to_vec(),
        force => force.to_vec(),
    }
}
