//! Words and sentences: a doc comment is a sentence or a noun phrase that is understood by
//! itself, words are the field's, and paths that pages name are there.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::ROOT;

/// How a doc comment begins that depends on the line above it: "Of x and y."
const ELLIPSES: [&str; 3] = ["Of ", "By ", "As "];

/// Words of which the field has others.
const REPLACED: [(&str, &str); 6] = [
    ("foretold", "predicted"),
    ("foretell", "predict"),
    ("foretelling", "prediction"),
    ("sliding", "prismatic"),
    ("perceived", "sensor reading"),
    ("circumstances", "context"),
];

/// Files that are kept in the tree, but for what is machine-written.
fn files() -> Vec<PathBuf> {
    let listed = Command::new("git")
        .args([
            "-C",
            ROOT,
            "ls-files",
            "--cached",
            "--others",
            "--exclude-standard",
        ])
        .output()
        .unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    let written = [
        "generated/",
        "codegen/tests/golden/",
        "docs/fleet-page",
        "fuzz/corpus",
    ];
    let own = listed
        .lines()
        .filter(|path| !written.iter().any(|folder| path.starts_with(folder)));
    let files: Vec<PathBuf> = own.map(|path| Path::new(ROOT).join(path)).collect();
    assert!(files.len() > 500, "git lists {} files", files.len());
    files
}

/// Texts of the files whose names end like this.
fn texts(endings: &[&str]) -> Vec<(String, String)> {
    let has_ending = |path: &Path| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        ending.is_some_and(|ending| endings.contains(&ending))
    };
    let files = files().into_iter().filter(|path| has_ending(path));
    let read = files.filter_map(|path| {
        let name = path.strip_prefix(ROOT).unwrap().display().to_string();
        Some((name, fs::read_to_string(path).ok()?))
    });
    read.collect()
}

/// Lines that begin a doc comment like the end of another sentence.
fn ellipses(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut inside = false;
    for (k, line) in text.lines().enumerate() {
        let comment = line.trim_start().strip_prefix("/// ");
        if let Some(comment) = comment
            && !inside
            && ELLIPSES.iter().any(|opening| comment.starts_with(opening))
        {
            found.push((k + 1, comment));
        }
        inside = line.trim_start().starts_with("///");
    }
    found
}

#[test]
fn doc_comments_stand_alone() {
    let mut complaints = String::new();
    for (name, text) in texts(&["rs"]) {
        for (line, comment) in ellipses(&text) {
            let _ = writeln!(complaints, "{name}:{line}: {comment}");
        }
    }
    assert!(complaints.is_empty(), "say what the item is:\n{complaints}");
}

#[test]
fn an_ellipsis_is_seen_where_a_comment_begins() {
    let text = "/// Mass, kg.\n/// Of the body.\nm: f64,\n/// Of the axis.\nlength: f64,\n";
    assert_eq!(ellipses(text), [(4, "Of the axis.")]);
}

#[test]
fn words_are_those_of_the_field() {
    // The changelog names what was called otherwise.
    let own = ["tests/layers/words.rs", "CHANGELOG.md"];
    let mut complaints = String::new();
    for (name, text) in texts(&["rs", "md", "html", "py", "pyi", "js", "c", "h"]) {
        for (k, line) in text.lines().enumerate() {
            let lower = line.to_lowercase();
            let mut words = lower.split(|c: char| !c.is_alphanumeric());
            let replaced = |word: &str| REPLACED.iter().find(|(old, _)| *old == word);
            if let Some((old, new)) = words.find_map(replaced)
                && !own.contains(&name.as_str())
            {
                let _ = writeln!(complaints, "{name}:{}: {old}: write {new}", k + 1);
            }
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
}

/// What stands between backquotes and is a path of this tree: it begins with a folder of
/// the root and has no space.
fn paths(text: &str) -> Vec<&str> {
    let folders = [
        "benches/",
        "codegen/",
        "docs/",
        "examples/",
        "fuzz/",
        "generated/",
        "identify/",
        "model/",
        "python/",
        "reference/",
        "robots/",
        "runtime/",
        "src/",
        "tests/",
        "xtask/",
    ];
    let quoted = text.split('`').skip(1).step_by(2);
    let path = |text: &&str| {
        folders.iter().any(|folder| text.starts_with(folder))
            && !text.contains([' ', '*', '<', '{', '…', ':', '\n'])
            && !text.contains("NAME")
    };
    quoted
        .filter(path)
        .map(|path| path.trim_end_matches('/'))
        .collect()
}

#[test]
fn paths_that_pages_name_are_there() {
    let mut complaints = String::new();
    let mut named = 0;
    for (name, text) in texts(&["md"]) {
        // Fenced text is commands of a reader's own folder, and an odd fence would shift quotes.
        let prose: String = text.split("```").step_by(2).collect();
        for path in paths(&prose) {
            named += 1;
            let beside = Path::new(ROOT).join(&name).with_file_name(path);
            if !Path::new(ROOT).join(path).exists() && !beside.exists() {
                let _ = writeln!(complaints, "{name}: {path}");
            }
        }
    }
    assert!(complaints.is_empty(), "no such file:\n{complaints}");
    assert!(named > 50, "only {named} paths are named");
}
