//! Every public item has an example, and `cargo test --doc` runs it.

use std::fs;
use std::path::Path;

#[path = "../../tests/it/common/examples.rs"]
mod examples;

use examples::bare;

/// Files whose items can be named from outside.
const PUBLIC: [&str; 17] = [
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
    "simd/many.rs",
    "simd/mod.rs",
    "simd/single.rs",
    "trig/double.rs",
    "trig/single.rs",
];

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
