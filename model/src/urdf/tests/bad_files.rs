//! `tests/bad_urdf`: one fault each, with the complaint it must draw.

use std::path::{Path, PathBuf};

use super::super::*;

const BAD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/bad_urdf");

/// Complaints of the files that can hold no comment.
const WITHOUT_COMMENT: [(&str, &str); 8] = [
    ("binary", "binary.urdf: a binary file; give the URDF"),
    ("blank", "blank.urdf: the file is empty"),
    ("comment_alone", "comment_alone.urdf: no XML element"),
    ("empty", "empty.urdf: the file is empty"),
    (
        "latin1",
        "latin1.urdf:2: byte 0xf6 is not UTF-8; save the file as UTF-8",
    ),
    ("lfs_pointer", "lfs_pointer.urdf:1: a Git LFS pointer"),
    (
        "not_xml",
        "not_xml.urdf:1: not XML: it starts with `robot:`",
    ),
    ("utf16", "utf16.urdf: UTF-16 text; save it as UTF-8"),
];

/// What a file expects: `<!-- expect: 5: no child; 9: no parent; remedy -->`
/// lists complaints by line; a part without a line continues the one before.
fn expectations(path: &Path) -> Vec<String> {
    let stem = path.file_stem().unwrap().to_string_lossy();
    if let Some((_, expected)) = WITHOUT_COMMENT.iter().find(|(name, _)| *name == stem) {
        return vec![(*expected).to_owned()];
    }
    let text = std::fs::read_to_string(path).unwrap();
    let comment = text.lines().next().unwrap();
    let listed = comment
        .strip_prefix("<!-- expect: ")
        .and_then(|rest| rest.strip_suffix(" -->"))
        .unwrap_or_else(|| panic!("{}: begin with <!-- expect: ... -->", path.display()));
    let mut expected: Vec<String> = Vec::new();
    for part in listed.split("; ") {
        match expected.last_mut() {
            Some(last) if !part.starts_with(|c: char| c.is_ascii_digit()) => {
                last.push_str("; ");
                last.push_str(part);
            }
            _ => expected.push(format!("{stem}.urdf:{part}")),
        }
    }
    expected
}

#[test]
fn every_bad_file_hears_exactly_its_faults() {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(BAD)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    assert!(paths.len() >= 90, "{} files", paths.len());
    for path in paths {
        let Err(error) = read(&path) else {
            panic!("{}: was accepted", path.display());
        };
        let message = error.to_string();
        let expected = expectations(&path);
        assert_eq!(error.complaints().len(), expected.len(), "{message}");
        for (line, expected) in message.lines().zip(&expected) {
            assert!(line.contains(expected), "{line}\nlacks\n{expected}");
        }
    }
}
