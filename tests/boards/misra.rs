//! MISRA C:2012 as cppcheck's addon checks it.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::c99::case::{Case, LOAD, ROOT, SOFT, estimating, jobs};
use crate::c99::compiled::{folder, parallel, write};

/// Rules of MISRA C:2012 that the C departs from, from the list of reasons.
fn departures() -> BTreeSet<String> {
    let list = Path::new(ROOT).join("codegen/src/emit/c/misra.md");
    let text = fs::read_to_string(list).unwrap();
    let rule = |line: &str| {
        Some(
            line.strip_prefix("| ")?
                .split_whitespace()
                .next()?
                .to_string(),
        )
    };
    text.lines()
        .filter_map(rule)
        .filter(|rule| rule.starts_with(|c: char| c.is_ascii_digit()))
        .collect()
}

/// Names alike in their first 31 characters: the addon looks at 63.
const UNSEEN: &str = "5.1";

/// Statements of every kind that effects bring, on two links: what the OP2 has, in a tenth
/// of the lines.
fn short_effects() -> Vec<Case> {
    let mut cases = Case::of_cells();
    // Its statements are those of an exponent.
    cases.retain(|case| !case.name.ends_with("_cell_gain"));
    cases.push(Case::robot("two_link", "foot").and(
        "bent",
        &[
            ("payload", "shank", LOAD),
            ("joint_compliance", "knee", SOFT),
            ("joint_compliance", "ankle", SOFT),
            ("joint_offset", "knee", &[("offset_rad", 0.03)]),
        ],
    ));
    cases
}

#[test]
fn cppcheck_finds_only_the_departures_that_are_listed() {
    let folder = folder("cppcheck");
    let mut cases = vec![
        Case::robot("two_link", "foot"),
        Case::robot("lift_base", "hand"),
    ];
    cases.push(Case::random(741, 7));
    let mut case = Case::robot("two_link", "foot");
    case.take_values(|_, x| x);
    case.name += "_model";
    cases.push(case);
    cases.push(estimating());
    // The addon takes a minute for the OP2 with effects and more: rules are of statements,
    // and two links with the same effects have all of its kinds.
    cases.extend(short_effects());
    let found: BTreeSet<String> = parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let mut command = Command::new("cppcheck");
        command.args([
            "--enable=warning,style,performance,portability",
            "--addon=misra",
            "--std=c99",
            "--quiet",
            "--template={id} {file}:{line} {message}",
            // What float.h says on the targets: cppcheck reads no header of a system, and would stop
            // at the #error for machines without such numbers.
            "-DFLT_RADIX=2",
            "-DFLT_MANT_DIG=24",
            "-DFLT_MAX_EXP=128",
            "-DDBL_MANT_DIG=53",
            "-DDBL_MAX_EXP=1024",
            "--force",
        ]);
        let output = command.arg(&source).output().expect("install cppcheck");
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        let mut rules = BTreeSet::new();
        for line in text.lines() {
            let rule = line.strip_prefix("misra-c2012-");
            let rule = rule.unwrap_or_else(|| panic!("{} {scalar:?}: {line}", case.name));
            let rule = rule.split_whitespace().next().unwrap().to_string();
            assert!(
                departures().contains(&rule),
                "{} {scalar:?}: {line}",
                case.name
            );
            rules.insert(rule);
        }
        rules
    })
    .into_iter()
    .flatten()
    .collect();
    let mut listed = departures();
    assert!(listed.remove(UNSEEN), "the list names {UNSEEN}");
    assert_eq!(
        found, listed,
        "the list names what is departed from, and nothing else"
    );
}
