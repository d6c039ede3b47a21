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

/// Block and loop of a function.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Block {
    signature: String,
    body: Vec<String>,
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
    let inputs = routine.program.inputs.iter();
    let mut parameters = vec!["size_t n".to_string()];
    parameters
        .extend(inputs.map(|array| format!("const {name}_real {}[]", spelled(array.argument))));
    parameters.push(format!("{name}_real {output}[restrict]"));
    Block {
        signature: format!("{name}_{}({})", block_name(routine), parameters.join(", ")),
        body: float::lanes(&routine.program, scalar, calls, output),
    }
}

fn block_name(routine: &Exported) -> String {
    format!("{}_block", of_one(routine).name())
}

/// The function of one posture.
fn of_one<'f>(routine: &Exported<'f>) -> Exported<'f> {
    Exported {
        input: Input::Program,
        ..routine.clone()
    }
}

/// Block after block; posture after posture where there are fewer than lanes.
pub(super) fn body(routine: &Exported, name: &str, calls: &Calls) -> Vec<String> {
    let output = routine.output();
    let outputs = routine.program.outputs.len();
    let mut lines = vec![format!("if (n < {name}_LANES) {{")];
    let mut gathers = Vec::new();
    let (mut one, mut block) = (Vec::new(), vec!["n".to_string()]);
    for array in &routine.program.inputs {
        let from = spelled(array.argument);
        if array.argument == Argument::Parameters {
            one.push(from.to_string());
            block.push(from.to_string());
            continue;
        }
        // An array may not be empty.
        lines.push(format!(
            "    {name}_real {from}_of_one[{}];",
            array.len.max(1)
        ));
        if array.len > 0 {
            let arguments = format!("{from}, {}u, n, i, {from}_of_one", array.len);
            gathers.push(calls.call(Helper::Gather, &arguments) + ";");
        }
        one.push(format!("{from}_of_one"));
        block.push(format!("&{from}[at]"));
    }
    one.push(format!("{output}_of_one"));
    block.push(format!("&{output}[at]"));
    lines.push(format!("    {name}_real {output}_of_one[{outputs}];"));
    lines.push("    for (size_t i = 0u; i < n; i += 1u) {".into());
    lines.extend(gathers.iter().map(|line| format!("        {line}")));
    lines.push(format!(
        "        {name}_{}({});",
        of_one(routine).name(),
        one.join(", ")
    ));
    let arguments = format!("{output}_of_one, {outputs}u, n, i, {output}");
    let scatter = calls.call(Helper::Scatter, &arguments);
    lines.push(format!("        {scatter};"));
    lines.extend(["    }".into(), "} else {".into()]);
    lines.push(format!(
        "    for (size_t i = 0u; i < n; i += {name}_LANES) {{"
    ));
    lines.push("        /* The last block ends with the last posture. */".into());
    lines.push(format!(
        "        const size_t at = ((n - i) < {name}_LANES) ? (n - {name}_LANES) : i;"
    ));
    lines.push(format!(
        "        {name}_{}({});",
        block_name(routine),
        block.join(", ")
    ));
    lines.extend(["    }".into(), "}".into()]);
    lines
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
