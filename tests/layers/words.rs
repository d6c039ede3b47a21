//! Words and sentences: a doc comment is a sentence or a noun phrase that is understood by
//! itself, words are the field's, and paths that pages name are there.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::ROOT;

/// How a doc comment begins that depends on the line above it: "Of x and y."
const ELLIPSES: [&str; 3] = ["Of ", "By ", "As "];

/// Words of which the field has others, in prose and in code.
const REPLACED: [(&str, &str); 9] = [
    ("foretold", "predicted"),
    ("foretell", "predict"),
    ("foretelling", "prediction"),
    ("sliding", "prismatic"),
    ("perceived", "sensor reading"),
    ("circumstances", "context"),
    ("price", "penalty"),
    ("priced", "with a penalty"),
    ("strained", "at bound"),
];

/// Names in Rust code of which the field has others; in prose the words have an ordinary meaning.
const NAMES: [(&str, &str); 8] = [
    ("turning", "revolute, angular velocity"),
    ("turnings", "rotations"),
    ("slide", "prismatic"),
    ("slides", "prismatic"),
    ("of_posture", "static"),
    ("excess", "bound violation"),
    ("promise", "predicted score"),
    ("absorb", "merge"),
];

/// Files in which such a name has its ordinary meaning, and which.
const ORDINARY: [(&str, &str, &str); 6] = [
    (
        "model/src/measurement/bends.rs",
        "slide",
        "a loose joint slides in its dead band",
    ),
    (
        "reference/src/world/statics.rs",
        "slide",
        "a loose joint slides in its dead band",
    ),
    (
        "reference/src/world/statics.rs",
        "slides",
        "a loose joint slides in its dead band",
    ),
    (
        "reference/tests/it/world_sensor.rs",
        "excess",
        "load above a quarter",
    ),
    (
        "codegen/src/emit/rust.rs",
        "of_posture",
        "methods whose argument is a posture",
    ),
    (
        "codegen/src/emit/c/routines.rs",
        "of_posture",
        "routines whose argument is a posture",
    ),
];

/// Phrases that say less than a plain sentence.
const PHRASES: [&str; 5] = [
    "can be the matter with",
    "could not have seen",
    "must be said of",
    "a matrix that is there",
    "as soon as it is there",
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
pub(crate) fn texts(endings: &[&str]) -> Vec<(String, String)> {
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

/// Identifiers of a line of Rust: neither strings nor comments.
fn identifiers(line: &str) -> Vec<String> {
    let code = line.split("//").next().unwrap_or_default();
    let code: String = code.split('"').step_by(2).collect::<Vec<&str>>().join(" ");
    let names = code.split(|c: char| !c.is_alphanumeric() && c != '_');
    names.map(str::to_lowercase).collect()
}

#[test]
fn names_in_code_are_those_of_the_field() {
    let mut complaints = String::new();
    let mut used = Vec::new();
    let own = "tests/layers/words.rs";
    for (file, text) in texts(&["rs"]).into_iter().filter(|(file, _)| file != own) {
        for (k, line) in text.lines().enumerate() {
            for name in identifiers(line) {
                let Some((old, new)) = NAMES.iter().find(|(old, _)| *old == name) else {
                    continue;
                };
                let is_it = |known: &&(&str, &str, &str)| (known.0, known.1) == (&*file, *old);
                match ORDINARY.iter().find(is_it) {
                    Some(known) => used.push(known),
                    None => {
                        let _ = writeln!(complaints, "{file}:{}: {old}: write {new}", k + 1);
                    }
                }
            }
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
    let stale = ORDINARY.iter().filter(|known| !used.contains(known));
    let stale: Vec<_> = stale.collect();
    assert!(stale.is_empty(), "no longer used: {stale:?}");
}

#[test]
fn identifiers_are_read_without_strings_and_comments() {
    let found = identifiers("let Slide { by } = slide(\"turning\"); // behind");
    let found: Vec<&String> = found.iter().filter(|name| !name.is_empty()).collect();
    assert_eq!(found, ["let", "slide", "by", "slide"]);
}

#[test]
fn phrases_are_plain_sentences() {
    let mut complaints = String::new();
    for (file, text) in texts(&["rs", "md", "html", "py", "pyi"]) {
        let own = ["tests/layers/words.rs", "CHANGELOG.md"];
        for phrase in PHRASES {
            if text.contains(phrase) && !own.contains(&file.as_str()) {
                let _ = writeln!(complaints, "{file}: {phrase}");
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
