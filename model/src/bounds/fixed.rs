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

use super::analysis::Analysis;
use super::{Arithmetic, Input, Precision};
use crate::expr::{Argument, Expr, Id};
use crate::program::{Program, operands};

/// Most fraction bits: sines and cosines reach ±1, which 31 would not hold.
const MOST: i32 = 30;
/// Fewest for the angle of a sine: 1.5e-5 rad.
const FEWEST_OF_ANGLES: i32 = 16;

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
fn unit(bits: i32) -> f64 {
    libm::ldexp(1.0, -bits)
}

/// Fraction bits of every quantity of one program.
#[derive(Debug, Clone, PartialEq)]
pub struct Formats {
    nodes: Vec<i32>,
    sizes: Vec<f64>,
    /// Of each input array.
    pub arrays: Vec<i32>,
    /// Of the results.
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
    /// It divides, clamps or raises to powers.
    Operation,
}

impl From<Overflow> for Unfit {
    fn from(overflow: Overflow) -> Unfit {
        Unfit::Overflow(overflow)
    }
}

impl Formats {
    /// Choose binary points for `program` on inputs in the given ranges.
    ///
    /// # Errors
    /// When a quantity may be 2^31 or more, an angle 2^15 rad or more, or when
    /// the program divides, clamps or raises to powers.
    pub fn choose(program: &Program, inputs: &[Vec<Input>]) -> Result<Formats, Unfit> {
        let fits = |expr| !matches!(expr, Expr::Div(..) | Expr::Clamp(_) | Expr::Pow(..));
        if !program.nodes.iter().all(|node| fits(node.expr)) {
            return Err(Unfit::Operation);
        }
        // Sizes with errors like f32's first; then what fits is proven.
        let like_floats = Arithmetic::Float {
            precision: Precision::F32,
            largest_angle: f64::INFINITY,
        };
        let mut analysis = Analysis::new(program, inputs, like_floats);
        analysis.run();
        let largest = |array: &[Input]| {
            let size = |x: &Input| libm::fabs(x.lower).max(libm::fabs(x.upper));
            array.iter().map(size).fold(0.0, f64::max)
        };
        // A little room for the rounding of what is passed in.
        let array = |array: &Vec<Input>| fitting(largest(array) * (1.0 + unit(30)));
        let mut formats = Formats {
            nodes: Vec::with_capacity(program.nodes.len()),
            sizes: Vec::new(),
            arrays: inputs.iter().map(array).collect(),
            output: MOST,
        };
        formats.join_sines(program);
        for (array, inputs) in program.inputs.iter().zip(inputs) {
            let size = |x: &Input| libm::fabs(x.lower).max(libm::fabs(x.upper));
            if let Some(k) = inputs.iter().position(|x| fitting(size(x)) < 0) {
                let overflow = Overflow {
                    quantity: Quantity::Input {
                        argument: array.argument,
                        index: k,
                    },
                    size: size(&inputs[k]),
                    angle: false,
                };
                return Err(overflow.into());
            }
        }
        for (id, node) in program.iter() {
            let bits = match node.expr {
                Expr::Const(x) => fitting(libm::fabs(x)),
                Expr::Input { argument, .. } => formats.arrays[program.slot(argument)],
                Expr::Sin(_) | Expr::Cos(_) => MOST,
                Expr::Neg(a) => formats.of(a),
                // A product or sum may not have more bits than what it is made of.
                Expr::Mul(a, b) => {
                    fitting(analysis.range(id).size()).min(formats.of(a) + formats.of(b))
                }
                // Constants take the format of the sum, which must hold them too.
                Expr::Add(a, b) | Expr::Sub(a, b) => {
                    let least = formats.of(a).min(formats.of(b));
                    fitting(analysis.range(id).size()).min(least)
                }
                Expr::Div(..) | Expr::Clamp(_) | Expr::Pow(..) => {
                    unreachable!("programs with these were refused")
                }
            };
            if bits < 0 {
                return Err(overflow(program, id, analysis.range(id).size()).into());
            }
            formats.nodes.push(bits);
        }
        formats.check_angles(program, &analysis)?;
        // Ranges hold errors, and errors depend on the formats: prove that all fits.
        for _ in 0..=MOST {
            let mut analysis = Analysis::new(program, inputs, Arithmetic::Fixed(&formats));
            analysis.run();
            let ids = || program.iter().map(|(id, _)| id);
            let sizes: Vec<f64> = ids().map(|id| analysis.range(id).size()).collect();
            let size = |id: Id| sizes[id.index()];
            let tight = |id: &Id| size(*id) > capacity(formats.of(*id));
            let tight: Vec<Id> = ids().filter(tight).collect();
            if tight.is_empty() {
                formats.output = formats.coarsest_output(program);
                formats.sizes = sizes;
                return Ok(formats);
            }
            for id in tight {
                if formats.of(id) <= 0 || !size(id).is_finite() {
                    return Err(overflow(program, id, size(id)).into());
                }
                formats.nodes[id.index()] -= 1;
                if let Expr::Input { argument, .. } = program.expr(id) {
                    let bits = &mut formats.arrays[program.slot(argument)];
                    *bits = (*bits).min(formats.nodes[id.index()]);
                }
            }
            formats.settle(program);
        }
        let id = program.outputs.first().copied().unwrap_or(Id(0));
        Err(overflow(program, id, f64::INFINITY).into())
    }

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

    /// Sines and cosines are passed in one format, whatever slides put among the sines.
    fn join_sines(&mut self, program: &Program) {
        let of = |argument| {
            let mut inputs = program.inputs.iter();
            inputs.position(|array| array.argument == argument)
        };
        if let (Some(sin), Some(cos)) = (of(Argument::Sines), of(Argument::Cosines)) {
            let bits = self.arrays[sin].min(self.arrays[cos]);
            (self.arrays[sin], self.arrays[cos]) = (bits, bits);
        }
    }

    fn coarsest_output(&self, program: &Program) -> i32 {
        let bits = program.outputs.iter().map(|id| self.of(*id));
        bits.min().unwrap_or(MOST)
    }

    /// Lower what rests on a node that was lowered.
    fn settle(&mut self, program: &Program) {
        self.join_sines(program);
        for (id, node) in program.iter() {
            let most = match node.expr {
                Expr::Input { argument, .. } => self.arrays[program.slot(argument)],
                Expr::Neg(a) => self.of(a),
                Expr::Mul(a, b) => self.of(a) + self.of(b),
                Expr::Add(a, b) | Expr::Sub(a, b) => self.of(a).min(self.of(b)),
                _ => MOST,
            };
            let bits = &mut self.nodes[id.index()];
            *bits = (*bits).min(most);
        }
    }

    fn check_angles(&self, program: &Program, analysis: &Analysis) -> Result<(), Overflow> {
        for (_, node) in program.iter() {
            if let Expr::Sin(a) | Expr::Cos(a) = node.expr
                && self.of(a) < FEWEST_OF_ANGLES
            {
                return Err(Overflow {
                    angle: true,
                    ..overflow(program, a, analysis.range(a).size())
                });
            }
        }
        Ok(())
    }
}

/// Largest magnitude in a format.
fn capacity(bits: i32) -> f64 {
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

fn overflow(program: &Program, id: Id, size: f64) -> Overflow {
    let quantity = match (program.expr(id), &program.nodes[id.index()].name) {
        (Expr::Input { argument, index }, _) => Quantity::Input {
            argument,
            index: index as usize,
        },
        (_, Some(name)) => Quantity::Named(name.clone()),
        _ => {
            let before = |section: &&(usize, String)| section.0 <= id.index();
            match program.sections.iter().rev().find(before) {
                Some((_, title)) => Quantity::Step(title.clone()),
                None => Quantity::Intermediate,
            }
        }
    };
    Overflow {
        quantity,
        size,
        angle: false,
    }
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
