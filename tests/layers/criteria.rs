//! Numbers that decide what is said stand in files called `criteria.rs`, and each says where
//! it comes from.

use std::fmt::Write as _;

/// A doc says that a number follows from a formula, was counted, or was chosen.
const ORIGINS: [&str; 4] = ["closed form", "calibrated", "the study", "chosen"];

/// Constants without an origin in their own doc, with their lines.
fn without_origin(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut doc = String::new();
    for (k, line) in text.lines().map(str::trim).enumerate() {
        if let Some(said) = line.strip_prefix("///") {
            doc += said;
            continue;
        }
        let declared = line.starts_with("pub").then(|| line.split_once("const "));
        if let Some((_, declared)) = declared.flatten() {
            let said = doc.to_lowercase();
            if !ORIGINS.iter().any(|origin| said.contains(origin)) {
                let name = declared.split(':').next().unwrap_or_default();
                found.push((k + 1, name.to_string()));
            }
        }
        doc.clear();
    }
    found
}

#[test]
fn every_criterion_says_where_it_comes_from() {
    let mut complaints = String::new();
    let mut read = 0;
    for (file, text) in crate::words::texts(&["rs"]) {
        if !file.ends_with("/criteria.rs") || file.starts_with("tests/") {
            continue;
        }
        read += 1;
        for (line, name) in without_origin(&text) {
            let _ = writeln!(complaints, "{file}:{line}: {name}");
        }
    }
    assert!(read > 6, "{read} files of criteria");
    assert!(
        complaints.is_empty(),
        "say in the doc: closed form, calibrated on, or chosen, and what a factor of two \
         changes:\n{complaints}"
    );
}

#[test]
fn a_criterion_without_an_origin_is_seen() {
    let text = "/// Chosen: half does less.\npub const A: f64 = 1.0;\npub const B: f64 = 2.0;\n\
                /// A limit, m.\npub(super) const C: f64 = 3.0;";
    let found = without_origin(text);
    assert_eq!(found, [(3, "B".to_string()), (5, "C".to_string())]);
}
