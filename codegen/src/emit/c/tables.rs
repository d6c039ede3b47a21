//! Constant arrays.

use super::functions::Routine;
use super::{Array, Scalar, number};
use sesc_model::Model;
use sesc_model::expr::Argument;

/// Fraction bits of the parameters.
pub(super) fn parameter_bits(routines: &[Routine]) -> i32 {
    let find = |routine: &Routine| {
        let k = routine
            .program
            .inputs
            .iter()
            .position(|array| array.argument == Argument::Parameters)?;
        Some(routine.formats.as_ref()?.arrays[k])
    };
    routines.iter().find_map(find).unwrap_or(30)
}

/// Arrays of parameters.
pub(super) fn arrays(
    model: &Model,
    scalar: Scalar,
    routines: &[Routine],
    name: &str,
) -> Vec<Array> {
    let bits = parameter_bits(routines);
    let mut arrays = Vec::new();
    let mut push = |array: &str, values: &[f64]| {
        arrays.push(Array {
            declaration: format!("const {name}_real {name}_{array}[{name}_BASE_PARAMS]"),
            values: values.iter().map(|x| number(*x, scalar, bits)).collect(),
        });
    };
    push("cad_params", &model.cad_params());
    push("param_limits", &model.param_limits);
    if let Some(file) = &model.file {
        push("model_params", &file.values());
    }
    arrays
}

/// Entries of the quarter-wave table in a line of source.
const A_LINE: usize = 8;

/// `sin(k π / 2048)`, k = 0 … 1024, some to a line.
pub(super) fn quarter(scalar: Scalar) -> Vec<String> {
    let values: Vec<String> = (0..=1024)
        .map(|k| {
            let sine = match k {
                // sin 30° and sin 90°: exact.
                1024 => 1.0,
                _ => libm::sin(f64::from(k) * std::f64::consts::PI / 2048.0),
            };
            number(sine, scalar, 30)
        })
        .collect();
    values.chunks(A_LINE).map(|line| line.join(", ")).collect()
}
