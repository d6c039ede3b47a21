//! Clamp, power and maximum of the generated C, compiled and run on pairs of numbers.

use std::fs;
use std::process::Command;

use sesc_codegen::emit::c::{self, Scalar};
use sesc_model::bounds::Precision;
use sesc_model::effects::Site;
use sesc_test_support::command::fresh;

use crate::c99::case::Case;
use crate::c99::compiled::{SEPARATE, printed, tool};
use crate::effects::composed::record;

/// Reads pairs from a file; writes quotient, clamp, power and maximum of each.
const MAIN: &str = r#"#include "two_link.c"
#include <stdio.h>

int main(int count, char **arguments)
{
    two_link_real in[2], out[4];
    FILE *input = (count > 1) ? fopen(arguments[1], "rb") : NULL;
    if (input == NULL) {
        return 2;
    }
    while (fread(in, sizeof in, 1u, input) == 1u) {
        out[0] = in[0] / in[1];
        out[1] = two_link_clamp(in[0]);
        out[2] = two_link_power(in[0], in[1]);
        out[3] = two_link_larger(in[0], in[1]);
        if (fwrite(out, sizeof out, 1u, stdout) != 1u) {
            return 3;
        }
    }
    return fclose(input);
}
"#;

/// A package whose readings need all helpers: one cell saturates, one is not linear, a joint errs on
/// one side.
fn package(scalar: Scalar) -> c::Package {
    let mut case = Case::robot("two_link", "foot").and(
        "cells",
        &[
            ("cell_saturation", "fsr_1", &[("level_n", 15.0)]),
            ("cell_exponent", "fsr_2", &[("exponent", 1.1)]),
        ],
    );
    let mut file = case.model.file.clone().unwrap();
    let ramp = (Site::Joint, "max(q, 0)");
    file.effects.push(record("ramp", "knee", ramp, &[]));
    case.model = case.model.with_file(file).unwrap();
    case.name = "two_link".to_string();
    case.package(scalar)
}

/// Quotient, clamp, power and maximum of each pair, one after the other.
pub(super) fn run(
    precision: Precision,
    compiler: &str,
    flags: &[&str],
    pairs: &[[f64; 2]],
) -> Vec<f64> {
    let name = format!("{precision:?}_{compiler}{}", flags.concat());
    let folder = fresh(&format!("operations/{name}"));
    let (scalar, size) = match precision {
        Precision::F64 => (Scalar::F64, 8),
        Precision::F32 => (Scalar::F32, 4),
    };
    let package = package(scalar);
    fs::write(folder.join("two_link.h"), package.header).unwrap();
    fs::write(folder.join("two_link.c"), package.source).unwrap();
    fs::write(folder.join("main.c"), MAIN).unwrap();
    let bytes = |x: &f64| match precision {
        Precision::F64 => x.to_le_bytes().to_vec(),
        Precision::F32 => (*x as f32).to_le_bytes().to_vec(),
    };
    let input: Vec<u8> = pairs.iter().flatten().flat_map(bytes).collect();
    fs::write(folder.join("input"), input).unwrap();
    let program = folder.join("program");
    let mut cc = Command::new(compiler);
    cc.args(["-std=c99", "-Wall", "-Wextra", "-Werror", SEPARATE]);
    cc.args(flags).arg(folder.join("main.c"));
    printed(cc.args(["-lm", "-o"]).arg(&program));
    let output = tool(Command::new(&program).arg(folder.join("input"))).unwrap();
    let value = |bytes: &[u8]| match precision {
        Precision::F64 => f64::from_le_bytes(bytes.try_into().unwrap()),
        Precision::F32 => f32::from_le_bytes(bytes.try_into().unwrap()).into(),
    };
    output.chunks(size).map(value).collect()
}
