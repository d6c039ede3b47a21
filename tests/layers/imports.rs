//! Which file of a crate imports which, by reading `use` and paths.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// What the files of a crate name, apart from tests, by module: `urdf::scan`, and the
/// empty name for `lib.rs` or `main.rs`.
pub struct Files {
    used: BTreeMap<String, Vec<Used>>,
}

/// A path in a text: `crate::a::B`.
struct Used {
    line: usize,
    names: Vec<String>,
    /// `pub use`.
    public: bool,
}

impl Files {
    /// Read the files of a folder `src`.
    pub fn read(src: &Path) -> Files {
        let mut used = BTreeMap::new();
        collect(src, "", &mut used);
        Files { used }
    }

    /// Read texts by module.
    pub fn of(texts: &[(&str, &str)]) -> Files {
        let used = texts
            .iter()
            .map(|(m, text)| (m.to_string(), paths(&code(text))));
        Files {
            used: used.collect(),
        }
    }

    /// All modules that are files.
    pub fn modules(&self) -> impl Iterator<Item = &str> {
        self.used.keys().map(String::as_str)
    }

    /// Line and module of everything that a module names; what another module passes
    /// on (`pub use`) counts as named where it is.
    pub fn imports(&self, module: &str) -> Vec<(usize, &str)> {
        let found = self.used[module].iter().filter_map(|used| {
            let names: Vec<&str> = used.names.iter().map(String::as_str).collect();
            Some((used.line, self.resolve(module, &names, 8)?))
        });
        found.filter(|(_, found)| *found != module).collect()
    }

    fn resolve(&self, here: &str, names: &[&str], depth: usize) -> Option<&str> {
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
        if rest.len() == names.len() && !self.used.contains_key(&joined(&at, names[0])) {
            return None;
        }
        while let [first, tail @ ..] = rest
            && self.used.contains_key(&joined(&at, first))
        {
            at = joined(&at, first);
            rest = tail;
        }
        let (module, all) = self.used.get_key_value(&at)?;
        let passed_on = || {
            let wanted = *rest.first()?;
            let is_it =
                |used: &&Used| used.public && used.names.last().is_some_and(|n| n == wanted);
            let path = all.iter().find(is_it)?.names.iter().map(String::as_str);
            let path: Vec<&str> = path.chain(rest[1..].iter().copied()).collect();
            self.resolve(module, &path, depth.checked_sub(1)?)
        };
        passed_on().or(Some(module))
    }
}

fn joined(module: &str, name: &str) -> String {
    match module {
        "" => name.to_string(),
        _ => format!("{module}::{name}"),
    }
}

fn collect(folder: &Path, module: &str, used: &mut BTreeMap<String, Vec<Used>>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem == "tests" || stem.ends_with("_tests") {
            continue;
        }
        if path.is_dir() {
            collect(&path, &joined(module, stem), used);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = match stem {
                "mod" | "lib" | "main" => module.to_string(),
                _ => joined(module, stem),
            };
            used.insert(name, paths(&code(&fs::read_to_string(&path).unwrap())));
        }
    }
}

/// Text without comments and without the inline modules of tests at its end, lines kept.
pub fn code(text: &str) -> String {
    let lines = text.lines().map(|l| l.split("//").next().unwrap_or(l));
    let text = lines.collect::<Vec<_>>().join("\n");
    let tests = text.match_indices("#[cfg(test)]").find(|(at, _)| {
        let item = text[*at..].split([';', '{']).next().unwrap_or("");
        item.contains("mod ") && text[at + item.len()..].starts_with('{')
    });
    text[..tests.map_or(text.len(), |(at, _)| at)].to_string()
}

/// The name at the beginning of `text`.
fn name(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// Every path of at least two names.
fn paths(code: &str) -> Vec<Used> {
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
        let rest = expand(&code[at..], &[], &mut all);
        at = code.len() - rest.len();
        let long = all.into_iter().filter(|names| names.len() > 1);
        found.extend(long.map(|names| Used {
            line,
            names: names.into_iter().map(str::to_string).collect(),
            public,
        }));
    }
    found
}

/// The paths that `text` begins with, `a::{b, c::d}` as `a::b` and `a::c::d`; what is
/// left of the text.
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
fn imports_are_found_in_every_form() {
    let main = "use crate::a::B; // crate::comment\nuse crate::{c, d::{E, F},\n    g};\n\
         fn h() { super::i::j(); k::l() }\n$crate::c;\n#[cfg(test)]\nmod n;\nuse crate::m;\n\
         #[cfg(test)]\nmod tests { use crate::o; }";
    let mut texts = vec![("x", main), ("", "pub use a::p::B;")];
    texts.extend(["a", "a::p", "c", "d", "g", "i", "m", "o", "x::k"].map(|m| (m, "")));
    let files = Files::of(&texts);
    let found = [
        (1, "a"),
        (2, "c"),
        (2, "d"),
        (2, "d"),
        (2, "g"),
        (4, "i"),
        (4, "x::k"),
        (8, "m"),
    ];
    assert_eq!(files.imports("x"), found);
    let files = Files::of(&[
        ("x", "crate::B"),
        ("", "pub use a::p::B;"),
        ("a", ""),
        ("a::p", ""),
    ]);
    assert_eq!(files.imports("x"), [(1, "a::p")]);
}
