//! Generated code of another version does not compile, and says what to do.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

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
