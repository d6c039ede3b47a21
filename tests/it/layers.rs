//! Data walks one way: within each crate a room imports only from rooms that stand before it,
//! crates depend on each other only as ARCHITECTURE.md draws them, and nothing imports in a circle.
//!
//! A stage that needs something of a later one is a sign that the thing stands in the wrong room:
//! move the thing, not the import.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Rooms of each crate, files or folders of `src/`, first to last.
const ROOMS: [(&str, &str); 5] = [
    (
        "model",
        "text spelling hash stamp urdf error files snap names tree chain frames numeric \
         base robot standard inertia expr formula program bounds wide tape interface functions \
         measurement effects model",
    ),
    ("codegen", "error routines facts seen emit sources builder"),
    (
        "identify",
        "words error watch files threads svd logs robot poses evaluate \
         tolerances observations feet simulate predict health lsq fit plan skeleton \
         diagnose compare fleet",
    ),
    (
        "python",
        "errors calls batch arrays arrow robot prepared steps model checks drawing log \
         options code part fit diagnosis postures fleet command",
    ),
    ("", "words error inspect verify servos report demo cli"),
];

/// What each crate may depend on, besides its tests.
const CRATES: [(&str, &[&str]); 7] = [
    ("model", &[]),
    ("runtime", &[]),
    ("codegen", &["model"]),
    ("identify", &["model", "runtime"]),
    ("python", &["model", "codegen", "identify"]),
    ("reference", &[]),
    ("generated", &["runtime"]),
];

/// Crates of the workspace whose files import in no circle.
const WITHOUT_CIRCLES: [&str; 9] = [
    "",
    "model",
    "codegen",
    "runtime",
    "identify",
    "reference",
    "python",
    "xtask",
    "tests/support",
];

/// Paths that the files of a crate name, apart from tests, by module: `urdf::scan`, and the empty
/// name for `lib.rs` or `main.rs`.
type Files = BTreeMap<String, Vec<Named>>;

/// A path in a text: `crate::a::B`.
struct Named {
    line: usize,
    names: Vec<String>,
    /// `pub use`.
    public: bool,
}

#[test]
fn rooms_import_only_from_rooms_before_them() {
    let mut complaints = String::new();
    for (member, rooms) in ROOMS {
        let files = read(member);
        let rooms: Vec<&str> = rooms.split_whitespace().collect();
        let place = |room: &str| rooms.iter().position(|known| *known == room);
        for module in files.keys() {
            let room = module.split("::").next().unwrap_or("");
            if room.is_empty() || room == "bin" {
                continue;
            }
            let Some(here) = place(room) else {
                let _ = writeln!(complaints, "{member}/src: give `{room}` a place here");
                continue;
            };
            for (line, imported) in imports(&files, module) {
                let from = imported.split("::").next().unwrap_or("");
                if place(from).is_some_and(|there| there > here) {
                    let _ = writeln!(
                        complaints,
                        "{member}/src, {module}, line {line}: `{room}` imports `{from}`, \
                         which comes after it"
                    );
                }
            }
        }
    }
    assert!(complaints.is_empty(), "\n{complaints}");
}

#[test]
fn crates_depend_on_each_other_as_drawn() {
    for (member, allowed) in CRATES {
        let path = format!("{ROOT}/{member}/Cargo.toml");
        let manifest: toml::Table = fs::read_to_string(&path).unwrap().parse().unwrap();
        let dependencies = manifest.get("dependencies").and_then(|d| d.as_table());
        for dependency in dependencies.into_iter().flatten().map(|(name, _)| name) {
            if let Some(ours) = dependency.strip_prefix("sesc-") {
                assert!(
                    allowed.contains(&ours),
                    "{path}: {member} may not depend on {ours}"
                );
            }
        }
    }
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut found = circles(&of_python());
    for member in WITHOUT_CIRCLES {
        let circles = circles(&read(member));
        found.extend(
            circles
                .into_iter()
                .map(|way| format!("{member}/src: {way}")),
        );
    }
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// Circles, one of each group at least, as `a → b → a`.
///
/// A file may name what its folder's own file declares: `super::Type` is no step. What the folder's
/// file names of the files below is one, so that a circle through a parent is seen.
fn circles(files: &Files) -> Vec<String> {
    let is_above =
        |outer: &str, inner: &str| outer.is_empty() || inner.starts_with(&format!("{outer}::"));
    let mut steps = BTreeMap::new();
    for module in files.keys() {
        let mut next: BTreeSet<&str> = imports(files, module).into_iter().map(|(_, m)| m).collect();
        next.retain(|other| !is_above(other, module));
        steps.insert(module.as_str(), next);
    }
    let (mut done, mut found) = (BTreeSet::new(), Vec::new());
    for module in files.keys() {
        walk(module, &steps, &mut done, &mut Vec::new(), &mut found);
    }
    found
}

fn walk<'a>(
    module: &'a str,
    steps: &BTreeMap<&'a str, BTreeSet<&'a str>>,
    done: &mut BTreeSet<&'a str>,
    way: &mut Vec<&'a str>,
    found: &mut Vec<String>,
) {
    if let Some(start) = way.iter().position(|before| *before == module) {
        found.push(format!("{} → {module}", way[start..].join(" → ")));
    } else if !done.contains(module) {
        way.push(module);
        for next in &steps[module] {
            walk(next, steps, done, way, found);
        }
        way.pop();
        done.insert(module);
    }
}

fn read(member: &str) -> Files {
    let mut files = Files::new();
    collect(&Path::new(ROOT).join(member).join("src"), "", &mut files);
    files
}

/// Modules of the Python package, by their relative imports.
fn of_python() -> Files {
    let mut files = Files::new();
    for entry in fs::read_dir(Path::new(ROOT).join("python/sesc")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "py") {
            continue;
        }
        let mut uses = String::new();
        for line in fs::read_to_string(&path).unwrap().lines() {
            let Some((from, names)) = line.trim().split_once(" import ") else {
                continue;
            };
            match from.strip_prefix("from .") {
                Some("") => uses += &format!("use crate::{{{names}}};\n"),
                Some(module) => uses += &format!("use crate::{module}::it;\n"),
                None => {}
            }
        }
        let stem = path.file_stem().unwrap().to_str().unwrap();
        files.insert(stem.to_string(), paths(&uses));
    }
    files
}

fn collect(folder: &Path, module: &str, files: &mut Files) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem == "tests" || stem.ends_with("_tests") {
            continue;
        }
        if path.is_dir() {
            collect(&path, &joined(module, stem), files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = match stem {
                "mod" | "lib" | "main" => module.to_string(),
                _ => joined(module, stem),
            };
            files.insert(name, paths(&fs::read_to_string(&path).unwrap()));
        }
    }
}

fn joined(module: &str, name: &str) -> String {
    match module {
        "" => name.to_string(),
        _ => format!("{module}::{name}"),
    }
}

/// Line and module of everything that a module names; what another module passes on (`pub use`)
/// counts as named where it is.
fn imports<'a>(files: &'a Files, module: &str) -> Vec<(usize, &'a str)> {
    let found = files[module].iter().filter_map(|named| {
        let names: Vec<&str> = named.names.iter().map(String::as_str).collect();
        Some((named.line, resolve(files, module, &names, 8)?))
    });
    found.filter(|(_, found)| *found != module).collect()
}

fn resolve<'a>(files: &'a Files, here: &str, names: &[&str], depth: usize) -> Option<&'a str> {
    let mut at = here.to_string();
    let mut rest = names;
    while let [first, tail @ ..] = rest {
        match *first {
            "crate" => at.clear(),
            "self" => {}
            "super" => at = at.rsplit_once("::").map_or("", |(up, _)| up).to_string(),
            _ => break,
        }
        rest = tail;
    }
    if rest.len() == names.len() && !files.contains_key(&joined(&at, names[0])) {
        return None;
    }
    while let [first, tail @ ..] = rest
        && files.contains_key(&joined(&at, first))
    {
        at = joined(&at, first);
        rest = tail;
    }
    let (module, all) = files.get_key_value(&at)?;
    let passed_on = || {
        let wanted = *rest.first()?;
        let is_it =
            |named: &&Named| named.public && named.names.last().is_some_and(|n| n == wanted);
        let path = all.iter().find(is_it)?.names.iter().map(String::as_str);
        let path: Vec<&str> = path.chain(rest[1..].iter().copied()).collect();
        resolve(files, module, &path, depth.checked_sub(1)?)
    };
    passed_on().or(Some(module))
}

/// Every path of at least two names in `text`, without comments and inline modules of tests.
fn paths(text: &str) -> Vec<Named> {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or(l));
    let code = lines.collect::<Vec<_>>().join("\n");
    let tests = code.match_indices("#[cfg(test)]").find(|(at, _)| {
        let item = code[*at..].split([';', '{']).next().unwrap_or("");
        item.contains("mod ") && code[at + item.len()..].starts_with('{')
    });
    let code = &code[..tests.map_or(code.len(), |(at, _)| at)];
    let (mut found, mut at, mut line, mut counted) = (Vec::new(), 0, 1, 0);
    while let Some(next) = code[at..].chars().next() {
        let first = name(&code[at..]);
        let before = code[..at].chars().next_back();
        // `$crate::` is of whoever calls the macro.
        if first.is_empty() || matches!(before, Some('$' | ':')) {
            at += first.len().max(next.len_utf8());
            continue;
        }
        line += code[counted..at].matches('\n').count();
        counted = at;
        let statement = code[..at].rsplit([';', '{', '}']).next().unwrap_or("");
        let public = statement.contains("pub") && statement.trim_end().ends_with("use");
        let mut all = Vec::new();
        at = code.len() - expand(&code[at..], &[], &mut all).len();
        found.extend(
            all.into_iter()
                .filter(|names| names.len() > 1)
                .map(|names| Named {
                    line,
                    names: names.into_iter().map(str::to_string).collect(),
                    public,
                }),
        );
    }
    found
}

/// The name at the beginning of `text`.
fn name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// The paths that `text` begins with, `a::{b, c::d}` as `a::b` and `a::c::d`; what is left of it.
fn expand<'a>(text: &'a str, prefix: &[&'a str], found: &mut Vec<Vec<&'a str>>) -> &'a str {
    let mut names = prefix.to_vec();
    let mut rest = text;
    loop {
        if let Some(mut list) = rest.strip_prefix('{') {
            loop {
                list = list.trim_start_matches(|c: char| c.is_whitespace() || ",*".contains(c));
                if list.is_empty() || list.starts_with('}') {
                    return list.get(1..).unwrap_or("");
                }
                let after = expand(list, &names, found);
                // Never stand still, whatever the text is.
                list = if after.len() < list.len() {
                    after
                } else {
                    &list[1..]
                };
            }
        }
        let first = name(rest);
        if !first.is_empty() {
            names.push(first);
            rest = &rest[first.len()..];
        }
        match rest.strip_prefix("::") {
            Some(after) if !first.is_empty() => rest = after,
            _ => {
                found.push(names);
                return rest;
            }
        }
    }
}

#[test]
fn circles_are_seen_through_a_parent_and_through_what_is_passed_on() {
    let texts = |texts: &[(&str, &str)]| -> Files {
        let texts = texts.iter();
        texts
            .map(|(module, text)| (module.to_string(), paths(text)))
            .collect()
    };
    let none = texts(&[
        ("", "mod a; mod b; pub use a::c::C;"),
        ("a", "mod c; use c::C; pub struct A;"),
        ("a::c", "use super::A; // use crate::b::B;"),
        (
            "b",
            "use crate::{a::{c, A}};\n#[cfg(test)]\nmod tests { use crate::b::B; }",
        ),
    ]);
    assert_eq!(circles(&none), [""; 0]);
    // What a file below the parent names comes back to the parent.
    let parent = texts(&[
        ("", ""),
        ("a", "mod c; fn a() { c::d() }"),
        ("a::c", "use crate::b::B;"),
        ("b", "use crate::a::A;"),
    ]);
    assert_eq!(circles(&parent), ["a → a::c → b → a"]);
    let passed_on = texts(&[
        ("", "pub use b::B;"),
        ("a", "use crate::B;"),
        ("b", "super::a::f()"),
    ]);
    assert_eq!(circles(&passed_on), ["b → a → b"]);
}
