//! Data walks one way: within each crate a room imports only from rooms that stand
//! before it, and crates depend on each other only as ARCHITECTURE.md draws them.
//!
//! A stage that needs something of a later one is a sign that the thing stands in the
//! wrong room: move the thing, not the import.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Rooms of each crate, files or folders of `src/`, first to last.
const ROOMS: [(&str, &[&str]); 4] = [
    (
        "model",
        &[
            "text",
            "hash",
            "urdf",
            "error",
            "files",
            "snap",
            "names",
            "tree",
            "chain",
            "frames",
            "numeric",
            "base",
            "robot",
            "standard",
            "expr",
            "program",
            "bounds",
            "tape",
            "interface",
            "functions",
            "measurement",
            "effects",
            "model",
        ],
    ),
    ("codegen", &["error", "emit", "builder"]),
    (
        "identify",
        &[
            "words",
            "error",
            "watch",
            "logs",
            "robot",
            "stance",
            "evaluate",
            "simulate",
            "predict",
            "observations",
            "lsq",
            "fit",
            "plan",
            "diagnose",
        ],
    ),
    (
        "",
        &[
            "words", "error", "inspect", "verify", "report", "demo", "cli",
        ],
    ),
];

/// What each crate may depend on, besides its tests.
const CRATES: [(&str, &[&str]); 6] = [
    ("model", &[]),
    ("runtime", &[]),
    ("codegen", &["model"]),
    ("identify", &["model", "runtime"]),
    ("reference", &[]),
    ("generated", &["runtime"]),
];

/// Files of a folder and its folders that are not tests.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem == "tests" || stem.ends_with("_tests") || stem == "bin" {
            continue;
        }
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Text without comments and without what `#[cfg(test)]` begins, lines kept.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod").next().unwrap_or(text);
    let lines = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(line));
    lines.collect::<Vec<_>>().join("\n")
}

/// The name at the beginning of `text`.
fn name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// First names of what stands in braces: `a::b, c::{d, e}, f` gives a, c, f.
fn listed(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut names) = (0, 0, Vec::new());
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                names.push(name(text[start..at].trim_start()));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                names.push(name(text[start..at].trim_start()));
                start = at + 1;
            }
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

/// Line and first name of every `crate::…`.
fn imports(code: &str) -> Vec<(usize, &str)> {
    let paths = code.match_indices("crate::").filter(|(at, _)| {
        let before = code[..*at].chars().next_back();
        // `$crate::` is of whoever calls the macro.
        before.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != '$')
    });
    paths
        .flat_map(|(at, path)| {
            let line = code[..at].matches('\n').count() + 1;
            let rest = &code[at + path.len()..];
            let names = match rest.strip_prefix('{') {
                Some(list) => listed(list),
                None => vec![name(rest)],
            };
            names.into_iter().map(move |name| (line, name))
        })
        .collect()
}

/// Names that `lib.rs` passes on, and the room each comes from.
fn passed_on(lib: &str) -> BTreeMap<&str, &str> {
    let mut rooms = BTreeMap::new();
    for (at, words) in lib.match_indices("pub use ") {
        let statement = lib[at + words.len()..].split(';').next().unwrap_or("");
        let room = name(statement);
        let names = statement[room.len()..].split(|c: char| !c.is_alphanumeric() && c != '_');
        rooms.extend(
            names
                .filter(|name| !name.is_empty())
                .map(|name| (name, room)),
        );
    }
    rooms
}

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let mut complaints = String::new();
    for (member, rooms) in ROOMS {
        let src = Path::new(ROOT).join(member).join("src");
        let lib = code(&fs::read_to_string(src.join("lib.rs")).unwrap());
        let passed_on = passed_on(&lib);
        let place = |room: &str| rooms.iter().position(|known| *known == room);
        let mut files = Vec::new();
        sources(&src, &mut files);
        files.sort();
        for file in files {
            let inside = file.strip_prefix(&src).unwrap();
            let first = Path::new(inside.iter().next().unwrap());
            let room = first.file_stem().unwrap().to_str().unwrap();
            if inside == first && (room == "lib" || room == "main") {
                continue;
            }
            let shown = file.strip_prefix(ROOT).unwrap().display();
            let Some(here) = place(room) else {
                let _ = writeln!(
                    complaints,
                    "{shown}: give `{room}` a place in tests/layers.rs"
                );
                continue;
            };
            let text = code(&fs::read_to_string(&file).unwrap());
            for (line, name) in imports(&text) {
                let from = passed_on.get(name).copied().unwrap_or(name);
                if place(from).is_some_and(|there| there > here) {
                    let _ = writeln!(
                        complaints,
                        "{shown}:{line}: `{room}` imports `{from}`, which comes after it"
                    );
                }
            }
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
}

#[test]
fn crates_depend_on_each_other_as_drawn() {
    for (member, allowed) in CRATES {
        let path = format!("{ROOT}/{member}/Cargo.toml");
        let manifest: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        let dependencies = manifest.get("dependencies").and_then(|d| d.as_table());
        for dependency in dependencies.into_iter().flatten().map(|(name, _)| name) {
            if let Some(ours) = dependency.strip_prefix("sesc-") {
                assert!(
                    allowed.contains(&ours),
                    "{path}: {member} may not depend on {ours}"
                );
            }
        }
    }
}

#[test]
fn imports_are_found_in_every_form() {
    let text = code(
        "use crate::a::B; // crate::comment\nuse crate::{c, d::{E, F},\n    g};\n\
         fn h() { crate::i::j() }\n$crate::k;\n#[cfg(test)]\nmod tests { use crate::l; }",
    );
    let found = [(1, "a"), (2, "c"), (2, "d"), (2, "g"), (4, "i")];
    assert_eq!(imports(&text), found);
}
