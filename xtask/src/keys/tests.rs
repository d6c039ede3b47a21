//! Keys of small sources.

use std::fs;

use super::*;

const ANSWER: &str = r#"
use crate::below::Row;

/// What is printed.
#[derive(Debug, Serialize)]
pub struct Answer<'a> {
    /// Its name.
    ///
    /// More of it.
    pub name: String,
    /// Lines ([`Row`]). None of [`crate::below::Row`] alone.
    #[serde(rename = "rows")]
    pub lines: &'a [Row],
    #[serde(flatten)]
    pub more: Option<More>,
    #[serde(skip)]
    pub hidden: fn(),
    /// Bounds by name.
    pub bounds: BTreeMap<String, f64>,
    /// Where it is.
    pub at: [Option<f64>; 2],
    /// Change.
    pub change: Changed<i32>,
}

#[derive(Serialize)]
struct More {
    /// Which way.
    way: Way,
    /// Where.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<[f64; 2]>,
}

#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum Way {
    /// Up.
    GoesUp,
    /// So far.
    Far(f64),
}

#[derive(Serialize)]
struct Changed<T> {
    /// What it was.
    before: T,
}
"#;
const ROW: &str = "/// A row.\n#[derive(Serialize)]\npub struct Row {\n    /// Its number.\n    \
                   pub number: Option<u64>,\n}\n";

fn keys(answer: &str) -> Result<Vec<Key>, String> {
    let root = tempfile::tempdir().unwrap();
    for folder in ["model/src", "codegen/src", "identify/src", "src"] {
        fs::create_dir_all(root.path().join(folder)).unwrap();
    }
    fs::write(root.path().join("src/answer.rs"), answer).unwrap();
    fs::write(root.path().join("src/below.rs"), ROW).unwrap();
    // Another type of that name, elsewhere.
    fs::write(root.path().join("src/other.rs"), ROW.replace("number", "n")).unwrap();
    Keys::read(root.path(), "object")?.of(("src/answer.rs", "Answer"))
}

#[test]
fn keys_are_those_that_serde_writes() {
    let found = keys(ANSWER).unwrap();
    let found: Vec<[&str; 3]> = found
        .iter()
        .map(|key| [key.path.as_str(), key.value.as_str(), key.meaning.as_str()])
        .collect();
    assert_eq!(
        found,
        [
            ["name", "text", "Its name"],
            ["rows", "list of objects", "Lines. None of `Row` alone."],
            ["rows[].number", "whole number, or `null`", "Its number"],
            ["way", "`goes_up`, or an object", "Which way"],
            ["way.far", "number", "So far"],
            ["place", "list of 2 numbers, where there is one", "Where"],
            ["bounds.*", "number", "Bounds by name"],
            ["at", "list of 2 numbers or `null`", "Where it is"],
            ["change", "object", "Change"],
            ["change.before", "number", "What it was"],
        ]
    );
}

#[test]
fn a_key_without_a_meaning_is_an_error() {
    let bare = ANSWER.replace("    /// Bounds by name.\n", "");
    assert_eq!(
        keys(&bare).unwrap_err(),
        "Answer.bounds: has no documentation"
    );
}
