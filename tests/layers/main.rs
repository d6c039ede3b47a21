//! Data walks one way: within each crate a room imports only from rooms that stand
//! before it, crates depend on each other only as ARCHITECTURE.md draws them, and no
//! files import each other in a circle.
//!
//! A stage that needs something of a later one is a sign that the thing stands in the
//! wrong room: move the thing, not the import.

mod circles;
mod criteria;
mod faces;
mod imports;
mod instructions;
mod options;
mod signatures;
mod strings;
mod words;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use imports::Files;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Rooms of each crate, files or folders of `src/`, first to last.
const ROOMS: [(&str, &[&str]); 5] = [
    (
        "model",
        &[
            "text",
            "spelling",
            "hash",
            "stamp",
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
            "inertia",
            "expr",
            "program",
            "bounds",
            "wide",
            "tape",
            "interface",
            "functions",
            "measurement",
            "effects",
            "model",
        ],
    ),
    (
        "codegen",
        &["error", "routines", "facts", "emit", "sources", "builder"],
    ),
    (
        "identify",
        &[
            "words",
            "next_steps",
            "error",
            "watch",
            "threads",
            "svd",
            "logs",
            "robot",
            "stance",
            "poses",
            "hide",
            "evaluate",
            "tolerances",
            "observations",
            "feet",
            "simulate",
            "predict",
            "health",
            "lsq",
            "fit",
            "plan",
            "skeleton",
            "diagnose",
            "compare",
            "fleet",
        ],
    ),
    (
        "python",
        &[
            "errors",
            "calls",
            "batch",
            "arrays",
            "arrow",
            "robot",
            "prepared",
            "model",
            "checks",
            "drawing",
            "log",
            "options",
            "code",
            "part",
            "fit",
            "diagnosis",
            "postures",
            "fleet",
            "command",
        ],
    ),
    (
        "",
        &[
            "words", "error", "inspect", "verify", "servos", "report", "demo", "cli",
        ],
    ),
];

/// What each crate may depend on, besides its tests.
const CRATES: [(&str, &[&str]); 7] = [
    ("model", &[]),
    ("runtime", &[]),
    ("codegen", &["model"]),
    ("identify", &["model", "runtime"]),
    ("python", &["model", "codegen", "identify"]),
    ("reference", &[]),
    ("generated", &["runtime"]),
];

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let mut complaints = String::new();
    for (member, rooms) in ROOMS {
        let files = Files::read(&Path::new(ROOT).join(member).join("src"));
        let place = |room: &str| rooms.iter().position(|known| *known == room);
        for module in files.modules() {
            let room = module.split("::").next().unwrap_or("");
            if room.is_empty() || room == "bin" {
                continue;
            }
            let Some(here) = place(room) else {
                let _ = writeln!(complaints, "{member}/src: give `{room}` a place here");
                continue;
            };
            for (line, imported) in files.imports(module) {
                let from = imported.split("::").next().unwrap_or("");
                if place(from).is_some_and(|there| there > here) {
                    let _ = writeln!(
                        complaints,
                        "{member}/src, {module}, line {line}: `{room}` imports `{from}`, \
                         which comes after it"
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
