//! What every user of a package does: generate, compile, run, compare with the reference.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_reference::{Reference, Robot};

pub(super) use sesc_test_support::command::printed as run;
use sesc_test_support::command::{self, in_words, op2, sesc, stdout, write};

pub(super) const NAME: &str = "op2_r_sole";
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The header promises 1.8e-6 m for the f32 CoM of the OP2; printing adds its own last digit.
pub(super) const F32_M: f64 = 2e-6;

/// An empty folder of its own for one test, under the target folder.
pub(super) fn fresh(name: &str) -> PathBuf {
    command::fresh(&format!("c_packages/{name}"))
}

pub(super) fn generate(out: &Path, urdf: &str, support: &str, more: &[&str]) -> Vec<PathBuf> {
    let out = out.display().to_string();
    let line = "generate @ --support @ --lang c --out @";
    let usual = in_words(line, &[urdf, support, &out]);
    let printed = stdout(&sesc(&[&usual[..], more].concat()));
    printed.lines().map(PathBuf::from).collect()
}

pub(super) fn generate_op2(out: &Path, layout: &str, scalar: &str) {
    let more = ["--layout", layout, "--scalar", scalar, "--name", NAME];
    generate(out, &op2(), "r_sole", &more);
}

pub(super) fn posture() -> Vec<f32> {
    (0..20).map(|k| 0.3 - 0.03 * k as f32).collect()
}

pub(super) fn reference(q: &[f64]) -> [f64; 3] {
    let robot = Robot::from_file(op2()).unwrap();
    Reference::new(&robot, "r_sole").unwrap().com(q).into()
}

pub(super) fn near(line: &str, expected: [f64; 3], allowed_m: f64) {
    let numbers = line.split_whitespace().map(|x| x.parse::<f64>().unwrap());
    let numbers: Vec<f64> = numbers.collect();
    assert_eq!(numbers.len(), 3, "{line}");
    let mut gaps = numbers
        .iter()
        .zip(expected)
        .map(|(got, expected)| got - expected);
    let is_near = gaps.all(|gap| gap.abs() < allowed_m);
    assert!(is_near, "{line} is not {expected:?}");
}

/// Compiles the generated source as strict C.
pub(super) fn compile_c(source: &Path, include: &Path, object: &Path) {
    let mut cc = cc(&["-x", "c", "-c", "-I"]);
    run(cc.arg(include).arg(source).arg("-o").arg(object));
}

/// A header in one line, without the marks of its comments.
pub(super) fn words(header: &str) -> String {
    let words = header.split_whitespace().filter(|word| *word != "*");
    words.collect::<Vec<_>>().join(" ")
}

/// Strict C that is compiled without a warning: `cc` with these words.
pub(super) fn cc(words: &[&str]) -> Command {
    let mut cc = Command::new("cc");
    cc.args("-std=c99 -pedantic -Wall -Wextra -Werror".split(' '));
    cc.args(words);
    cc
}

/// Files below `folder`, sorted, with `/` between names.
pub(super) fn files(folder: &Path) -> Vec<String> {
    let name = |path: &PathBuf| {
        let file = path.strip_prefix(folder).unwrap();
        let parts: Vec<_> = file.iter().map(|part| part.to_str().unwrap()).collect();
        parts.join("/")
    };
    let mut found: Vec<String> = command::files(folder).keys().map(name).collect();
    found.sort();
    found
}

/// Robots are named by people, and every format quotes the name in its own way: a robot of such a
/// name, as a package of a layout.
pub(super) fn oddly_named(folder: &Path, layout: &str) -> (String, PathBuf) {
    let robot = r#"a"b'c;d $e @PATH@ $ENV{HOME} #f \" `h` <i>&*j*%k%]]=二足🤖\"#;
    let escaped = robot.replace('&', "&amp;").replace('<', "&lt;");
    let escaped = escaped.replace('"', "&quot;");
    let urdf = format!(
        "<robot name=\"{escaped}\"><link name=\"{escaped}\"><inertial><mass value=\"1\"/>\
         </inertial></link></robot>"
    );
    let urdf = write(folder, "odd.urdf", urdf);
    let out = folder.join(layout);
    generate(&out, &urdf, robot, &["--layout", layout, "--name", "odd"]);
    (robot.to_string(), out)
}

/// What PlatformIO is told of it.
pub(super) fn odd_description(folder: &Path) -> String {
    let (robot, package) = oddly_named(folder, "platformio");
    let manifest = fs::read_to_string(package.join("library.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    let description = manifest["description"].as_str().unwrap().to_string();
    let start = format!("Centre of mass of {robot} standing on {robot} (");
    assert!(description.starts_with(&start), "{description}");
    description
}

/// Keys and values of an Arduino library.
pub(super) fn properties(library: &Path) -> BTreeMap<String, String> {
    let text = fs::read_to_string(library.join("library.properties")).unwrap();
    let pairs = text.lines().map(|line| line.split_once('=').unwrap());
    let pairs = pairs.map(|(key, value)| (key.to_string(), value.to_string()));
    pairs.collect()
}
