//! README shows what the commands print and the generator writes.
//!
//! `SESC_BLESS=1 cargo test --test readme` accepts new output.

use std::fs;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Fenced blocks of the given kind.
fn blocks(text: &str, kind: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line == format!("```{kind}") {
            let inside = lines.by_ref().take_while(|line| *line != "```");
            blocks.push(inside.collect::<Vec<_>>().join("\n"));
        }
    }
    blocks
}

#[test]
fn the_output_shown_is_the_output_printed() {
    let readme = fs::read_to_string(format!("{ROOT}/README.md")).unwrap();
    assert_eq!(blocks(&readme, "sh")[0], "cargo run --release -- demo");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_sesc"))
        .arg("demo")
        .current_dir(folder.path())
        .output()
        .unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let shown = &blocks(&readme, "text")[0];
    if std::env::var_os("SESC_BLESS").is_some() {
        let accepted = readme.replace(shown.as_str(), printed.trim_end());
        fs::write(format!("{ROOT}/README.md"), accepted).unwrap();
        return;
    }
    assert_eq!(printed.lines().count(), shown.lines().count());
    for (printed, shown) in printed.lines().zip(shown.lines()) {
        let (a, b): (Vec<&str>, Vec<&str>) = (
            printed.split_whitespace().collect(),
            shown.split_whitespace().collect(),
        );
        assert_eq!(a.len(), b.len(), "{printed}\n{shown}");
        for (a, b) in a.iter().zip(&b) {
            // Rounding errors differ a little from machine to machine; nothing else does.
            let same = match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(x), Ok(y)) if x.abs() < 1e-6 => (x / y).log2().abs() < 1.0,
                _ => a == b,
            };
            assert!(same, "{printed}\n{shown}");
        }
    }
}

#[test]
fn the_lines_shown_are_generated() {
    let readme = fs::read_to_string(format!("{ROOT}/README.md")).unwrap();
    let module = fs::read_to_string(format!("{ROOT}/generated/src/op2_r_sole.rs")).unwrap();
    assert!(module.contains(&blocks(&readme, "rust")[0]));
}
