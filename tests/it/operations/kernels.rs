//! Clamp and power of the generated C, compiled and run on pairs of numbers.

use std::fs;
use std::path::Path;
use std::process::Command;

use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_identify::robot::Robot;
use sesc_model::bounds::Precision;
use sesc_model::{EffectRecord, ModelFile, Quantity, Snapping};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Reads pairs from a file; writes quotient, clamp and power of each.
const MAIN: &str = r#"#include "two_link.c"
#include <stdio.h>

int main(int count, char **arguments)
{
    two_link_real in[2], out[3];
    FILE *input = (count > 1) ? fopen(arguments[1], "rb") : NULL;
    if (input == NULL) {
        return 2;
    }
    while (fread(in, sizeof in, 1u, input) == 1u) {
        out[0] = in[0] / in[1];
        out[1] = two_link_clamp(in[0]);
        out[2] = two_link_power(in[0], in[1]);
        if (fwrite(out, sizeof out, 1u, stdout) != 1u) {
            return 3;
        }
    }
    return fclose(input);
}
"#;

/// A package whose readings need both helpers: one cell saturates, one is not linear.
fn package(scalar: Scalar) -> c::Package {
    let urdf = Path::new(ROOT).join("robots/two_link/two_link.urdf");
    let model = Robot::read(&urdf).unwrap();
    let model = model.model("foot", Snapping::default(), None).unwrap();
    let mut file = ModelFile::from_values(&model, &model.cad_params(), None, "data");
    file.cells = vec![[0.1, 0.06], [0.1, -0.06], [-0.1, -0.06], [-0.1, 0.06]];
    let effect = |effect: &str, target: &str, name: &str, value| EffectRecord {
        effect: effect.to_string(),
        target: target.to_string(),
        parameters: [(name.to_string(), Quantity { value, std: None })].into(),
    };
    file.effects = vec![
        effect("cell_saturation", "fsr_1", "level_n", 15.0),
        effect("cell_exponent", "fsr_2", "exponent", 1.1),
    ];
    let model = model.with_file(file).unwrap();
    c::package(&Facts::of(&model), "two_link", &Options::of(scalar)).unwrap()
}

/// Quotient, clamp and power of each pair, one after the other.
pub fn run(precision: Precision, compiler: &str, flags: &[&str], pairs: &[[f64; 2]]) -> Vec<f64> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("operations")
        .join(format!("{precision:?}_{compiler}{}", flags.concat()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
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
    tool(
        Command::new(compiler)
            .args([
                "-std=c99",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-ffp-contract=off",
            ])
            .args(flags)
            .arg(folder.join("main.c"))
            .args(["-lm", "-o"])
            .arg(&program),
    );
    let output = tool(Command::new(&program).arg(folder.join("input")));
    let value = |bytes: &[u8]| match precision {
        Precision::F64 => f64::from_le_bytes(bytes.try_into().unwrap()),
        Precision::F32 => f32::from_le_bytes(bytes.try_into().unwrap()).into(),
    };
    output.chunks(size).map(value).collect()
}

fn tool(command: &mut Command) -> Vec<u8> {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}
