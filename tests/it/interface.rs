//! One interface in every language: generated code of another version does not compile, and says
//! what to do; functions of the Python package are those of the table.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use sesc_model::{Extent, Function, Given};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Checks a crate of the runtime and this module alone.
fn check(name: &str, module: &str) -> Output {
    let crate_ = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&crate_);
    fs::create_dir_all(crate_.join("src")).unwrap();
    let manifest = format!(
        "[workspace]\n[package]\nname = {name:?}\nversion = \"0.1.0\"\nedition = \"2024\"\n\
         [dependencies]\nsesc-runtime = {{ path = {:?} }}\n",
        Path::new(ROOT).join("runtime")
    );
    fs::write(crate_.join("Cargo.toml"), manifest).unwrap();
    fs::write(crate_.join("src/lib.rs"), module).unwrap();
    Command::new(env!("CARGO"))
        .args(["check", "--offline", "--quiet", "--target-dir"])
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("interface-target"))
        .current_dir(&crate_)
        .output()
        .unwrap()
}

#[test]
fn generated_code_of_another_version_says_what_to_do() {
    let module = Path::new(ROOT).join("generated/src/two_link_foot.rs");
    let module = fs::read_to_string(module).unwrap();
    let fits = check("fits", &module);
    let stderr = String::from_utf8_lossy(&fits.stderr);
    assert!(fits.status.success(), "{stderr}");

    let other = module
        .replace("__interface!(1)", "__interface!(2)")
        .replace("v1", "v2");
    assert_ne!(other, module);
    let refused = check("refused", &other);
    let stderr = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success());
    let sentence = "this file was generated for version 2 of the interface between \
                    sesc-codegen and sesc-runtime, and the sesc-runtime of this build has \
                    version 1: give both crates the same version in Cargo.toml";
    assert!(stderr.contains(sentence), "{stderr}");
}

/// Every function of the table is a method in Python, with the table's arguments but for the
/// parameters, which are the model's, its unit, and the shape of its result.
#[test]
fn the_python_package_has_the_functions_of_the_table() {
    let source = Path::new(ROOT).join("python/src/model.rs");
    let source = fs::read_to_string(source).unwrap();
    for function in Function::ALL.into_iter().chain([Function::CorrectCop]) {
        let name = function.name();
        let variant = format!("self.run(Function::{function:?}, ");
        let long = format!("Function::{function:?},\n            [");
        let call = source.find(&variant).or_else(|| source.find(&long));
        let method = &source[..call.unwrap_or_else(|| panic!("{name} is no method"))];
        let documented = method.rfind("\n\n").unwrap();
        let words: Vec<&str> = method[documented..]
            .lines()
            .map(|line| line.trim().trim_start_matches("///").trim())
            .collect();
        let method = words.join(" ");
        let arguments = function.arguments(Given::Positions).into_iter();
        let arguments = arguments.map(|argument| argument.name());
        let arguments: Vec<&str> = arguments.filter(|name| *name != "r").collect();
        let signature = format!("signature = ({}, *,", arguments.join(", "));
        assert!(method.contains(&signature), "{name}: {signature}");
        assert!(method.contains(function.error_unit()), "{name}: unit");
        let columns = match function.columns() {
            Extent::Fixed(n) => n.to_string(),
            Extent::Dof => "dof".to_string(),
            Extent::BaseParams => "p".to_string(),
            Extent::FullParams => "f".to_string(),
        };
        let rows = function.rows().map(|rows| format!("{rows}, "));
        let shape = format!("(n, {}{columns})", rows.unwrap_or_default());
        assert!(method.contains(&shape), "{name}: {shape}");
    }
}
