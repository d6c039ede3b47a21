//! Public faces can grow: enums and options are `#[non_exhaustive]`, and no type of
//! another library stands where a caller would have to name it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use crate::imports::code;

/// Crates that are published as libraries.
const LIBRARIES: [&str; 4] = ["model", "runtime", "codegen", "identify"];

/// Enums of which every use must decide when a case is added, as CONTRIBUTING.md says.
const DECIDED: [&str; 22] = [
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
    "Twist",
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

/// Types of other libraries, as our sources spell them.
const FOREIGN: [&str; 15] = [
    "DMatrix<",
    "DVector<",
    "SMatrix<",
    "SVector<",
    "Matrix2<",
    "Matrix3<",
    "Vector2<",
    "Vector3<",
    "Isometry3<",
    "Cholesky<",
    "urdf_rs::",
    "roxmltree::",
    "toml::",
    "serde_json::",
    "parquet::",
];

/// Whether an attribute asks for matrices.
fn is_gate(attributes: &str) -> bool {
    attributes.contains("feature = \"nalgebra\"") && !attributes.contains("not(")
}

/// A file whose items are named from outside.
struct Face {
    file: PathBuf,
    text: String,
    /// Whether items are named by the module's own path; else they are passed on one by one.
    whole: bool,
}

/// Files of modules that can be named from outside without a feature of matrices, and of
/// private ones that items are passed on from.
fn public_files(file: &Path, whole: bool, found: &mut Vec<Face>) {
    let text = code(&fs::read_to_string(file).unwrap());
    let stem = file.file_stem().unwrap().to_str().unwrap();
    let folder = match stem {
        "lib" | "mod" => file.parent().unwrap().to_path_buf(),
        _ => file.with_extension(""),
    };
    let mut gated = false;
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
            public_files(if flat.exists() { &flat } else { &deep }, whole, found);
        }
        gated = match line.starts_with("#[") {
            true => gated || line.contains("nalgebra") || line == "#[cfg(test)]",
            false => false,
        };
    }
    found.push(Face {
        file: file.to_path_buf(),
        text,
        whole,
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

fn faces() -> Vec<Face> {
    let mut found = Vec::new();
    for member in LIBRARIES {
        let lib = Path::new(crate::ROOT).join(member).join("src/lib.rs");
        let mut own = Vec::new();
        public_files(&lib, true, &mut own);
        for file in passed_on(member, &own) {
            if own.iter().all(|face| face.file != file) {
                public_files(&file, false, &mut own);
            }
        }
        found.append(&mut own);
    }
    found
}

/// Public items of a text, each from `pub` to its body, with the attributes before it.
fn items(text: &str) -> Vec<(String, String)> {
    let mut items = Vec::new();
    let (mut attributes, mut lines) = (String::new(), text.lines());
    while let Some(line) = lines.next() {
        if is_gate(&attributes) && line.ends_with(" {") && !line.starts_with(' ') {
            lines.find(|line| *line == "}");
        }
        let line = line.trim();
        if line.starts_with("#[") {
            attributes += line;
            continue;
        }
        if line.starts_with("pub ")
            && !line.starts_with("pub mod ")
            && !line.starts_with("pub use ")
        {
            let mut item = line.to_string();
            while !item.contains(['{', ';']) && !item.ends_with(',') {
                let Some(more) = lines.next() else { break };
                item += more.trim();
            }
            items.push((attributes.clone(), item));
        }
        if !line.is_empty() {
            attributes.clear();
        }
    }
    items
}

#[test]
fn enums_and_options_can_grow() {
    let (mut complaints, mut decided) = (String::new(), BTreeSet::new());
    for Face { file, text, .. } in faces() {
        for (attributes, item) in items(&text) {
            let named = |kind: &str| {
                let name = item.strip_prefix("pub ")?.strip_prefix(kind)?;
                let end = name.find(|c: char| !c.is_alphanumeric())?;
                Some(name[..end].to_string())
            };
            let of_options = named("struct ").filter(|name| OPTIONS.contains(&name.as_str()));
            let Some(name) = named("enum ").or(of_options) else {
                continue;
            };
            if DECIDED.contains(&name.as_str()) {
                decided.insert(name);
            } else if !attributes.contains("non_exhaustive") {
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
    let mut complaints = String::new();
    for Face { file, text, .. } in faces().into_iter().filter(|face| face.whole) {
        for (attributes, item) in items(&text) {
            // What stands behind `pub(crate)` in a tuple is not named outside.
            let signature = item.split('{').next().unwrap();
            let signature = signature.split("(pub(crate)").next().unwrap();
            let foreign = FOREIGN.iter().any(|foreign| signature.contains(foreign));
            if foreign && !is_gate(&attributes) {
                let _ = writeln!(complaints, "{}: {signature}", file.display());
            }
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
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
fn what_cannot_grow_and_foreign_types_are_seen() {
    let text = "#[derive(Debug)]\npub enum Open {\n}\n/// Rows.\npub fn rows(\n    of: &DMatrix<f64>,\n) -> f64 {\n}\n";
    let found = items(text);
    assert_eq!(
        found[0],
        (
            "#[derive(Debug)]".to_string(),
            "pub enum Open {".to_string()
        )
    );
    assert!(found[1].1.contains("DMatrix<"), "{found:?}");
}
