//! What every user of a package does: generate, compile, run, compare with the reference.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_reference::{Reference, Robot};

use sesc_test_support::command::{in_words, op2, sesc, stdout};

pub const NAME: &str = "op2_r_sole";
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The header promises 1.8e-6 m for the f32 CoM of the OP2; printing adds its own last digit.
pub const F32_M: f64 = 2e-6;

/// What `program` prints; its failure is ours, with all it said.
pub fn run(program: &mut Command) -> String {
    let package = match program.get_program().to_str().unwrap() {
        "cmake" => "cmake (and make or ninja)",
        "pkg-config" => "pkg-config or pkgconf",
        "cc" => "a C compiler as cc",
        "c++" => "a C++ compiler as c++",
        other => other,
    }
    .to_string();
    let output = program.output().unwrap_or_else(|error| {
        panic!("{program:?}: {error}; this test needs {package}: install it")
    });
    assert!(
        output.status.success(),
        "{program:?}: {}\n{}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// A folder of its own for one test, empty, under the target folder.
pub fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("c_packages")
        .join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

pub fn generate(out: &Path, urdf: &str, support: &str, more: &[&str]) -> Vec<PathBuf> {
    let out = out.display().to_string();
    let usual = in_words(
        "generate @ --support @ --lang c --out @",
        &[urdf, support, &out],
    );
    stdout(&sesc(&[&usual[..], more].concat()))
        .lines()
        .map(PathBuf::from)
        .collect()
}

pub fn generate_op2(out: &Path, layout: &str, scalar: &str) {
    let more = ["--layout", layout, "--scalar", scalar, "--name", NAME];
    generate(out, &op2(), "r_sole", &more);
}

pub fn posture() -> Vec<f32> {
    (0..20).map(|k| 0.3 - 0.03 * k as f32).collect()
}

pub fn reference(q: &[f64]) -> [f64; 3] {
    let robot = Robot::from_file(op2()).unwrap();
    Reference::new(&robot, "r_sole").unwrap().com(q).into()
}

pub fn near(line: &str, expected: [f64; 3], allowed_m: f64) {
    let numbers: Vec<f64> = line
        .split_whitespace()
        .map(|x| x.parse().unwrap())
        .collect();
    assert_eq!(numbers.len(), 3, "{line}");
    for (got, expected) in numbers.iter().zip(expected) {
        assert!(
            (got - expected).abs() < allowed_m,
            "{line} is not {expected:?}"
        );
    }
}

/// Compiles the generated source as strict C.
pub fn compile_c(source: &Path, include: &Path, object: &Path) {
    run(Command::new("cc")
        .args([
            "-x",
            "c",
            "-std=c99",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
            "-c",
            "-I",
        ])
        .arg(include)
        .arg(source)
        .arg("-o")
        .arg(object));
}

/// Files below `folder`, sorted, with `/` between names.
pub fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let file = path.strip_prefix(folder).unwrap();
                let parts: Vec<_> = file.iter().map(|part| part.to_str().unwrap()).collect();
                found.push(parts.join("/"));
            }
        }
    }
    found.sort();
    found
}

/// Keys and values of an Arduino library.
pub fn properties(library: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(library.join("library.properties")).unwrap();
    text.lines()
        .map(|line| {
            let (key, value) = line.split_once('=').unwrap();
            (key.to_string(), value.to_string())
        })
        .collect()
}
