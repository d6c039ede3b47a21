//! What libraries leave to their front ends: options, which the command line words for
//! settings, and what belongs to the whole process.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::imports::code;

/// Lines of the files under `folder` that `names` finds, tests aside.
fn named(folder: &Path, names: fn(&str) -> bool, complaints: &mut String) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let stem = path.file_stem().unwrap().to_str().unwrap();
        if stem == "tests" || stem.ends_with("_tests") {
            continue;
        }
        if path.is_dir() {
            named(&path, names, complaints);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = code(&fs::read_to_string(&path).unwrap());
            for (line, words) in text.lines().enumerate().filter(|(_, line)| names(line)) {
                let _ = writeln!(complaints, "{}:{}: {words}", path.display(), line + 1);
            }
        }
    }
}

/// Whether there is an option of ours in a line.
fn names(line: &str) -> bool {
    // Of another program.
    let ours = line.replace("mcap compress --compression", "");
    let mut dashes = ours.match_indices("--").map(|(at, _)| at);
    dashes.any(|at| {
        let before = ours[..at].chars().next_back().unwrap_or(' ');
        " \"`(".contains(before) && ours[at + 2..].starts_with(|c: char| c.is_ascii_lowercase())
    })
}

/// Complaints about the libraries.
fn in_libraries(names: fn(&str) -> bool) -> String {
    let mut complaints = String::new();
    for member in ["model", "runtime", "codegen", "identify"] {
        let src = Path::new(crate::ROOT).join(member).join("src");
        named(&src, names, &mut complaints);
    }
    complaints
}

#[test]
fn libraries_name_no_option_of_the_command_line() {
    let complaints = in_libraries(names);
    assert!(complaints.is_empty(), "\n{complaints}");
    assert!(names("use one --folds for all") && !names("let x = i--b;"));
}

/// The panic hook is the application's.
#[test]
fn libraries_set_no_panic_hook() {
    let complaints = in_libraries(|line| line.contains("set_hook"));
    assert!(complaints.is_empty(), "\n{complaints}");
}
