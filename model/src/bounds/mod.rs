//! Rounding bounds, proven over the joint limits.
//!
//! Forward error analysis with intervals: node by node, an enclosure of the
//! exact value and a bound on |computed − exact|. Scalars alone would lose a
//! factor √2 with every rotation, so vectors that the graph knows to be sums of
//! orthogonal images are analysed as vectors:
//!
//! ```text
//! E(v) ≤ Σ_from E + ‖rounding made on the way‖₂
//! ```
//!
//! because an exact rotation neither stretches an error nor shrinks it. The
//! result grows linearly with the depth of the tree.
//!
//! Standard model of arithmetic: `fl(a ∘ b) = (a ∘ b)(1 + δ)`, |δ| ≤ u. Sines and
//! cosines are within `KERNEL_UNITS` units u, as the runtime documents. Constants
//! are correct to `CONSTANT_ULPS`; terms of order u² are covered by a margin.

mod analysis;
mod choose;
mod fixed;
mod operations;
mod range;

use crate::program::Program;
use analysis::ranges;
#[doc(hidden)]
pub use fixed::{Formats, Overflow, Quantity, Unfit};
#[doc(hidden)]
pub use fixed::{fitting, kernel_error as fixed_kernel_error};

/// Absolute error of sines and cosines in units of u: below 1 by runtime::trig (an ulp of
/// a value below one is at most u), below 1.7 by the tables of runtime::simd.
const KERNEL_UNITS: f64 = 1.75;
/// Absolute error of a generated constant, in units of f64's u: an entry of a
/// product of rotations, or an angle, that may be what cancellation left.
const CONSTANT_ULPS: f64 = 40.0;
/// Covers what is quadratic in u: products of errors, and matrices orthogonal up to u.
const MARGIN: f64 = 1.001;
/// Unit roundoff of f64, 2⁻⁵³.
const U64: f64 = 1.1102230246251565e-16;

/// Arithmetic of the generated code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// IEEE double precision.
    F64,
    /// IEEE single precision.
    F32,
}

impl Precision {
    /// Unit roundoff u.
    pub fn unit(self) -> f64 {
        match self {
            Precision::F64 => U64,
            Precision::F32 => 5.960464477539063e-8,
        }
    }

    /// Largest angle that the sine and cosine kernels answer, rad (runtime::trig).
    pub fn largest_angle(self) -> f64 {
        match self {
            Precision::F64 => 1_048_576.0,
            Precision::F32 => 1024.0,
        }
    }
}

/// What one element of an input array may be.
#[doc(hidden)]
#[derive(Debug, Clone, Copy)]
pub struct Input {
    /// Least value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Error of its f64 value, in units of u times this.
    pub ulps_of: f64,
    /// Error that it comes with, in any precision.
    pub absolute: f64,
    /// Whether it is rounded to the working precision on the way in.
    pub rounded: bool,
}

impl Input {
    /// An input that is what it is: a joint position.
    pub fn exact(lower: f64, upper: f64) -> Input {
        Input {
            lower,
            upper,
            ulps_of: 0.0,
            absolute: 0.0,
            rounded: false,
        }
    }

    /// One that is rounded to the working precision.
    pub fn rounded(lower: f64, upper: f64) -> Input {
        let rounded = true;
        let exact = Input::exact(lower, upper);
        Input { rounded, ..exact }
    }

    /// Its largest magnitude.
    fn size(&self) -> f64 {
        libm::fabs(self.lower).max(libm::fabs(self.upper))
    }
}

/// The result of the analysis.
#[derive(Debug, Clone)]
pub struct Bound {
    /// Bound on |computed − exact| of each output.
    pub outputs: Vec<f64>,
    /// Largest of them.
    pub worst: f64,
}

/// Arithmetic in which a program runs, as the analysis sees it.
#[derive(Debug, Clone, Copy)]
enum Arithmetic<'f> {
    Float {
        precision: Precision,
        /// Sines of larger angles have no bound.
        largest_angle: f64,
    },
    Fixed(&'f Formats),
}

/// Bound the rounding error of `program` for inputs in the given ranges.
#[doc(hidden)]
pub fn prove(program: &Program, inputs: &[Vec<Input>], precision: Precision) -> Bound {
    let arithmetic = Arithmetic::Float {
        precision,
        largest_angle: precision.largest_angle(),
    };
    bound(program, inputs, arithmetic)
}

/// Bound the rounding error of `program` in 32-bit fixed point with these formats.
#[doc(hidden)]
pub fn prove_fixed(program: &Program, inputs: &[Vec<Input>], formats: &Formats) -> Bound {
    let mut bound = bound(program, inputs, Arithmetic::Fixed(formats));
    for (error, id) in bound.outputs.iter_mut().zip(&program.outputs) {
        *error += formats.rounding_of_output(program, *id);
        bound.worst = bound.worst.max(*error);
    }
    bound
}

fn bound(program: &Program, inputs: &[Vec<Input>], arithmetic: Arithmetic) -> Bound {
    let ranges = ranges(program, inputs, arithmetic);
    let error = |id: &crate::expr::Id| match ranges[id.index()].error * MARGIN {
        // A maximum would pass over a NaN.
        error if error.is_nan() => f64::INFINITY,
        error => error,
    };
    let outputs: Vec<f64> = program.outputs.iter().map(error).collect();
    Bound {
        worst: outputs.iter().copied().fold(0.0, f64::max),
        outputs,
    }
}
