//! Functions of many postures, as many side by side as a register holds.
//!
//! ```text
//! (x ∘ y)[i] = x[i] ∘ y[i]        ∘ one of +, -, ·, /     i = 0 .. lanes
//! ```
//!
//! The statements are those of one posture, of another type: the vector types of gcc and
//! clang. Nothing passes between lanes, so lane i holds the bits that the function of one
//! posture gives for posture i.
//!
//! Arrays are structures of arrays: entry k of posture i stands at `k n + i`. The last block
//! ends with the last posture and may overlap the one before; where there are fewer postures
//! than lanes, the function of one posture is called.

use serde::Serialize;

use super::exported::{Exported, Input};
use super::helpers::{Calls, Helper};
use super::{Options, Scalar, float, spelled};
use crate::Error;
use crate::error::Problem;
use sesc_model::expr::Argument;

/// What may be asked for.
const COUNTS: [u32; 3] = [4, 8, 16];

/// Registers of targets in bytes, the longest first, and what tells that the target has them.
const REGISTERS: [(u32, &str); 3] = [
    (64, "defined(__AVX512F__)"),
    (32, "defined(__AVX2__)"),
    (16, ""),
];

/// How many lanes there are where a condition of the preprocessor holds.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Width {
    /// Empty where no other holds.
    #[serde(rename = "where")]
    condition: &'static str,
    lanes: u32,
}

/// The block of a function, and what the loop over blocks passes to it.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Block {
    parameters: String,
    /// The function of one posture.
    of_one: String,
    inputs: Vec<Array>,
    output: &'static str,
    outputs: usize,
    body: Vec<String>,
}

/// An array of numbers of each posture, or of one set for all.
#[derive(Debug, Clone, Serialize)]
struct Array {
    name: &'static str,
    len: usize,
    is_shared: bool,
}

/// Widths of blocks, by what the target has; none where no lanes are wanted.
///
/// # Errors
/// When the number of lanes is none of 4, 8 and 16, or the scalar is an integer.
pub(super) fn widths(options: &Options) -> Result<Vec<Width>, Error> {
    let Some(lanes) = options.lanes else {
        return Ok(Vec::new());
    };
    if !COUNTS.contains(&lanes) {
        return Err(Problem::Lanes { lanes }.into());
    }
    let size = match options.scalar {
        Scalar::F64 => 8,
        Scalar::F32 => 4,
        Scalar::Fixed32 => return Err(Problem::LanesInFixed.into()),
    };
    let mut widths: Vec<Width> = Vec::new();
    for (bytes, condition) in REGISTERS.into_iter().rev() {
        let held = (bytes / size).min(lanes);
        // A longer register that would be filled no further.
        if widths.iter().all(|width| width.lanes < held) {
            let lanes = held;
            widths.push(Width { condition, lanes });
        }
    }
    widths.reverse();
    Ok(widths)
}

/// The block of postures that `routine` is computed by.
pub(super) fn block(routine: &Exported, scalar: Scalar, name: &str, calls: &Calls) -> Block {
    let output = routine.output();
    let array = |argument: Argument, len: usize| {
        let is_shared = argument == Argument::Parameters;
        if len > 0 && !is_shared {
            calls.needs(Helper::Gather);
        }
        let name = spelled(argument);
        Array {
            name,
            len,
            is_shared,
        }
    };
    calls.needs(Helper::Scatter);
    let inputs = routine.program.inputs.iter();
    let inputs: Vec<Array> = inputs
        .map(|input| array(input.argument, input.len))
        .collect();
    let of_one = Exported {
        input: Input::Program,
        ..routine.clone()
    };
    let parameters = inputs.iter();
    let parameters = parameters.map(|array| format!(", const {name}_real {}[]", array.name));
    let parameters: String = parameters.collect();
    Block {
        parameters: format!("size_t n{parameters}, {name}_real {output}[restrict]"),
        of_one: of_one.name(),
        inputs,
        output,
        outputs: routine.program.outputs.len(),
        body: float::lanes(&routine.program, scalar, calls, output),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(scalar: Scalar, lanes: u32) -> Vec<u32> {
        let mut options = Options::of(scalar);
        options.lanes = Some(lanes);
        let widths = widths(&options).unwrap();
        assert_eq!(widths.last().unwrap().condition, "");
        widths.iter().map(|width| width.lanes).collect()
    }

    #[test]
    fn a_block_is_a_register_of_the_target_and_no_longer_than_asked() {
        assert_eq!(held(Scalar::F64, 4), [4, 2]);
        assert_eq!(held(Scalar::F64, 8), [8, 4, 2]);
        assert_eq!(held(Scalar::F64, 16), [8, 4, 2]);
        assert_eq!(held(Scalar::F32, 4), [4]);
        assert_eq!(held(Scalar::F32, 8), [8, 4]);
        assert_eq!(held(Scalar::F32, 16), [16, 8, 4]);
    }

    #[test]
    fn other_lanes_are_refused() {
        let refused = |scalar, lanes| {
            let mut options = Options::of(scalar);
            options.lanes = Some(lanes);
            widths(&options).unwrap_err().to_string()
        };
        assert!(refused(Scalar::F64, 5).contains("4, 8 or 16 lanes at most, not 5"));
        assert!(refused(Scalar::F64, 0).contains("not 0"));
        assert!(refused(Scalar::Fixed32, 8).starts_with("fixed32: "));
    }
}
