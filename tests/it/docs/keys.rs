//! Tables of keys hold for what commands print and write: every key of an answer or a file stands
//! in its table with the kind of value that it has, and every key of a table is in some answer.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Read as _;
use std::path::Path;

use flate2::bufread::GzDecoder;
use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, sesc};

use super::logs::folder_of_logs;
use super::{read, run};

/// Keys of a table, and what their values are.
type Table = BTreeMap<String, String>;

/// The tables of a part of a page, as one.
fn table(part: &str) -> Table {
    let rows = part.lines().filter_map(|line| {
        let (key, rest) = line.strip_prefix("| `")?.split_once("` | ")?;
        let (value, meaning) = rest.split_once(" | ")?;
        assert!(meaning.len() > " |".len(), "`{key}` has no meaning");
        Some((key.to_string(), value.to_string()))
    });
    rows.collect()
}

/// The table that `cargo regen` writes under this name into docs/formats.md.
fn table_of_formats(name: &str) -> Table {
    let page = read("docs/formats.md");
    let begin = format!("<!-- cargo regen: {name} -->");
    let (_, part) = page.split_once(&begin).unwrap();
    table(part.split_once("<!-- end -->").unwrap().0)
}

/// Keys that were seen, each in the words of the table.
struct Seen<'t> {
    table: &'t Table,
    keys: BTreeSet<String>,
    /// What does not stand in the table as it was seen.
    faults: BTreeSet<String>,
}

impl Seen<'_> {
    fn of(table: &Table) -> Seen<'_> {
        Seen {
            table,
            keys: BTreeSet::new(),
            faults: BTreeSet::new(),
        }
    }

    /// Keys of an object that stands under `prefix`.
    fn object(&mut self, prefix: &str, object: &serde_json::Map<String, Value>) {
        let any = format!("{prefix}*");
        let is_map = self.table.contains_key(&any);
        for (name, value) in object {
            let key = match is_map {
                true => any.clone(),
                false => format!("{prefix}{name}"),
            };
            match self.table.get(&key) {
                Some(kind) if !is_of(kind, value) => {
                    self.faults.insert(format!("{key} is {value}, not {kind}"));
                }
                Some(_) => {}
                // A map has no row of its own beside that of its entries.
                None if self.table.contains_key(&format!("{key}.*")) => {}
                None => {
                    self.faults.insert(format!("{key} is in no table"));
                }
            }
            self.value(&key, value);
            self.keys.insert(key);
        }
    }

    fn value(&mut self, key: &str, value: &Value) {
        match value {
            Value::Object(inner) => self.object(&format!("{key}."), inner),
            Value::Array(all) => {
                for one in all {
                    self.value(&format!("{key}[]"), one);
                }
            }
            _ => {}
        }
    }

    /// Keys of the table that were not seen.
    fn missing(&self) -> Vec<&String> {
        let keys = self.table.keys();
        keys.filter(|key| !self.keys.contains(*key)).collect()
    }
}

/// Whether a value is of the kind that a table says.
fn is_of(kind: &str, value: &Value) -> bool {
    let (kind, or_null) = match kind.split_once(", or `null`") {
        Some((kind, _)) => (kind, true),
        None => (kind, false),
    };
    let kind = kind.trim_end_matches(", where there is one");
    if value.is_null() {
        // A number that is not finite.
        return or_null || kind == "number";
    }
    if let Some((_, of)) = kind
        .split_once("list of ")
        .filter(|_| kind.starts_with("list of "))
    {
        let Value::Array(all) = value else {
            return false;
        };
        let count = of.split(' ').next().and_then(|word| word.parse().ok());
        return count.is_none_or(|count: usize| all.len() == count);
    }
    match kind {
        "number" => value.is_number(),
        "whole number" => value.is_u64() || value.is_i64(),
        "text" => value.is_string(),
        "list" => value.is_array(),
        "`true` or `false`" => value.is_boolean(),
        "object" | "table" => value.is_object(),
        names => {
            let named = |text: &str| names.contains(&format!("`{text}`"));
            value.as_str().map_or(value.is_object(), named)
        }
    }
}

#[test]
fn kinds_of_values_are_told_apart() {
    let value = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    for (kind, right, wrong) in [
        ("number", "0.5", "true"),
        ("whole number, or `null`", "null", "0.5"),
        ("text", "\"a\"", "1"),
        ("list of 2 numbers", "[1, 2]", "[1]"),
        ("list of objects", "[]", "{}"),
        ("`true` or `false`", "false", "0"),
        (
            "`none` or `named`, where there is one",
            "\"none\"",
            "\"non\"",
        ),
        ("object", "{}", "null"),
    ] {
        assert!(is_of(kind, &value(right)), "{kind}: {right}");
        assert!(!is_of(kind, &value(wrong)), "{kind}: {wrong}");
    }
}

/// Keys that no answer of this test has, with what it would take.
const RARE: [(&str, &str, &str); 5] = [
    ("diagnose", "implausible", "a log that no robot can have"),
    (
        "diagnose",
        "closure.explained_by",
        "a diagnosis says it in its steps",
    ),
    (
        "fit",
        "closure.explained_by[].offset_m",
        "a leg with a prismatic joint",
    ),
    (
        "plan",
        "both_feet.offsets[].offset_m",
        "a leg with a prismatic joint",
    ),
    (
        "fleet",
        "changes[].before.",
        "an effect that is there before, on four days or more",
    ),
];

/// Every key that a command prints stands in its tables, nested ones too, and no other.
#[test]
fn json_has_the_keys_of_its_tables() {
    let page = read("docs/json.md");
    let sections: BTreeMap<&str, Table> = page
        .split("\n## `")
        .skip(1)
        .map(|part| {
            let (command, part) = part.split_once('`').unwrap();
            (command, table(part))
        })
        .collect();
    let folder = folder_of_logs();
    let at = folder.path();
    let run = |line: &str| run(at, line);
    let mut seen: BTreeMap<&str, Seen> = sections
        .iter()
        .map(|(command, table)| (*command, Seen::of(table)))
        .collect();
    for &line in LINES {
        let (line, code) = match line.strip_prefix("1: ") {
            Some(line) => (line, " || [[ $? == 1 ]]"),
            None => (line, ""),
        };
        let command = line.split(' ').next().unwrap();
        if !sections.contains_key(command) {
            run(line);
            continue;
        }
        let answer = run(&format!("sesc {line} --json --quiet{code}"));
        let answer: Value = serde_json::from_str(&answer).unwrap();
        let mut answer = answer.as_object().unwrap().clone();
        assert_eq!(answer.remove("schema"), Some(1.into()), "{line}");
        seen.get_mut(command).unwrap().object("", &answer);
    }
    let mut faults = Vec::new();
    for (command, seen) in &seen {
        let rare = |key: &String| {
            RARE.iter()
                .any(|(of, start, _)| of == command && key.starts_with(start))
        };
        faults.extend(seen.faults.iter().map(|what| format!("{command}: {what}")));
        let missing = seen.missing().into_iter().filter(|key| !rare(key));
        faults.extend(missing.map(|key| format!("{command}: no answer has {key}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What the test asks; lines that begin with `1: ` end with exit code 1, those that begin with no
/// command of `sesc` are of the shell.
const LINES: &[&str] = &[
    "demo",
    "inspect op2.urdf --support r_sole",
    "verify op2.urdf --support r_sole --samples 20",
    "plan op2.urdf --support r_sole --poses 10 --candidates 100 --out poses.csv",
    "plan op2.urdf --support r_sole --both-feet --poses 5 --candidates 50 --out few.csv",
    "simulate op2.urdf --support r_sole --poses 600 --rate 50 --noise 0.0005 --out moving.csv",
    "simulate op2.urdf --support r_sole --poses 50 --range 3 --noise 0.0005 --out near.csv",
    "simulate op2.urdf --support r_sole --poses 30 --range 10 --noise 0.0005 \
     --hide joint_offset:r_ank_roll=3deg --out ankle.csv",
    "simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 --hide joint_sign:r_knee \
     --out sign.csv",
    "simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 --hide joint_scale:r_knee=1.2 \
     --out scale.csv",
    "simulate lift.urdf --support grasp_frame --poses 80 --noise 0.0005 \
     --hide joint_scale:torso_lift_joint=1.2 --out lift.csv",
    "fit op2.urdf --data knee.csv --out model.toml",
    "fit op2.urdf --data feet.csv",
    "fit op2.urdf --data timed.csv --physical --urdf corrected.urdf --report fit.html",
    "fit op2.urdf --data outliers.csv --robust huber",
    "fit op2.urdf --data again.csv",
    "fit op2.urdf --data moving.csv",
    "fit op2.urdf --data near.csv --prior free",
    "fit op2.urdf --data clipped.csv",
    "1: fit op2.urdf --data dead.csv",
    "printf '[joints.r_knee]\nzero = 2048\n' > servos.toml",
    "printf '[joints.torso_lift_joint]\nmetres_per_tick = 1e-5\n' > lift.toml",
    "diagnose op2.urdf --data knee.csv --servos servos.toml --out found.toml --urdf found.urdf",
    "diagnose op2.urdf --data timed.csv",
    "diagnose op2.urdf --data again.csv",
    "diagnose op2.urdf --data moving.csv",
    "diagnose op2.urdf --data feet.csv --noise 0.003",
    "diagnose op2.urdf --data ankle.csv",
    "diagnose op2.urdf --data sign.csv --servos servos.toml",
    "diagnose op2.urdf --data scale.csv --servos servos.toml",
    "diagnose lift.urdf --data lift.csv --servos lift.toml",
    "diagnose op2.urdf --data clipped.csv",
    "1: diagnose op2.urdf --data dead.csv",
    "effects",
    "compare model.toml found.toml",
    "predict op2.urdf --data poses.csv",
    "predict op2.urdf --data poses.csv --out predicted.csv",
    "generate op2.urdf --support r_sole --name op2_r_sole --out src",
    // Five sound robots; four whose knees went off; a log that came twice, and a broken one.
    "mkdir logs; for k in 1 2 3 4 5; do \
     sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 --seed $k --out logs/r${k}_1.csv; done",
    "fleet op2.urdf --data logs --out fleet.csv --prior-out prior.toml",
    "for k in 1 2 3 4; do sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 \
     --seed 1$k --hide joint_offset:r_knee=3deg --out logs/r${k}_2.csv; done",
    "cp logs/r1_1.csv logs/r1_3.csv; cp logs/r1_1.csv.toml logs/r1_3.csv.toml; \
     echo pose,cop_x > logs/r2_3.csv",
    "fleet op2.urdf --data logs --out fleet.csv",
];

/// An error is what its table says, with a file and a line and without.
#[test]
fn errors_have_the_keys_of_their_table() {
    let page = read("docs/json.md");
    let (_, part) = page.split_once("<!-- cargo regen: errors -->").unwrap();
    let errors = table(part.split_once("<!-- end -->").unwrap().0);
    let mut seen = Seen::of(&errors);
    let folder = folder();
    let log = folder.path().join("log.csv");
    fs::write(&log, "pose,cop_x\n0,zero\n").unwrap();
    let op2 = format!("{ROOT}/robots/op2/op2.urdf");
    let log = log.display().to_string();
    for arguments in [
        &["fit", &op2, "--data", &log, "--support", "r_sole", "--json"][..],
        &["inspect", &op2, "--support", "none", "--json"],
    ] {
        let output = sesc(arguments);
        assert_eq!(output.status.code(), Some(2));
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let mut answer = answer.as_object().unwrap().clone();
        assert_eq!(answer.remove("schema"), Some(1.into()));
        seen.object("", &answer);
    }
    assert!(seen.faults.is_empty(), "{:?}", seen.faults);
    assert!(seen.missing().is_empty(), "{:?}", seen.missing());
}

/// Files that commands write have the keys of their tables.
#[test]
fn written_files_have_the_keys_of_their_tables() {
    let folder = folder_of_logs();
    let at = folder.path();
    let [model, part, population] = ["model file", "part file", "population"].map(table_of_formats);
    for line in FILES {
        run(at, line);
    }

    let mut seen = Seen::of(&model);
    for name in ["model.toml", "cells.toml", "timed.toml"] {
        seen.object("", &toml(&at.join(name)));
    }
    assert!(seen.faults.is_empty(), "{:?}", seen.faults);
    assert!(seen.missing().is_empty(), "{:?}", seen.missing());

    let mut seen = Seen::of(&population);
    let prior = toml(&at.join("prior.toml"));
    let prior = prior["population"].as_object().unwrap();
    seen.object("", prior);
    assert!(seen.faults.is_empty(), "{:?}", seen.faults);
    assert!(seen.missing().is_empty(), "{:?}", seen.missing());

    let mut seen = Seen::of(&part);
    for number in 1..=7 {
        let bytes = fs::read(at.join(format!("{number}.part"))).unwrap();
        let mut header = String::new();
        GzDecoder::new(&bytes[..])
            .read_to_string(&mut header)
            .unwrap();
        let header: Value = serde_json::from_str(header.trim()).unwrap();
        seen.object("", header.as_object().unwrap());
    }
    assert!(seen.faults.is_empty(), "{:?}", seen.faults);
    // Formats before 3 had their numbers here; legs of the OP2 have no prismatic joint.
    let older = |key: &String| key.ends_with(".triangle") || key.ends_with("[].offset_m");
    let missing: Vec<_> = seen
        .missing()
        .into_iter()
        .filter(|key| !older(key))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// Commands that write files.
const FILES: [&str; 11] = [
    "sesc fit op2.urdf --data knee.csv --out model.toml",
    "sesc diagnose op2.urdf --data cells.csv --out cells.toml",
    "mkdir logs; for k in 1 2 3 4 5; do \
     sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 --seed $k --out logs/r${k}_1.csv; done",
    "sesc fleet op2.urdf --data logs --out fleet.csv --prior-out prior.toml",
    "sesc fit op2.urdf --data outliers.csv --robust huber --unit r1 --partial 1.part",
    "sesc fit op2.urdf --data clipped.csv --partial 2.part",
    "sesc fit op2.urdf --data feet.csv --partial 3.part",
    "sesc fit op2.urdf --data timed.csv --partial 4.part; \
     sesc fit op2.urdf --data timed.csv --out timed.toml",
    "sesc simulate op2.urdf --support r_sole --poses 600 --rate 50 --noise 0.0005 --out moving.csv; \
     sesc fit op2.urdf --data moving.csv --partial 5.part",
    "sesc fit op2.urdf --data stays.csv --settle 0.5 --partial 6.part",
    "sesc fit op2.urdf --data uneven.csv --partial 7.part",
];

/// A file of TOML as JSON has it.
fn toml(path: &Path) -> serde_json::Map<String, Value> {
    let text = fs::read_to_string(path).unwrap();
    let value: Value = toml::from_str(&text).unwrap();
    value.as_object().unwrap().clone()
}

/// Files that people write: a file with every key of its table is taken, and one with another
/// key is refused.
#[test]
fn files_may_have_every_key_of_their_tables() {
    let (folder, op2) = (folder(), format!("{ROOT}/robots/op2/op2.urdf"));
    let at = folder.path();
    run(
        at,
        &format!("sesc simulate {op2} --support r_sole --poses 60 --noise 0.001 --out log.csv"),
    );
    for (name, entry, sample) in [("prior", "body_link", "0.01"), ("servos", "r_knee", "1")] {
        let tables = table_of_formats(name);
        let mut sections: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for key in tables.keys() {
            let Some((section, last)) = key.rsplit_once('.').filter(|(_, last)| *last != "*")
            else {
                continue;
            };
            let section = section.replace('*', entry);
            // A revolute joint has no stroke; it may be said all the same.
            sections
                .entry(section)
                .or_default()
                .push(format!("{last} = {sample}\n"));
        }
        assert_eq!(sections.len(), 2, "{sections:?}");
        let text = |more: &str| -> String {
            let all = sections.iter();
            all.map(|(section, keys)| format!("[{section}]\n{}{more}", keys.concat()))
                .collect()
        };
        let command = if name == "prior" { "fit" } else { "diagnose" };
        let file = at.join("file.toml").display().to_string();
        let log = at.join("log.csv").display().to_string();
        let option = format!("--{name}");
        let arguments = [command, &op2, "--data", &log, &option, &file];
        fs::write(&file, text("")).unwrap();
        let taken = sesc(&arguments);
        assert!(
            taken.status.success(),
            "{}",
            String::from_utf8_lossy(&taken.stderr)
        );
        fs::write(&file, text("wxyz = 1\n")).unwrap();
        let refused = sesc(&arguments);
        assert_eq!(refused.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&refused.stderr).contains("wxyz"));
    }
}
