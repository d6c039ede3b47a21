//! Names are for people and files: an effect, a verdict, a finding or a change is compared
//! by its type, and its name is read or written in one place.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use sesc_identify::diagnose::Verdict;
use sesc_identify::health::KINDS;
use sesc_model::effects::Catalog;

/// Folders whose code compares no names.
const FOLDERS: [&str; 6] = [
    "model/src/",
    "codegen/src/",
    "identify/src/",
    "src/",
    "python/src/",
    "xtask/src/",
];

/// What stands before a name that is compared, without spaces.
const BEFORE: [&str; 10] = [
    "==",
    "!=",
    "starts_with(",
    "ends_with(",
    "contains(",
    "contains(&",
    "strip_prefix(",
    "strip_suffix(",
    "replace(",
    "split(",
];

/// What stands behind one: it is compared, or it is a pattern.
const BEHIND: [&str; 4] = ["==", "!=", "=>", "|"];

/// Names of effects, verdicts and findings.
fn names() -> BTreeSet<String> {
    let catalog = Catalog::standard();
    let effects = catalog.iter().map(|effect| effect.id().name());
    let verdicts = Verdict::ALL.into_iter().map(Verdict::name);
    let findings = KINDS.into_iter().map(|kind| kind.name());
    let all = effects.chain(verdicts).chain(findings);
    all.map(str::to_string).collect()
}

/// Names that a text compares, with their lines; what stands behind `#[cfg(test)]` and
/// comments are left out. A prefix counts as its name: `"joint_offset:"`.
fn compared(text: &str, names: &BTreeSet<String>) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (k, line) in text.lines().enumerate() {
        if line.starts_with("#[cfg(test)]") {
            break;
        }
        if line.trim_start().starts_with("//") {
            continue;
        }
        let parts: Vec<&str> = line.split('"').collect();
        for at in (1..parts.len()).step_by(2) {
            let name = parts[at].trim_end_matches(':');
            if !names.contains(name) {
                continue;
            }
            let before = parts[at - 1].trim_end();
            let behind = parts.get(at + 1).map_or("", |rest| rest.trim_start());
            // `Verdict::None => "none" | …` is no pattern: an arm's value ends in a comma.
            let is_compared = BEFORE.iter().any(|end| before.ends_with(end))
                || BEHIND.iter().any(|start| behind.starts_with(start))
                || (before.contains("matches!(") && !before.contains("=>"));
            if is_compared {
                found.push((k + 1, name.to_string()));
            }
        }
    }
    found
}

#[test]
fn names_of_effects_verdicts_and_findings_are_not_compared() {
    let names = names();
    let mut complaints = String::new();
    let mut read = 0;
    for (file, text) in crate::words::texts(&["rs"]) {
        let is_test = file.contains("/tests") || file.ends_with("_tests.rs");
        if is_test || !FOLDERS.iter().any(|folder| file.starts_with(folder)) {
            continue;
        }
        read += 1;
        for (line, name) in compared(&text, &names) {
            let _ = writeln!(complaints, "{file}:{line}: {name}");
        }
    }
    assert!(read > 400, "{read} files were read");
    assert!(
        complaints.is_empty(),
        "compare the type, not its name:\n{complaints}"
    );
}

#[test]
fn a_compared_name_is_seen() {
    let text = "a == \"payload\"\n\"named\" | \"class\" => 1,\nVerdict::Named => \"named\",\n\
                x.replace(\"joint_offset:\", y)\nnew(\"payload\")\nmatches!(x, \"absorbed\")\n\
                #[cfg(test)]\na == \"payload\"";
    let found = compared(text, &names());
    let lines: Vec<usize> = found.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [1, 2, 2, 4, 6]);
}
