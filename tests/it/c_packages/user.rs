//! What every user of a package does: generate, compile, run, compare with the reference.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use sesc_reference::{Reference, Robot};

use sesc_test_support::command::{op2, sesc, stdout, write};

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
    let usual = [
        "generate",
        urdf,
        "--support",
        support,
        "--lang",
        "c",
        "--out",
        &out,
    ];
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

/// A user's program in C and C++ alike: prints the CoM, returns what the self-test says.
pub fn program() -> String {
    let q: Vec<String> = posture().iter().map(|q| format!("{q:?}f")).collect();
    format!(
        "#include <{NAME}.h>\n#include <stdio.h>\n\n\
         int main(void)\n{{\n    const {NAME}_real q[{NAME}_DOF] = {{{}}};\n    \
         {NAME}_real com[3];\n    {NAME}_com(q, {NAME}_cad_params, com);\n    \
         printf(\"%.9g %.9g %.9g\\n\", (double)com[0], (double)com[1], (double)com[2]);\n    \
         return {NAME}_selftest();\n}}\n",
        q.join(", ")
    )
}

/// Runs a compiled [`program`].
pub fn agrees(binary: &Path) {
    let q: Vec<f64> = posture().into_iter().map(f64::from).collect();
    near(&run(&mut Command::new(binary)), reference(&q), F32_M);
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

pub fn configure(source: &Path, build: &Path, options: &[&str]) {
    let mut cmake = Command::new("cmake");
    cmake.arg("-S").arg(source).arg("-B").arg(build);
    // Deprecations and misuse of the package fail here, not at its users.
    run(cmake
        .args(["-Werror=dev", "-DCMAKE_BUILD_TYPE=Release"])
        .args(options));
}

pub fn build(build: &Path) {
    run(Command::new("cmake").arg("--build").arg(build));
}

/// Generated, built and installed below `folder`; the prefix.
pub fn install(folder: &Path, options: &[&str]) -> PathBuf {
    let (source, built, prefix) = (
        folder.join("source"),
        folder.join("build"),
        folder.join("prefix"),
    );
    generate_op2(&source, "cmake", "f32");
    configure(
        &source,
        &built,
        &[&["-DCMAKE_INSTALL_LIBDIR=lib"], options].concat(),
    );
    build(&built);
    install_to(&built, &prefix);
    prefix
}

pub fn install_to(built: &Path, prefix: &Path) {
    run(Command::new("cmake")
        .arg("--install")
        .arg(built)
        .arg("--prefix")
        .arg(prefix));
}

/// The package as most users have it, installed once.
pub fn installed() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| install(&fresh("installed"), &[]))
}

/// A CMake project that takes the package in by `how` and links it, in C, C++ or both.
pub fn consumer(folder: &Path, languages: &str, how: &str) -> PathBuf {
    let mut lists = format!(
        "cmake_minimum_required(VERSION 3.14)\nproject(consumer LANGUAGES {languages})\n{how}\n"
    );
    for language in languages.split(' ') {
        let suffix = if language == "C" { "c" } else { "cpp" };
        write(folder, &format!("main.{suffix}"), program());
        lists += &format!(
            "add_executable(from_{suffix} main.{suffix})\n\
             target_link_libraries(from_{suffix} PRIVATE {NAME}::{NAME})\n\
             install(TARGETS from_{suffix} DESTINATION bin)\n"
        );
    }
    write(folder, "CMakeLists.txt", lists);
    folder.join("build")
}

pub fn found(folder: &Path, prefix: &Path) {
    let how = format!("find_package({NAME} {VERSION} REQUIRED)");
    let built = consumer(folder, "C CXX", &how);
    configure(
        folder,
        &built,
        &[&format!("-DCMAKE_PREFIX_PATH={}", prefix.display())],
    );
    build(&built);
    agrees(&built.join("from_c"));
    agrees(&built.join("from_cpp"));
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
