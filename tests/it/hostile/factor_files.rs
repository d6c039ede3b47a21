//! Factor files of `fit` whose numbers and texts were changed: answered or refused.

use std::fmt::Write as _;
use std::fs;
use std::io::Read as _;

use sesc_test_support::command::{folder, refused, sesc, stdout};

use super::values::{soon, two_link};

/// Every number and text of a factor file, changed one by one.
#[test]
fn factor_files_that_were_changed_are_answered_or_refused() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (log, part) = (path("log.csv"), path("a.part"));
    let urdf = two_link();
    let robot = [urdf.as_str(), "--support", "foot"];
    let simulate = ["--poses", "30", "--noise", "0.0005", "--out", &log];
    stdout(&sesc(&[&["simulate"], &robot[..], &simulate].concat()));
    let fit = [
        "fit",
        &two_link(),
        "--data",
        &log,
        "--folds",
        "2",
        "--partial",
        &part,
    ];
    stdout(&sesc(&fit));
    // The header, packed by gzip, and the numbers behind it.
    let bytes = fs::read(&part).unwrap();
    let mut packed = flate2::bufread::GzDecoder::new(&bytes[..]);
    let mut header = String::new();
    packed.read_to_string(&mut header).unwrap();
    let numbers = packed.into_inner();
    let whole: serde_json::Value = serde_json::from_str(&header).unwrap();
    let part_of = |header: &serde_json::Value| {
        let bytes = [header.to_string().as_bytes(), b"\n", numbers].concat();
        let path = path("b.part");
        fs::write(&path, bytes).unwrap();
        path
    };
    let mut places = Vec::new();
    walk(&whole, &mut String::new(), &mut places);
    assert!(places.len() > 50, "{}", places.len());
    let mut tried = 0;
    for place in &places {
        let values: &[&str] = match whole.pointer(place).unwrap() {
            serde_json::Value::String(_) => &["\"nope\"", "\"\\u001b]0;x\\u0007\""],
            serde_json::Value::Number(_) => &["0", "-1", "1e308", "1e-308", "18446744073709551615"],
            _ => &["[]"],
        };
        // Each place once here, in turn by every value: the library's fuzzers do the rest.
        for value in values {
            let mut changed = whole.clone();
            *changed.pointer_mut(place).unwrap() = serde_json::from_str(value).unwrap();
            let changed = part_of(&changed);
            let output = soon(&["fit", &changed]);
            let message = String::from_utf8_lossy(&output.stderr);
            let code = output.status.code();
            assert!(matches!(code, Some(0..=2)), "{place} {value}: {message}");
            assert!(!message.contains('\u{1b}'), "{place}: {message:?}");
            tried += 1;
        }
    }
    assert!(tried > 60);
    // A mass inside, and nothing else.
    let mut changed = whole.clone();
    let urdf = changed["urdf"]
        .as_str()
        .unwrap()
        .replacen("mass value=\"", "mass value=\"1", 1);
    changed["urdf"] = urdf.into();
    let changed = part_of(&changed);
    refused(&sesc(&["fit", &changed]), &["URDF in a factor file"]);
    let mut changed = whole;
    changed["supports"] = serde_json::json!(["nope"]);
    let changed = part_of(&changed);
    refused(&sesc(&["fit", &changed]), &["`nope`"]);
    // Numbers that are none, and too few of them.
    let mut odd = bytes.clone();
    let last = odd.len() - 8;
    odd[last..].copy_from_slice(&f64::INFINITY.to_le_bytes());
    for bytes in [&odd[..], &bytes[..bytes.len() - 3]] {
        fs::write(path("b.part"), bytes).unwrap();
        refused(
            &sesc(&["fit", &path("b.part")]),
            &["b.part", "gather the log again"],
        );
    }
}

/// JSON pointers to everything that can be changed; long lists by their first entries.
fn walk(value: &serde_json::Value, at: &mut String, places: &mut Vec<String>) {
    let children: Vec<(String, &serde_json::Value)> = match value {
        serde_json::Value::Object(map) => map.iter().map(|(k, v)| (k.clone(), v)).collect(),
        serde_json::Value::Array(all) => {
            places.push(at.clone());
            all.iter()
                .take(3)
                .enumerate()
                .map(|(k, v)| (k.to_string(), v))
                .collect()
        }
        serde_json::Value::Number(_) | serde_json::Value::String(_) => {
            places.push(at.clone());
            return;
        }
        _ => return,
    };
    for (key, child) in children {
        let length = at.len();
        let _ = write!(at, "/{key}");
        walk(child, at, places);
        at.truncate(length);
    }
}
