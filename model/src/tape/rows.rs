//! Rows of postures to registers, and back.

use super::plan::Plan;
use crate::wide::tiles::{LINE, SIDE, to_columns, to_rows};

/// The value of a node for every posture of a block, of N = [`BLOCK`](super::BLOCK) or
/// [`SHORT`](super::SHORT): no load of eight numbers straddles two lines of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Register<const N: usize>(pub [f64; N]);

/// Rows of `n` postures to a register for each column that steps read.
pub(super) fn read<const N: usize>(
    values: &[f64],
    n: usize,
    is_read: &[bool],
    registers: &mut [Register<N>],
) {
    let width = registers.len();
    let (fours, rest) = registers.as_chunks_mut::<SIDE>();
    let used = is_read.as_chunks::<SIDE>().0;
    for (k, four) in fours.iter_mut().enumerate() {
        if used[k] == [false; SIDE] {
            continue;
        }
        let columns = four.each_mut().map(|register| &mut register.0);
        to_columns(&values[k * SIDE..], width, n, columns);
    }
    let left = rest.len();
    for (k, register) in rest.iter_mut().enumerate() {
        let column = values.iter().skip(width - left + k).step_by(width);
        for (to, value) in register.0.iter_mut().zip(column).take(n) {
            *to = *value;
        }
    }
}

/// Outputs from `start` on, as many as the plan writes together, to the rows of `n` postures.
///
/// By itself: its loops would take registers of the processor from those of the steps.
#[inline(never)]
pub(super) fn write<const N: usize>(
    plan: &Plan,
    start: usize,
    registers: &[Register<N>],
    n: usize,
    out: &mut [f64],
) {
    let width = plan.outputs.len();
    let places = &plan.outputs[start..][..plan.columns];
    let signs = &plan.signs[start..][..plan.columns];
    let out = &mut out[start..];
    if let (Some(places), Some(signs)) = (places.first_chunk::<LINE>(), signs.first_chunk()) {
        let mut columns = [&registers[0].0; LINE];
        for (column, place) in columns.iter_mut().zip(places) {
            *column = &registers[*place].0;
        }
        return to_rows(columns, signs, out, width, n);
    }
    for (lane, row) in out.chunks_mut(width.max(1)).enumerate().take(n) {
        for (to, (place, sign)) in row.iter_mut().zip(places.iter().zip(signs)) {
            *to = registers[*place].0[lane % N] * sign;
        }
    }
}
