//! Functions run on sets of instructions that the processor was asked for, and on no others.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use crate::ROOT;

/// Files with functions that are compiled for a set, and the file that asks for it.
const ASKED: [(&str, &str); 3] = [
    (
        "runtime/src/simd/x86/avx2.rs",
        "runtime/src/simd/x86/mod.rs",
    ),
    (
        "runtime/src/simd/x86/avx512.rs",
        "runtime/src/simd/x86/mod.rs",
    ),
    ("model/src/wide.rs", "model/src/wide.rs"),
];

/// Sets that the compiler may use where it may use `enabled`, beyond those of every x86-64.
fn implied(enabled: &str) -> BTreeSet<String> {
    let plus: Vec<String> = enabled.split(',').map(|set| format!("+{set}")).collect();
    let output = Command::new("rustc")
        .args(["--print", "cfg", "--target", "x86_64-unknown-linux-gnu"])
        .arg(format!("-Ctarget-feature={}", plus.join(",")))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let sets = text.lines().filter_map(|line| {
        let set = line.strip_prefix("target_feature=\"")?;
        set.strip_suffix('"').map(str::to_string)
    });
    // SSE and AVX come with AVX2: the standard library answers yes to AVX2 only where the
    // system saves the registers of AVX.
    sets.filter(|set| set != "avx" && !set.starts_with("sse") && !set.starts_with("ssse"))
        .filter(|set| set != "fxsr" && set != "x87")
        .collect()
}

#[test]
fn the_processor_is_asked_for_all_that_the_compiler_may_use() {
    let mut seen = 0;
    for (compiled, asking) in ASKED {
        let text = fs::read_to_string(format!("{ROOT}/{compiled}")).unwrap();
        let asking = fs::read_to_string(format!("{ROOT}/{asking}")).unwrap();
        for begun in text.split("#[target_feature(enable = \"").skip(1) {
            let enabled = begun.split('"').next().unwrap();
            let implied = implied(enabled);
            assert!(implied.contains("avx2"), "{enabled}: {implied:?}");
            for set in implied {
                let asked = ["is_x86_feature_detected!", "has!"]
                    .iter()
                    .any(|macro_| asking.contains(&format!("{macro_}(\"{set}\")")));
                assert!(
                    asked,
                    "{compiled}: {enabled} implies {set}, which nobody asks for"
                );
            }
            seen += 1;
        }
    }
    assert!(seen >= 6, "{seen}");
}
