//! Calls that a program begins with have examples, and `cargo test --doc` runs them.

use std::fs;
use std::path::Path;

/// Files and the calls in them.
const ENTRIES: [(&str, &[&str]); 14] = [
    ("compare.rs", &["compare"]),
    ("diagnose/request.rs", &["diagnose"]),
    ("evaluate.rs", &["struct Evaluator"]),
    ("fit/looked.rs", &["gather"]),
    ("fit/report.rs", &["fit", "residuals"]),
    ("fleet/inputs.rs", &["groups"]),
    ("fleet/run.rs", &["run"]),
    ("health/mod.rs", &["of_log"]),
    ("plan/mod.rs", &["plan"]),
    ("predict.rs", &["predict", "open"]),
    ("robot.rs", &["parse"]),
    ("simulate/mod.rs", &["simulate", "write"]),
    ("skeleton/mod.rs", &["of"]),
    ("stance.rs", &["new"]),
];

/// Whether the doc comment above `pub fn name(` (or `pub struct Name`) holds an example.
fn has_example(text: &str, entry: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim_start).collect();
    let is_entry = |line: &&str| match entry.strip_prefix("struct ") {
        Some(name) => line.starts_with(&format!("pub struct {name} ")),
        None => line.starts_with(&format!("pub fn {entry}(")),
    };
    let Some(at) = lines.iter().position(is_entry) else {
        return false;
    };
    let above = lines[..at].iter().rev();
    let mut comment = above.take_while(|line| line.starts_with("///") || line.starts_with("#["));
    comment.any(|line| line.starts_with("/// ```"))
}

#[test]
fn every_entry_has_an_example() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut missing = Vec::new();
    for (file, entries) in ENTRIES {
        let text = fs::read_to_string(src.join(file)).unwrap();
        let bare = entries.iter().filter(|entry| !has_example(&text, entry));
        missing.extend(bare.map(|entry| format!("{file}: {entry}")));
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn an_entry_without_an_example_is_found() {
    let text = "/// Sums.\npub fn a() {}\n/// ```\n/// ```\n#[must_use]\npub fn b() {}\n";
    assert!(!has_example(text, "a"));
    assert!(has_example(text, "b"));
    assert!(!has_example(text, "c"));
}
