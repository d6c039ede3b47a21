//! The stack that headers promise, against what the compiler takes.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use super::case::{Case, SCALARS};
use super::compiled::{SEPARATE, folder, parallel, printed, write};

/// Bytes of each function's frame, by its name after the prefix; those that became part of others
/// have none.
fn frames(usage: &str, name: &str) -> BTreeMap<String, usize> {
    let own = |line: &str| {
        let row: Vec<&str> = line.split('\t').collect();
        let function = row[0].rsplit(':').next()?.strip_prefix(name)?;
        Some((
            function.strip_prefix('_')?.to_string(),
            row[1].parse().unwrap(),
        ))
    };
    usage.lines().filter_map(own).collect()
}

/// gcc says what each function takes. What it calls is added: its body, and every helper.
#[test]
fn no_function_takes_more_stack_than_its_header_says() {
    let folder = folder("stack");
    let cases = [
        ("op2", "r_sole"),
        ("skew_humanoid", "left_sole"),
        ("lift_base", "hand"),
    ];
    let cases = cases.map(|(robot, support)| Case::robot(robot, support));
    let jobs = cases
        .iter()
        .flat_map(|case| SCALARS.map(|scalar| (case, scalar)));
    parallel(jobs.collect(), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let rows = package.header.lines().filter_map(|line| {
            let words: Vec<&str> = line.strip_prefix(" * ")?.split_whitespace().collect();
            let numbers: Vec<usize> = words.iter().skip(1).map_while(|w| w.parse().ok()).collect();
            (numbers.len() >= 5).then(|| (words[0].to_string(), numbers[4]))
        });
        let promised: BTreeMap<String, usize> = rows.collect();
        assert!(promised.len() > 10, "{promised:?}");
        let object = folder.join("object.o");
        for level in ["-O1", "-O2", "-Os"] {
            let mut gcc = Command::new("cc");
            gcc.args(["-std=c99", SEPARATE, level, "-fstack-usage", "-c", "-o"]);
            printed(gcc.args([&object, &source]));
            let usage = fs::read_to_string(folder.join("object.su")).unwrap();
            let frames = frames(&usage, &case.name);
            let helpers = ["sincos", "turn", "lookup", "narrow", "power", "clamp"];
            let helpers: usize = helpers.iter().filter_map(|name| frames.get(*name)).sum();
            let of = |name: &str| frames.get(name).copied().unwrap_or(0);
            let own = |name: &str| {
                let stem = name.strip_suffix("_sc").unwrap_or(name);
                of(name) + of(&format!("{stem}_core")) + helpers
            };
            for (name, promised) in &promised {
                let taken = match name.strip_suffix("_ticks") {
                    Some(stem) => {
                        let called = [format!("{stem}_sc"), stem.to_string()];
                        let called = called.iter().map(|name| own(name)).max().unwrap_or(0);
                        of(name) + of("from_ticks") + called
                    }
                    None => own(name),
                };
                let what = format!("{} {name} {level}", case.name);
                assert!(taken <= *promised, "{what}: {taken} B of {promised}");
            }
        }
    });
}
