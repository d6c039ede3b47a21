//! Rows of postures to registers, and back: four rows at a time, in squares of four columns.
//!
//! Rows are walked in the order of memory, so that the processor foresees the lines of its cache
//! that they are written to.

use std::array::from_fn;

use super::SHORT;
use crate::wide::tiles::{Factors, Lines, LinesMut, SIDE, Tiles};

/// The value of a node for every posture of a block, of N = [`BLOCK`](super::BLOCK) or [`SHORT`]:
/// no load of eight numbers straddles two lines of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Register<const N: usize>(pub [f64; N]);

/// Rows of n postures to a register for each column.
pub(super) struct Load<'a, const N: usize> {
    pub values: &'a [f64],
    pub n: usize,
    pub registers: &'a mut [Register<N>],
}

impl<const N: usize> Tiles for Load<'_, N> {
    #[inline(always)]
    fn run(self, tile: impl Fn(Lines, Factors, LinesMut)) {
        let width = self.registers.len();
        let rows = self.values.chunks_exact(width.max(1)).take(self.n);
        let mut rows = rows.enumerate();
        let mut half = 0;
        while width >= SIDE && rows.len() >= SIDE {
            let four: [&[f64]; SIDE] = from_fn(|_| rows.next().expect("four rows are left").1);
            let place = half % (N / SIDE);
            half += 1;
            let columns = self.registers.as_chunks_mut::<SIDE>().0;
            let from = four.map(|row| &row.as_chunks::<SIDE>().0[..columns.len()]);
            for (k, columns) in columns.iter_mut().enumerate() {
                let to = columns.each_mut();
                let to = to.map(|column| &mut column.0.as_chunks_mut().0[place]);
                tile(from.map(|row| &row[k]), &[1.0; SIDE], to);
            }
            let left = width % SIDE;
            for (lane, row) in four.iter().enumerate() {
                let columns = self.registers[width - left..].iter_mut();
                for (register, value) in columns.zip(&row[width - left..]) {
                    register.0[(place * SIDE + lane) % N] = *value;
                }
            }
        }
        for (lane, row) in rows {
            for (register, value) in self.registers.iter_mut().zip(row) {
                register.0[lane % N] = *value;
            }
        }
    }
}

/// Registers of outputs to some columns of the rows of n postures.
pub(super) struct Write<'a, const N: usize> {
    /// A register for each column, and what it is multiplied by.
    pub places: &'a [usize],
    pub signs: &'a [f64],
    pub registers: &'a [Register<N>],
    pub n: usize,
    /// From the first of the columns on.
    pub out: &'a mut [f64],
    /// Numbers in a row.
    pub width: usize,
}

impl<'a, const N: usize> Tiles for Write<'a, N> {
    #[inline(always)]
    fn run(self, tile: impl Fn(Lines, Factors, LinesMut)) {
        let (out, width) = (self.out, self.width);
        let mut done = 0;
        if let (Ok(places), Ok(signs)) = (
            <&[usize; SHORT]>::try_from(self.places),
            <&[f64; SHORT]>::try_from(self.signs),
        ) && width >= SHORT
        {
            let columns = places.map(|place| self.registers[place].0.as_chunks::<SHORT>().0);
            let signs = signs.as_chunks::<SIDE>().0;
            let halves = self.n / SHORT * (SHORT / SIDE);
            let mut rest = &mut *out;
            for half in 0..halves {
                let mut rows: [&mut [f64; SHORT]; SIDE] = from_fn(|_| next(&mut rest, width));
                let of = |column: &'a [[f64; SHORT]]| {
                    &column[half / 2 % (N / SHORT)].as_chunks::<SIDE>().0[half % 2]
                };
                let columns = columns.map(of);
                for (side, signs) in signs.iter().enumerate() {
                    let from = from_fn(|k| columns[side * SIDE + k]);
                    let to = rows.each_mut().map(|row| &mut row.as_chunks_mut().0[side]);
                    tile(from, signs, to);
                }
            }
            done = halves * SIDE;
        }
        let rows = out.chunks_mut(width.max(1)).enumerate();
        for (lane, row) in rows.take(self.n).skip(done) {
            let columns = self.places.iter().zip(self.signs);
            for (to, (place, sign)) in row.iter_mut().zip(columns) {
                *to = self.registers[*place].0[lane % N] * sign;
            }
        }
    }
}

/// The first numbers of the next row.
#[inline(always)]
fn next<'a>(rest: &mut &'a mut [f64], width: usize) -> &'a mut [f64; SHORT] {
    let own = std::mem::take(rest);
    let (row, others) = own.split_at_mut(width.min(own.len()));
    *rest = others;
    row.first_chunk_mut().expect("room for every output")
}
