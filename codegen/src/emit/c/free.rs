//! One program by itself: a header and a source that know no robot.

use minijinja::context;
use serde::Serialize;

use super::{Needs, Package, Scalar, float, helpers, is_prefix, render};
use super::{listed, suggest};
use crate::Error;
use crate::emit::header;
use sesc_model::bounds::{self, Input, Precision};
use sesc_model::program::Program;

/// An input array, as the templates read it.
#[derive(Serialize)]
struct Array {
    name: String,
    len: usize,
}

/// `void NAME_run(inputs…, out)` for `program` in floating point: its header
/// tells the rounding bound for inputs in the given ranges.
///
/// # Errors
/// When `name` is no prefix of C names.
pub fn function(
    program: &Program,
    name: &str,
    precision: Precision,
    inputs: &[Vec<Input>],
) -> Result<Package, Error> {
    if !is_prefix(name) {
        return Err(Error::BadPrefix {
            name: name.to_string(),
            suggestion: suggest(name),
        });
    }
    let scalar = match precision {
        Precision::F64 => Scalar::F64,
        Precision::F32 => Scalar::F32,
    };
    let body = float::body(program, scalar, name, "out");
    let needs = Needs::of_lines(body.iter(), scalar, name);
    let outputs = program.outputs.len();
    let inputs_of = |array: &sesc_model::program::Array| {
        format!("const {name}_real {}[]", super::argument(array.argument))
    };
    let mut declarations: Vec<String> = program.inputs.iter().map(inputs_of).collect();
    declarations.push(format!("{name}_real out[{outputs}]"));
    let counts = program.counts();
    let about = vec![
        header::GENERATOR.to_string(),
        String::new(),
        format!(
            "operations     {} mul, {} add, {} sin_cos{}",
            counts.mul,
            counts.add,
            counts.sin_cos,
            header::others(counts)
        ),
    ];
    let worst = bounds::prove(program, inputs, precision).worst;
    let texts = context! {
        name,
        guard => format!("{}_H", name.to_uppercase()),
        about,
        real => scalar.c_type(),
        promise => match worst.is_finite() {
            true => format!("Proven rounding error below {}.", header::at_most(worst)),
            false => "No rounding bound can be proven.".to_string(),
        },
        arrays => listed(program.inputs.iter().map(|array| Array {
            name: super::argument(array.argument).to_string(),
            len: array.len,
        }).collect()),
        outputs,
        signature => declarations.join(", "),
        body,
        ..helpers(&needs, scalar),
    };
    Ok(Package {
        header: render("free.h", &texts)?,
        source: render("free.c", &texts)?,
        notes: Vec::new(),
    })
}
