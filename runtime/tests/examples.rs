//! Every public item has an example, and `cargo test --doc` runs it.

use std::fs;
use std::path::Path;

/// Files whose items can be named from outside.
const PUBLIC: [&str; 15] = [
    "dim.rs",
    "fit.rs",
    "fit/answers.rs",
    "fit/batch.rs",
    "fit/error.rs",
    "lanes.rs",
    "lib.rs",
    "model.rs",
    "power/mod.rs",
    "real.rs",
    "scalar.rs",
    "simd/batch.rs",
    "simd/mod.rs",
    "simd/single.rs",
    "trig/double.rs",
];

/// Items without an example in `text`: functions, types and traits, and what a trait offers.
fn bare(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    // The documentation and attributes of the item to come.
    let (mut documented, mut hidden) = (false, false);
    for line in text.lines().take_while(|line| *line != "mod tests {") {
        let code = line.trim_start();
        if code.starts_with("///") || code.starts_with("#[") {
            documented |= code.starts_with("/// ```");
            hidden |= code == "#[doc(hidden)]";
            continue;
        }
        let kinds = ["fn ", "const fn ", "struct ", "enum ", "trait "];
        let public = code.strip_prefix("pub ");
        let item = public.is_some_and(|item| kinds.iter().any(|kind| item.starts_with(kind)));
        if item && !documented && !hidden {
            found.push(code.to_string());
        }
        if !code.starts_with("//") {
            (documented, hidden) = (false, false);
        }
    }
    found
}

#[test]
fn every_public_item_has_an_example() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut missing = Vec::new();
    for file in PUBLIC {
        let text = fs::read_to_string(src.join(file)).unwrap();
        // Private modules inside a file.
        let public = text.split("mod sealed {").next().unwrap();
        missing.extend(bare(public).iter().map(|item| format!("{file}: {item}")));
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn an_item_without_an_example_is_found() {
    let text =
        "/// Sums.\npub fn a() {}\n/// ```\n/// ```\npub fn b() {}\n#[doc(hidden)]\npub fn c() {}";
    assert_eq!(bare(text), ["pub fn a() {}"]);
}
