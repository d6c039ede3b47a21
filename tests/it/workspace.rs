//! No dependency needs a newer compiler than `rust-version`; published crates are complete.

use std::fs;
use std::process::Command;

use serde_json::Value;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn printed(command: &mut Command) -> String {
    let output = command.current_dir(ROOT).output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// What `cargo metadata` says of its packages.
fn packages(arguments: &[&str]) -> Vec<Value> {
    let text = printed(
        Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked", "--offline"])
            .args(arguments),
    );
    let metadata: Value = serde_json::from_str(&text).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Packages of the workspace alone.
fn members() -> Vec<Value> {
    packages(&["--no-deps"])
}

/// Packages of the workspace and all that they are built from on this machine.
fn all_packages() -> Vec<Value> {
    let rustc = printed(Command::new("rustc").arg("-vV"));
    let host = rustc.lines().find_map(|line| line.strip_prefix("host: "));
    packages(&["--filter-platform", host.unwrap()])
}

/// `1.89` or `1.89.0` as numbers.
fn version(text: &str) -> Vec<u32> {
    let mut numbers: Vec<u32> = text.split('.').map(|part| part.parse().unwrap()).collect();
    numbers.resize(3, 0);
    numbers
}

#[test]
fn no_dependency_needs_a_newer_compiler() {
    let promised = version(env!("CARGO_PKG_RUST_VERSION"));
    for package in all_packages() {
        let Some(needed) = package["rust_version"].as_str() else {
            continue;
        };
        assert!(
            version(needed) <= promised,
            "{} {} needs Rust {needed}; raise rust-version in Cargo.toml or hold it back",
            package["name"],
            package["version"]
        );
    }
}

#[test]
fn published_crates_carry_licences_and_a_description() {
    for package in members() {
        // `publish = false` is an empty list of registries.
        if package["publish"].is_array() {
            continue;
        }
        let name = &package["name"];
        assert_eq!(package["license"], "MIT OR Apache-2.0", "{name}");
        for key in ["description", "readme"] {
            assert!(package[key].is_string(), "{name}: {key}");
        }
        for key in ["keywords", "categories"] {
            assert!(
                !package[key].as_array().unwrap().is_empty(),
                "{name}: {key}"
            );
        }
        let folder = package["manifest_path"].as_str().unwrap();
        let folder = folder.strip_suffix("Cargo.toml").unwrap();
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let text = fs::read_to_string(format!("{folder}{licence}"));
            assert!(text.is_ok(), "{folder}{licence} is missing");
        }
        let dependencies = package["dependencies"].as_array().unwrap();
        for dependency in dependencies.iter().filter(|d| d["path"].is_string()) {
            let dev = dependency["kind"] == "dev";
            assert!(
                dev || dependency["req"] != "*",
                "{name}: {} has a path and no version",
                dependency["name"]
            );
        }
    }
}

/// What `pip install ./python` is compiled by; a release is by its own.
#[test]
fn an_installation_of_the_python_package_has_a_profile_of_its_own() {
    let read = |file: &str| -> toml::Table {
        let text = fs::read_to_string(format!("{ROOT}/{file}")).unwrap();
        text.parse().unwrap()
    };
    let (project, workspace) = (read("python/pyproject.toml"), read("Cargo.toml"));
    let name = project["tool"]["maturin"]["profile"].as_str().unwrap();
    let profile = &workspace["profile"][name];
    assert_eq!(profile["inherits"].as_str(), Some("release"));
    assert!(profile["opt-level"].as_integer() < Some(3), "{profile:?}");
    let locked = read("Cargo.lock");
    let known = locked["package"].as_array().unwrap();
    for package in profile["package"].as_table().unwrap().keys() {
        let is_known = known
            .iter()
            .any(|own| own["name"].as_str() == Some(package));
        assert!(package == "*" || is_known, "{package}");
    }
    let wheels = fs::read_to_string(format!("{ROOT}/python/wheels.sh")).unwrap();
    assert!(wheels.contains("maturin build --quiet --release"));
}
