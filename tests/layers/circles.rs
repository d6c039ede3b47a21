//! No files import each other in a circle. A file and the files of its folder count as
//! one thought: they may name each other.

use std::collections::BTreeMap;
use std::path::Path;

use crate::ROOT;
use crate::imports::Files;

/// Circles, one of each group at least, as `a → b → a`.
fn circles(files: &Files) -> Vec<String> {
    let within = |outer: &str, inner: &str| {
        outer.is_empty()
            || inner
                .strip_prefix(outer)
                .is_some_and(|rest| rest.starts_with("::"))
    };
    let mut imports = BTreeMap::new();
    for module in files.modules() {
        let mut all: Vec<&str> = files.imports(module).into_iter().map(|(_, m)| m).collect();
        all.retain(|other| !within(module, other) && !within(other, module));
        imports.insert(module, all);
    }
    let (mut done, mut way, mut found) = (Vec::new(), Vec::new(), Vec::new());
    for module in files.modules() {
        walk(module, &imports, &mut done, &mut way, &mut found);
    }
    found
}

fn walk<'a>(
    module: &'a str,
    imports: &BTreeMap<&'a str, Vec<&'a str>>,
    done: &mut Vec<&'a str>,
    way: &mut Vec<&'a str>,
    found: &mut Vec<String>,
) {
    if let Some(start) = way.iter().position(|before| *before == module) {
        found.push(format!("{} → {module}", way[start..].join(" → ")));
        return;
    }
    if done.contains(&module) {
        return;
    }
    way.push(module);
    for next in &imports[module] {
        walk(next, imports, done, way, found);
    }
    way.pop();
    done.push(module);
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut complaints = Vec::new();
    for member in [
        "",
        "model",
        "codegen",
        "runtime",
        "identify",
        "reference",
        "xtask",
        "benches/robots",
        "benches/peers/rust/measure",
        "tests/support",
        "tests/support",
    ] {
        let files = Files::read(&Path::new(ROOT).join(member).join("src"));
        let all = circles(&files).into_iter();
        complaints.extend(all.map(|circle| format!("{member}/src: {circle}")));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn circles_are_found() {
    let files = Files::of(&[
        ("", "mod a; mod b; mod c; pub use c::C;"),
        ("a", "use crate::b::B;"),
        ("b", "use super::C;"),
        ("c", "fn c() { d::e(); crate::a::f() }"),
        ("c::d", "use super::C;"),
    ]);
    assert_eq!(circles(&files), ["a → b → c → a"]);
}
