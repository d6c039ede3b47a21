//! The text itself: its lines, its names, the same bytes everywhere.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use sesc_codegen::emit::c::Scalar;

use super::case::{Case, ROOT, SCALARS, cases, jobs};
use super::compiled::{folder, printed};
use super::fixed::without_comments;
use sesc_test_support::command::program;

/// Columns of a line, but for a name or string that is longer by itself.
const COLUMNS: usize = 100;

/// Lines that are too long although they could be broken.
fn too_long(text: &str) -> Vec<&str> {
    let long = text.lines().filter(|line| line.len() > COLUMNS);
    let breaks = |line: &&str| line.trim_start().contains(' ') && !line.contains('"');
    long.filter(breaks).collect()
}

/// Identifiers of C text.
fn words(code: &str) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    let mut word = String::new();
    let mut quoted = false;
    let mut escaped = false;
    for c in code.chars() {
        if quoted {
            quoted = c != '"' || escaped;
            escaped = c == '\\' && !escaped;
            continue;
        }
        quoted = c == '"';
        let number = word.starts_with(digit);
        let exponent = number && c == '-' && word.ends_with('e');
        if c.is_ascii_alphanumeric() || c == '_' || (number && c == '.') || exponent {
            word.push(c);
        } else {
            words.insert(std::mem::take(&mut word));
        }
    }
    words.insert(word);
    words
}

fn digit(c: char) -> bool {
    c.is_ascii_digit()
}

#[test]
fn the_text_keeps_to_the_rules() {
    for (case, scalar) in jobs(&cases()) {
        let package = case.package(scalar);
        for (file, text) in [("h", &package.header), ("c", &package.source)] {
            let name = format!("{}.{file} {scalar:?}", case.name);
            assert!(text.is_ascii() && !text.contains(['\r', '\t']), "{name}");
            assert!(text.ends_with('\n') && !text.ends_with("\n\n"), "{name}");
            assert_eq!(too_long(text), [""; 0], "{name}");
            for line in text.lines() {
                assert_eq!(line, line.trim_end(), "{name}");
            }
            let code = without_comments(text);
            // A body that two functions share is made a part of both: one macro says so.
            let shares = |line: &&str| line.starts_with("#define ") && line.contains("_SHARED ");
            let (shared, code): (Vec<&str>, Vec<&str>) = code.lines().partition(shares);
            assert!(shared.len() <= 2, "{name}: {shared:?}");
            let code = code.join("\n");
            let of_many = case.lanes.is_some();
            for bad in [
                "[static", "alloc", "goto", "union", "//", "volatile", "register", "inline",
            ] {
                // Of many postures: compilers would call the sines of a block, which costs a third,
                // and clang aligns a stack for what lies there alone.
                if of_many && ["inline", "volatile"].contains(&bad) {
                    continue;
                }
                assert!(!code.contains(bad), "{name}: {bad}");
            }
            for line in code.lines().filter(|line| !line.contains("for (")) {
                assert!(line.matches(';').count() <= 1, "{name}: {line}");
            }
        }
        let code = without_comments(&(package.header.clone() + &package.source));
        let macros: BTreeSet<&str> = code
            .lines()
            .filter_map(|line| line.strip_prefix("#define ")?.split_whitespace().next())
            .collect();
        let words = words(&code);
        distinct(&case.name, macros.iter().copied(), 63);
        let named = words.iter().map(String::as_str);
        let named = named.filter(|word| !word.starts_with(digit) && !macros.contains(word));
        distinct(&case.name, named, 63);
        if scalar == Scalar::F32 {
            let numbers = words.iter().filter(|word| word.starts_with(digit));
            for number in numbers.filter(|number| !number.starts_with("0x")) {
                let float = number.contains(['.', 'e']);
                assert!(!float || number.ends_with('f'), "{}: {number}", case.name);
            }
            assert!(!words.contains("double"), "{}", case.name);
        }
        no_recursion(&case.name, &without_comments(&package.source));
    }
}

/// No two of `names` begin with the same `length` characters.
fn distinct<'a>(case: &str, names: impl Iterator<Item = &'a str>, length: usize) {
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    for name in names {
        let start = &name[..name.len().min(length)];
        if let Some(other) = seen.insert(start, name) {
            assert_eq!(other, name, "{case}: one name in {length} characters");
        }
    }
}

/// A function calls only what stands above it.
fn no_recursion(case: &str, code: &str) {
    let defines = |line: &str| {
        let head = line.split_once('(')?.0;
        let starts = line.starts_with(|c: char| c.is_ascii_alphabetic());
        // The attribute of a type looks like a function.
        let starts = starts && !line.starts_with("typedef ");
        let name = head.split_whitespace().last().unwrap_or_default();
        starts.then(|| name.to_string())
    };
    let order: Vec<String> = code.lines().filter_map(defines).collect();
    assert!(order.len() > 3, "{case}: {order:?}");
    let mut above = 0;
    for line in code.lines() {
        if defines(line).is_some() {
            above += 1;
            continue;
        }
        // Itself, and what first stands below: of two definitions the preprocessor takes one.
        let (before, from) = order.split_at(above.max(1) - 1);
        let (own, below) = from.split_at(1);
        let below = below.iter().filter(|name| !before.contains(name));
        for name in own.iter().chain(below) {
            let called = line.contains(&format!(" {name}(")) || line.contains(&format!("-{name}("));
            assert!(!called, "{case}: {line}");
        }
    }
}

/// The same text every time, and whatever the language of the machine.
#[test]
fn the_same_bytes_in_every_run_and_language() {
    let folder = folder("language");
    for (k, language) in ["C", "de_DE.UTF-8", "tr_TR.UTF-8"].into_iter().enumerate() {
        let out = folder.join(k.to_string());
        let mut command = Command::new(program());
        let line = "generate robots/op2/op2.urdf --support r_sole --lang c --functions \
             com_jacobian,com_velocity,gravity_moments,regressor,regressor_cop,regressor_full,cop,zmp \
             --scalar fixed32 --name op2_r_sole_fixed --out";
        command.current_dir(ROOT).args(line.split(' ')).arg(&out);
        printed(command.env("LC_ALL", language).env("LANG", language));
        for file in ["op2_r_sole_fixed.h", "op2_r_sole_fixed.c"] {
            let text = fs::read(out.join(file)).unwrap();
            assert!(text == fs::read(Path::new(ROOT).join("generated/c").join(file)).unwrap());
        }
    }
    let case = Case::random(741, 7);
    for scalar in SCALARS {
        assert_eq!(case.package(scalar), Case::random(741, 7).package(scalar));
    }
}
