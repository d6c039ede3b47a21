//! Public faces can grow: enums and options are `#[non_exhaustive]`, and no type of
//! another library stands in what the documentation shows, wherever it is declared.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::imports::code;
use crate::signatures::{Signature, imported, is_hidden, signatures};

/// Crates that are published as libraries.
/// The root package is "".
const LIBRARIES: [&str; 6] = ["model", "runtime", "codegen", "identify", "reference", ""];

/// Enums of which every use must decide when a case is added, as CONTRIBUTING.md says.
const DECIDED: [&str; 21] = [
    // Functions, what they are given, and how far their rows reach.
    "Function",
    "Given",
    "Extent",
    "Experiment",
    "Carry",
    // How a joint moves, and what a tick of it is.
    "Motion",
    "Scale",
    "Step",
    // Arithmetic and its proofs.
    "Precision",
    "Quantity",
    "Unfit",
    "Expr",
    "Shape",
    "Column",
    // Text in the making, of emitters alone.
    "Line",
    "Results",
    "Strength",
    // What comes out.
    "Change",
    "StageKind",
    "Values",
    "Verdict",
];

/// Structs that say how something is to be done.
const OPTIONS: [&str; 4] = ["Options", "Settings", "Request", "Tolerances"];

/// Libraries whose types may stand in signatures: results are written with serde's traits.
const ALLOWED: [&str; 1] = ["serde"];

/// A file whose items are named from outside.
struct Face {
    file: PathBuf,
    text: String,
    /// Whether documentation shows the module's path; else items are passed on one by one, or
    /// not at all.
    shown: bool,
}

/// Files of modules that can be named from outside without a feature of matrices, and of
/// private ones that items are passed on from. `whole`: items are named by the module's own
/// path; `shown`: documentation has it.
fn public_files(file: &Path, (whole, shown): (bool, bool), found: &mut Vec<Face>) {
    let text = code(&fs::read_to_string(file).unwrap());
    let stem = file.file_stem().unwrap().to_str().unwrap();
    let folder = match stem {
        "lib" | "mod" => file.parent().unwrap().to_path_buf(),
        _ => file.with_extension(""),
    };
    let (mut gated, mut hidden) = (false, false);
    for line in text.lines().map(str::trim) {
        let module = line.strip_suffix(';').and_then(|line| {
            let named = line.strip_prefix("pub mod ").map(|name| (name, whole));
            named.or(line.strip_prefix("mod ").map(|name| (name, false)))
        });
        if let Some((name, whole)) = module
            && !gated
            && (whole || text.contains(&format!("pub use {name}::")))
        {
            let flat = folder.join(format!("{name}.rs"));
            let deep = folder.join(name).join("mod.rs");
            let file = if flat.exists() { &flat } else { &deep };
            public_files(file, (whole, shown && whole && !hidden), found);
        }
        (gated, hidden) = match line.starts_with("#[") {
            true => (
                gated || line.contains("nalgebra") || line == "#[cfg(test)]",
                hidden || is_hidden(line),
            ),
            false => (false, false),
        };
    }
    found.push(Face {
        file: file.to_path_buf(),
        text,
        shown,
    });
}

/// Files that items are passed on from by `pub use crate::…`.
fn passed_on(member: &str, faces: &[Face]) -> Vec<PathBuf> {
    let src = Path::new(crate::ROOT).join(member).join("src");
    let paths = faces.iter().flat_map(|face| {
        let uses = face.text.split("pub use crate::").skip(1);
        uses.map(|rest| rest.split([';', '{']).next().unwrap())
    });
    let file = |path: &str| {
        let mut found = None;
        let mut folder = src.clone();
        for name in path.split("::") {
            let candidates = [
                folder.join(format!("{name}.rs")),
                folder.join(name).join("mod.rs"),
            ];
            found = candidates.into_iter().find(|file| file.exists()).or(found);
            folder.push(name);
        }
        found.unwrap_or_else(|| panic!("`pub use crate::{path}` names no file below {src:?}"))
    };
    paths.map(file).collect()
}

fn faces_of(member: &str) -> Vec<Face> {
    let lib = Path::new(crate::ROOT).join(member).join("src/lib.rs");
    let mut own = Vec::new();
    public_files(&lib, (true, true), &mut own);
    for file in passed_on(member, &own) {
        if own.iter().all(|face| face.file != file) {
            public_files(&file, (false, false), &mut own);
        }
    }
    own
}

fn faces() -> Vec<Face> {
    LIBRARIES.into_iter().flat_map(faces_of).collect()
}

/// Names that documentation shows because a shown module passes them on.
fn passed_on_by_name(faces: &[Face]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for face in faces.iter().filter(|face| face.shown) {
        for Signature { hidden, text, .. } in signatures(&face.text) {
            let Some(path) = text.strip_prefix("pub use ").filter(|_| !hidden) else {
                continue;
            };
            let words = path.split(|c: char| !c.is_alphanumeric() && c != '_');
            names.extend(words.filter(|word| !word.is_empty()).map(str::to_string));
        }
    }
    names
}

/// Signatures of a library that documentation shows with types of other libraries.
fn foreign_types(member: &str) -> Vec<String> {
    let manifest = Path::new(crate::ROOT).join(member).join("Cargo.toml");
    let manifest = fs::read_to_string(manifest).unwrap();
    let sections = manifest
        .split("\n[")
        .filter(|part| part.starts_with("dependencies]"));
    let keys = sections.flat_map(|part| part.lines().skip(1));
    let libraries: Vec<String> = keys
        .filter_map(|line| Some(line.split_once(['=', '.'])?.0.trim().replace('-', "_")))
        .filter(|name| !name.starts_with("sesc") && !ALLOWED.contains(&name.as_str()))
        .collect();
    let faces = faces_of(member);
    let passed_on = passed_on_by_name(&faces);
    let mut found = Vec::new();
    for face in &faces {
        let foreign = imported(&face.text, &libraries);
        for signature in signatures(&face.text) {
            let shown = face.shown || passed_on.contains(&signature.owner);
            if shown && !signature.hidden && signature.names_one_of(&foreign, &libraries) {
                found.push(format!("{}: {}", face.file.display(), signature.text));
            }
        }
    }
    found
}

/// Public enums and options of a text that are not `#[non_exhaustive]`.
fn cannot_grow(text: &str) -> Vec<String> {
    let grows = |item: &Signature| item.attributes.contains("non_exhaustive");
    let is_one = |item: &Signature| {
        item.text.starts_with("pub enum ")
            || item.text.starts_with("pub struct ") && OPTIONS.contains(&item.owner.as_str())
    };
    let items = signatures(text).into_iter();
    items
        .filter(|item| is_one(item) && !grows(item))
        .map(|item| item.owner)
        .collect()
}

#[test]
fn enums_and_options_can_grow() {
    let (mut complaints, mut decided) = (String::new(), BTreeSet::new());
    for Face { file, text, .. } in faces() {
        for name in cannot_grow(&text) {
            if DECIDED.contains(&name.as_str()) {
                decided.insert(name);
            } else {
                let _ = writeln!(complaints, "{}: `{name}`", file.display());
            }
        }
    }
    assert!(
        complaints.is_empty(),
        "not #[non_exhaustive]:\n{complaints}"
    );
    let unused = DECIDED.iter().filter(|name| !decided.contains(**name));
    assert_eq!(unused.count(), 0, "there are only {decided:?}");
}

#[test]
fn no_signature_has_a_type_of_another_library() {
    let found: Vec<String> = LIBRARIES.into_iter().flat_map(foreign_types).collect();
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn what_is_passed_on_and_what_stands_below_tests_is_looked_at() {
    let faces = faces();
    let has = |file: &str, text: &str| {
        let mut faces = faces.iter();
        faces.any(|face| face.file.ends_with(file) && face.text.contains(text))
    };
    assert!(has(
        "identify/src/observations/motion_use.rs",
        "pub enum MotionModel"
    ));
    assert!(has("identify/src/skeleton/mod.rs", "pub enum Part"));
}

#[test]
fn errors_of_the_root_and_joints_of_the_reference_are_looked_at() {
    let root = faces_of("");
    assert!(root.iter().any(|face| face.text.contains("pub enum Error")));
    let reference = faces_of("reference");
    let joint = reference
        .iter()
        .find(|face| face.text.contains("enum JointKind"));
    let text = joint.unwrap().text.replace("#[non_exhaustive]", "");
    assert_eq!(cannot_grow(&text), ["JointKind"]);
}
