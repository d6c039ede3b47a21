//! Binary points for 32-bit fixed point, chosen from proven ranges.
//!
//! ```text
//! value = integer · 2^-F        |value| + error < 2^(31 - F)        F <= 30
//! ```
//!
//! Each node gets the largest F that its range allows, an input array and the
//! outputs one F each. A sum never has more fraction bits than its operands, so
//! operands are only ever rounded, never shifted up. Nothing can overflow
//! inside the ranges, so nothing saturates.

use crate::expr::{Argument, Expr, Id};
use crate::program::{Program, operands};

/// Most fraction bits: sines and cosines reach ±1, which 31 would not hold.
pub(super) const MOST: i32 = 30;
/// Fewest for the angle of a sine: 1.5e-5 rad.
pub(super) const FEWEST_OF_ANGLES: i32 = 16;

/// Error of the fixed-point sine and cosine of an angle up to `size`, rad.
///
/// The phase, 2^32 a turn, comes from a multiplication with a constant of 31
/// bits (relative error 2^-31) and is rounded (2π · 2^-33); the table entry and
/// the last sum are rounded to 2^-31, and the cube of the distance to the table's
/// angle that is left out is below 7.6e-11.
pub fn kernel_error(size: f64) -> f64 {
    1.85e-9 + size * unit(31)
}

/// 2^-bits.
pub(super) fn unit(bits: i32) -> f64 {
    libm::ldexp(1.0, -bits)
}

/// Fraction bits of every quantity of one program.
#[derive(Debug, Clone, PartialEq)]
pub struct Formats {
    pub(super) nodes: Vec<i32>,
    pub(super) sizes: Vec<f64>,
    /// Fraction bits of each input array.
    pub arrays: Vec<i32>,
    /// Fraction bits of the results.
    pub output: i32,
}

/// A quantity that 32 bits cannot hold with a use.
#[derive(Debug, Clone, PartialEq)]
pub struct Overflow {
    /// What it is.
    pub quantity: Quantity,
    /// How large it may be.
    pub size: f64,
    /// Whether an angle's sine is asked for: it needs bits below the point.
    pub angle: bool,
}

/// A number on its way through a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Quantity {
    /// An element of an input array.
    Input {
        /// The array.
        argument: Argument,
        /// Which of its elements.
        index: usize,
    },
    /// A node that has a name.
    Named(String),
    /// A node without one in the section of this title.
    Step(String),
    /// A node without name and section.
    Intermediate,
}

/// Why a program cannot be had in fixed point.
#[derive(Debug, Clone, PartialEq)]
pub enum Unfit {
    /// A quantity is too large.
    Overflow(Overflow),
    /// It divides or raises to powers.
    Operation,
}

impl Formats {
    /// Fraction bits of node `id`.
    pub fn of(&self, id: Id) -> i32 {
        self.nodes[id.index()]
    }

    /// Largest magnitude that node `id` may take, its error included.
    pub fn size(&self, id: Id) -> f64 {
        self.sizes[id.index()]
    }

    /// Half a unit in the last place of node `id`.
    pub(super) fn half_unit(&self, id: Id) -> f64 {
        unit(self.of(id) + 1)
    }

    /// Error of a constant in the format of its node; none where it is exact.
    pub(super) fn rounding_of_constant(&self, id: Id, x: f64) -> f64 {
        match is_whole(x, self.of(id)) {
            true => 0.0,
            false => self.half_unit(id),
        }
    }

    /// What rounding adds to a sum or a product.
    pub(super) fn rounding(&self, program: &Program, id: Id) -> f64 {
        let bits = self.of(id);
        let times = match program.expr(id) {
            Expr::Mul(a, b) => usize::from(self.of(a) + self.of(b) > bits),
            expr => operands(expr)
                .filter(|&x| match program.expr(x) {
                    Expr::Const(x) => !is_whole(x, bits),
                    _ => self.of(x) > bits,
                })
                .count(),
        };
        times as f64 * self.half_unit(id)
    }

    /// What rounding to the common format of the results adds.
    pub(super) fn rounding_of_output(&self, program: &Program, id: Id) -> f64 {
        let exact = match program.expr(id) {
            Expr::Const(x) => is_whole(x, self.output),
            _ => self.of(id) <= self.output,
        };
        if exact { 0.0 } else { unit(self.output + 1) }
    }

    /// Use one format for the results of several programs: the coarsest.
    pub fn share_output(&mut self, output: i32) {
        self.output = self.output.min(output);
    }

    /// Sines and cosines are passed in one format, whatever prismatic joints put among the sines.
    pub(super) fn join_sines(&mut self, program: &Program) {
        let of = |argument| {
            let mut inputs = program.inputs.iter();
            inputs.position(|array| array.argument == argument)
        };
        if let (Some(sin), Some(cos)) = (of(Argument::Sines), of(Argument::Cosines)) {
            let bits = self.arrays[sin].min(self.arrays[cos]);
            (self.arrays[sin], self.arrays[cos]) = (bits, bits);
        }
    }

    pub(super) fn coarsest_output(&self, program: &Program) -> i32 {
        let bits = program.outputs.iter().map(|id| self.of(*id));
        bits.min().unwrap_or(MOST)
    }

    /// Most fraction bits of a node: no more than what it is made of.
    pub(super) fn most(&self, program: &Program, expr: Expr) -> i32 {
        match expr {
            Expr::Input { argument, .. } => self.arrays[program.slot(argument)],
            Expr::Neg(a) => self.of(a),
            Expr::Mul(a, b) => self.of(a) + self.of(b),
            // Constants take the format of the sum, which must hold them too.
            Expr::Add(a, b) | Expr::Sub(a, b) | Expr::Max(a, b) => self.of(a).min(self.of(b)),
            _ => MOST,
        }
    }

    /// Lower what rests on a node that was lowered.
    pub(super) fn settle(&mut self, program: &Program) {
        self.join_sines(program);
        for (id, node) in program.iter() {
            let most = self.most(program, node.expr);
            let bits = &mut self.nodes[id.index()];
            *bits = (*bits).min(most);
        }
    }
}

/// Largest magnitude in a format.
pub(super) fn capacity(bits: i32) -> f64 {
    libm::ldexp(1.0 - unit(31), 31 - bits)
}

/// Most fraction bits with which `size` fits.
pub fn fitting(size: f64) -> i32 {
    let mut bits = MOST;
    while size > capacity(bits) && bits > -64 {
        bits -= 1;
    }
    bits
}

/// Whether `x` is a whole number of 2^-bits.
fn is_whole(x: f64, bits: i32) -> bool {
    let scaled = libm::ldexp(x, bits);
    scaled == libm::rint(scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_bits_that_fit() {
        assert_eq!(fitting(1.0), 30);
        assert_eq!(fitting(1.999), 30);
        assert_eq!(fitting(2.0), 29);
        assert_eq!(fitting(7.0), 28);
        assert_eq!(fitting(0.0), 30);
        assert_eq!(fitting(1e6), 11);
        assert!(fitting(1e10) < 0);
        assert!(is_whole(0.5, 1) && !is_whole(0.3, 30));
    }
}
