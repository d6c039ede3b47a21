//! Running a program without a compiler: a tape over blocks of postures.
//!
//! Each node works on [`BLOCK`] postures at once, so that the cost of looking
//! up what to do is shared and the loops vectorise: in the widest registers that the
//! processor has, with the same bits in all. Loads and stores bind, not arithmetic: sums take in
//! the products that they are made of, and rows are written as soon as a line of them is known,
//! while the first cache holds it. A few postures, and the last few of many, go in blocks of
//! [`SHORT`], which do not pay for 64; one posture goes number by number, products and sums as
//! one step. Registers of results are reused as soon as their value is dead; inputs keep theirs,
//! and what all postures share is loaded once.

mod alone;
mod blocks;
mod lowering;
mod plan;
mod products;
mod rows;
mod sources;
mod step;
mod sums;

use std::ops::Range;

use crate::program::Program;

use alone::Alone;
use blocks::Blocks;
use plan::Plan;
use sources::sources;

/// Postures evaluated together.
pub const BLOCK: usize = 64;

/// Postures evaluated together where there are only a few: numbers in a line of the cache.
pub const SHORT: usize = 8;

/// Up to so many postures, of all or beyond whole blocks, are a few.
const FEW: usize = 3 * SHORT;

/// Sines and cosines of a block of angles: [`BLOCK`] or [`SHORT`] of each.
pub type SinCos = fn(&[f64], &mut [f64], &mut [f64]);

/// A block of bases to the power of a block of exponents: [`BLOCK`] or [`SHORT`] of each.
pub type Power = fn(&[f64], &[f64], &mut [f64]);

/// Functions that arithmetic does not bring along. With those of the runtime the
/// tape gives the bits of generated code.
#[derive(Debug, Clone, Copy)]
pub struct Kernels {
    /// Sine and cosine.
    pub sin_cos: SinCos,
    /// The power of a number that is not negative.
    pub power: Power,
}

impl Kernels {
    /// Those that constants are folded with: right to an ulp, not to the bit.
    pub const LIBM: Kernels = Kernels {
        sin_cos: |angles, sines, cosines| {
            for ((angle, sine), cosine) in angles.iter().zip(sines).zip(cosines) {
                (*sine, *cosine) = libm::sincos(*angle);
            }
        },
        power: |bases, exponents, powers| {
            for ((base, exponent), power) in bases.iter().zip(exponents).zip(powers) {
                *power = libm::pow(*base, *exponent);
            }
        },
    };
}

/// One element of an input array, over a batch of postures.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Values<'a> {
    /// `values[posture * len + index]`.
    PerPosture(&'a [f64]),
    /// `values[index]`, the same for every posture.
    Shared(&'a [f64]),
}

/// A program made ready to run.
#[derive(Debug, Clone)]
pub struct Tape {
    blocks: Plan,
    /// None of a program that is run on many postures.
    alone: Option<Alone>,
    lens: Vec<usize>,
}

impl Tape {
    /// Make `program` ready: for blocks in its own order, for one posture with angles first.
    pub fn new(program: &Program) -> Tape {
        Tape {
            alone: Some(Alone::new(program, &sources(program))),
            ..Tape::of_many(program)
        }
    }

    /// Make `program` ready for many postures at once, without the steps for one alone: that is a
    /// block that is not full, with the same bits.
    pub fn of_many(program: &Program) -> Tape {
        Tape {
            blocks: Plan::new(program),
            alone: None,
            lens: program.inputs.iter().map(|array| array.len).collect(),
        }
    }

    /// Values per posture.
    pub fn outputs(&self) -> usize {
        self.blocks.outputs.len()
    }

    /// Evaluate `postures` postures: `out[posture * outputs() + k]`.
    ///
    /// # Panics
    /// When an argument or `out` is shorter than the postures need: a mistake
    /// of the calling code, not of its input.
    pub fn run(&self, arguments: &[Values], postures: usize, out: &mut [f64], kernels: Kernels) {
        assert_eq!(
            arguments.len(),
            self.lens.len(),
            "one argument per input array"
        );
        for (argument, &len) in arguments.iter().zip(&self.lens) {
            let (have, need) = match argument {
                Values::PerPosture(values) => (values.len(), len * postures),
                Values::Shared(values) => (values.len(), len),
            };
            assert!(have >= need, "an input array holds {have} of {need} values");
        }
        assert!(
            out.len() >= postures * self.outputs(),
            "room for every output"
        );
        if let (1, Some(alone)) = (postures, &self.alone) {
            return alone.run(arguments, out, kernels);
        }
        let rest = postures % BLOCK;
        let few = if rest <= FEW { rest } else { 0 };
        self.in_blocks::<BLOCK>(arguments, 0..postures - few, out, kernels);
        self.in_blocks::<SHORT>(arguments, postures - few..postures, out, kernels);
    }

    /// Evaluate N postures at a time.
    fn in_blocks<const N: usize>(
        &self,
        arguments: &[Values],
        postures: Range<usize>,
        out: &mut [f64],
        kernels: Kernels,
    ) {
        if postures.is_empty() {
            return;
        }
        let blocks = Blocks::<N> {
            plan: &self.blocks,
            arguments,
            postures,
            out,
            kernels,
        };
        blocks.run();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Argument, Graph, Id};
    use crate::program::{Array, Shape};

    /// Numbers of a fixed sequence.
    struct Sequence(u64);

    impl Sequence {
        fn below(&mut self, n: usize) -> usize {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (self.0 >> 33) as usize % n
        }
    }

    /// A program of all operations in no order of any robot's, which its outputs use twice and
    /// never.
    fn program(seed: u64, joints: usize) -> Program {
        let mut any = Sequence(seed);
        let graph = Graph::default();
        let mut known: Vec<Id> = (0..joints)
            .map(|k| graph.input(Argument::Positions, k))
            .collect();
        known.extend([0.0, 1.0, -1.0, 0.3, 2.5].map(|x| graph.constant(x)));
        for _ in 0..20 + any.below(120) {
            let [a, b] = [any.below(known.len()), any.below(known.len())].map(|k| known[k]);
            let made = match any.below(14) {
                0..=3 => graph.mul(a, b),
                4..=6 => graph.add(a, b),
                7..=9 => graph.sub(a, b),
                10 => graph.neg(a),
                11 => graph.sin(a),
                12 => graph.cos(a),
                _ => match any.below(4) {
                    0 => graph.div(a, b),
                    1 => graph.clamp(a),
                    2 => graph.max(a, b),
                    _ => {
                        let base = graph.mul(a, a);
                        graph.pow(base, b)
                    }
                },
            };
            known.push(made);
        }
        let outputs: Vec<Id> = (0..12).map(|_| known[any.below(known.len())]).collect();
        let inputs = vec![Array {
            argument: Argument::Positions,
            len: joints,
        }];
        Program::new(graph, inputs, Shape::Vector(outputs.len()), &outputs)
    }

    #[test]
    fn a_posture_alone_has_the_bits_of_a_block_in_any_program() {
        let joints = 5;
        let values = [0.0, -0.0, 1.0, -0.7, 0.1, 3.0, -2.0, 1e-300, 1e18, f64::NAN];
        // A few; a block that is not full; whole blocks and the last few; and one not full.
        let counts = [7, FEW + 1, 2 * BLOCK + FEW, BLOCK + FEW + 1];
        for (seed, postures) in (0..500).zip(counts.into_iter().cycle()) {
            let program = program(seed, joints);
            let tape = Tape::new(&program);
            let mut any = Sequence(seed + 1);
            let q: Vec<f64> = (0..joints * postures)
                .map(|_| values[any.below(values.len())])
                .collect();
            let width = tape.outputs();
            let mut all = vec![0.0; width * postures];
            let kernels = Kernels::LIBM;
            tape.run(&[Values::PerPosture(&q)], postures, &mut all, kernels);
            let of_many = Tape::of_many(&program);
            let mut alone = vec![0.0; width];
            for (q, all) in q.chunks(joints).zip(all.chunks(width)) {
                for tape in [&tape, &of_many] {
                    tape.run(&[Values::PerPosture(q)], 1, &mut alone, kernels);
                    // Of no number the sign has no meaning.
                    let bits = |x: &f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
                    let [alone, all] =
                        [&alone[..], all].map(|x| x.iter().map(bits).collect::<Vec<_>>());
                    assert_eq!(alone, all, "program {seed} at {q:?}");
                }
            }
        }
    }

    #[test]
    fn threads_that_share_a_tape_do_not_share_values() {
        let (joints, calls) = (5, 2000);
        let program = program(7, joints);
        let tape = Tape::new(&program);
        let call = |tape: &Tape, k: u32| {
            let q: Vec<f64> = (0..5).map(|j| f64::from(k * 5 + j) * 1e-3).collect();
            let mut out = vec![0.0; tape.outputs()];
            tape.run(&[Values::PerPosture(&q)], 1, &mut out, Kernels::LIBM);
            out.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
        };
        let alone: Vec<_> = (0..calls).map(|k| call(&Tape::new(&program), k)).collect();
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    (0..calls).for_each(|k| assert_eq!(call(&tape, k), alone[k as usize]))
                });
            }
        });
    }
}
