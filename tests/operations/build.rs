//! The programs as Rust and as C, compiled and run on rows of numbers.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_codegen::emit::{c, rust};
use sesc_model::bounds::Precision;

use crate::programs::Case;

pub const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// What every C file must pass without a word.
pub const WARNINGS: [&str; 11] = [
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wdouble-promotion",
    "-Wfloat-equal",
    "-Wshadow",
    "-Wundef",
    "-Wmissing-prototypes",
    "-Werror",
];

pub type Rows = [[Vec<f64>; 2]];

/// A fresh folder.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("operations")
        .join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("src")).unwrap();
    folder
}

pub fn tool(command: &mut Command) -> Vec<u8> {
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not start: {error}; run `tests/setup`"));
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

fn bytes(rows: &Rows, precision: Precision) -> Vec<u8> {
    let values = rows.iter().flat_map(|row| row.iter().flatten());
    match precision {
        Precision::F64 => values.flat_map(|x| x.to_le_bytes()).collect(),
        Precision::F32 => values.flat_map(|x| (*x as f32).to_le_bytes()).collect(),
    }
}

fn floats(bytes: &[u8], precision: Precision) -> Vec<f64> {
    match precision {
        Precision::F64 => bytes
            .chunks(8)
            .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
            .collect(),
        Precision::F32 => bytes
            .chunks(4)
            .map(|b| f32::from_le_bytes(b.try_into().unwrap()).into())
            .collect(),
    }
}

/// Results of compiled Rust, case by case: in f64, in f32, in lanes of four f64.
pub fn rust(cases: &[(&Case, &Rows)]) -> Vec<[Vec<f64>; 3]> {
    let folder = folder("rust");
    let manifest = format!(
        "[workspace]\n[package]\nname = \"operations\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\
         [dependencies]\nsesc-runtime = {{ path = {:?} }}\n",
        Path::new(ROOT).join("runtime")
    );
    fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    let (mut modules, mut calls) = (String::new(), String::new());
    for (case, rows) in cases {
        let name = case.name;
        let text = rust::free::function(&case.program, name).unwrap();
        fs::write(folder.join(format!("src/{name}.rs")), text).unwrap();
        fs::write(
            folder.join(format!("{name}.in")),
            bytes(rows, Precision::F64),
        )
        .unwrap();
        let _ = writeln!(modules, "mod {name};");
        let [x, y] = [0, 1].map(|k| case.ranges[k].len());
        let _ = writeln!(calls, "    run!({name}, {x}, {y});");
    }
    let main = include_str!("main_of_rust.rs.in")
        .replace("// modules", &modules)
        .replace("// calls", &calls);
    fs::write(folder.join("src/main.rs"), main).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("operations-target");
    tool(
        Command::new(env!("CARGO"))
            .args(["run", "--release", "--offline", "--quiet", "--target-dir"])
            .arg(target)
            .current_dir(&folder),
    );
    let read = |name: &str, what: &str| {
        floats(
            &fs::read(folder.join(format!("{name}.{what}"))).unwrap(),
            Precision::F64,
        )
    };
    cases
        .iter()
        .map(|(case, _)| ["f64", "f32", "lanes"].map(|what| read(case.name, what)))
        .collect()
}

/// Header and source of a case, written to `folder`; the path of the source.
pub fn write_c(folder: &Path, case: &Case, precision: Precision) -> PathBuf {
    let package = c::free::function(&case.program, case.name, precision, &case.inputs()).unwrap();
    fs::write(folder.join(format!("{}.h", case.name)), package.header).unwrap();
    let source = folder.join(format!("{}.c", case.name));
    fs::write(&source, package.source).unwrap();
    source
}

/// Results of compiled C.
pub fn c(
    case: &Case,
    rows: &Rows,
    precision: Precision,
    compiler: &str,
    flags: &[&str],
) -> Vec<f64> {
    let name = case.name;
    let folder = folder(&format!(
        "{name}_{precision:?}_{compiler}{}",
        flags.concat()
    ));
    let source = write_c(&folder, case, precision);
    let main = include_str!("main_of_c.c.in")
        .replace("NAME", name)
        .replace("X_LEN", &case.ranges[0].len().to_string())
        .replace("Y_LEN", &case.ranges[1].len().to_string())
        .replace("OUT_LEN", &case.program.outputs.len().to_string());
    fs::write(folder.join("main.c"), main).unwrap();
    fs::write(folder.join("input"), bytes(rows, precision)).unwrap();
    let program = folder.join("program");
    tool(
        Command::new(compiler)
            .args(WARNINGS)
            .arg("-ffp-contract=off")
            .args(flags)
            .arg(&source)
            .arg(folder.join("main.c"))
            .arg("-o")
            .arg(&program)
            // After the sources: asked for or not, the library must not be missed.
            .args(
                flags
                    .iter()
                    .any(|flag| flag.contains("LIBM"))
                    .then_some("-lm"),
            ),
    );
    floats(
        &tool(Command::new(&program).arg(folder.join("input"))),
        precision,
    )
}
