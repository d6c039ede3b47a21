//! Factor files of `fit` whose numbers and texts were changed: answered or refused.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::time::{Duration, Instant};

use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use sesc_test_support::command::{Folder, stderr};

/// Every number and text of a factor file, changed one by one.
#[test]
fn factor_files_that_were_changed_are_answered_or_refused() {
    let folder = Folder::with("two_link");
    folder.stdout("simulate two_link.urdf --support foot --poses 30 --noise 0.0005 --out log.csv");
    folder.stdout("fit two_link.urdf --data log.csv --folds 2 --partial a.part");
    let bytes = fs::read(folder.join("a.part")).unwrap();
    let whole: serde_json::Value = serde_json::from_reader(GzDecoder::new(&bytes[..])).unwrap();
    let write = |changed: &serde_json::Value| {
        let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
        packed.write_all(changed.to_string().as_bytes()).unwrap();
        folder.write("b.part", packed.finish().unwrap());
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
            write(&changed);
            let begun = Instant::now();
            let output = folder.run("fit b.part");
            assert!(begun.elapsed() < Duration::from_secs(20), "{place} {value}");
            let message = stderr(&output);
            let code = output.status.code();
            assert!(matches!(code, Some(0..=2)), "{place} {value}: {message}");
            assert!(!message.contains('\u{1b}'), "{place}: {message:?}");
            tried += 1;
        }
    }
    assert!(tried > 60);
    // A mass inside, and nothing else.
    let urdf = whole["urdf"].as_str().unwrap();
    let heavier = urdf.replacen("mass value=\"", "mass value=\"1", 1);
    for (key, value, word) in [
        ("urdf", heavier.into(), "URDF in a factor file"),
        ("supports", serde_json::json!(["nope"]), "`nope`"),
    ] {
        let mut changed = whole.clone();
        changed[key] = value;
        write(&changed);
        folder.refuses("fit b.part", &[word]);
    }
    // A byte that was changed, and bytes that are missing.
    let mut odd = bytes.clone();
    odd[bytes.len() / 2] ^= 1;
    for bytes in [&odd[..], &bytes[..bytes.len() - 3]] {
        folder.write("b.part", bytes);
        folder.refuses("fit b.part", &["b.part", "gather the log again"]);
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
