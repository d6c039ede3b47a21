//! Every public item has an example, and `cargo test --doc` runs them.

use std::fs;
use std::path::Path;

#[path = "../../tests/it/common/examples.rs"]
mod examples;

use examples::bare;

/// Files whose items can be named from outside.
const PUBLIC: [&str; 3] = ["builder.rs", "error.rs", "emit/c/servos.rs"];

/// Types that can be named from outside, in files of which the rest cannot.
const TYPES: [(&str, &str); 2] = [
    ("emit/c/mod.rs", "pub enum Scalar {"),
    ("emit/c/layout.rs", "pub enum Layout {"),
];

#[test]
fn every_public_item_has_an_example() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let of = |file: &str| fs::read_to_string(src.join(file)).unwrap();
    let mut missing: Vec<String> = PUBLIC.iter().flat_map(|file| bare(&of(file))).collect();
    for (file, item) in TYPES {
        let text = of(file);
        assert!(text.lines().any(|line| line == item), "{file}: {item}");
        missing.extend(bare(&text).into_iter().filter(|bare| bare == item));
    }
    assert!(missing.is_empty(), "{missing:#?}");
}
