//! What to do next stands in every answer, for people and for programs alike.

use std::path::Path;

use serde_json::Value;
use sesc_test_support::command::{folder, op2, sesc, stdout};

/// What a command says for people, and for programs.
fn both(line: &[&str]) -> (String, Value) {
    let said = sesc(line);
    let text = stdout(&said) + &String::from_utf8(said.stderr).unwrap();
    let json = stdout(&sesc(&[line, &["--json"]].concat()));
    (text, serde_json::from_str(&json).unwrap())
}

fn logs(folder: &Path) -> [String; 2] {
    ["monday.csv", "friday.csv"].map(|name| {
        let log = folder.join(name).display().to_string();
        let line = ["simulate", &op2(), "--support", "r_sole", "--poses", "60"];
        let seed = if name == "monday.csv" { "1" } else { "2" };
        let rest = ["--noise", "0.0005", "--seed", seed, "--out", &log];
        stdout(&sesc(&[&line[..], &rest].concat()));
        log
    })
}

#[test]
fn every_command_says_what_to_do_next() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let [monday, friday] = logs(folder.path());
    let (urdf, page, table) = (op2(), at("demo.html"), at("table.csv"));
    let predicted = at("predicted.csv");
    let on = ["--support", "r_sole"];
    let with = |words: &[&'static str]| -> Vec<String> {
        words.iter().map(|word| word.to_string()).collect()
    };
    let lines: [(Vec<String>, Vec<&str>); 8] = [
        (with(&["demo", "--out"]), vec![&page]),
        (with(&["inspect"]), vec![&urdf, on[0], on[1]]),
        (
            with(&["verify"]),
            vec![&urdf, on[0], on[1], "--samples", "20"],
        ),
        (
            with(&["simulate"]),
            vec![&urdf, on[0], on[1], "--poses", "5", "--out", &table],
        ),
        (
            with(&["generate"]),
            vec![
                &urdf,
                on[0],
                on[1],
                "--out",
                folder.path().to_str().unwrap(),
            ],
        ),
        (
            with(&["predict"]),
            vec![&urdf, "--data", &monday, "--out", &predicted],
        ),
        (with(&["compare"]), vec![&monday, &friday, "--urdf", &urdf]),
        // Nothing is missing from this log.
        (with(&["diagnose"]), vec![&urdf, "--data", &monday]),
    ];
    for (command, rest) in &lines {
        let line: Vec<&str> = command.iter().map(String::as_str).collect();
        let (text, json) = both(&[&line[..], rest].concat());
        let steps = json["next_steps"].as_array().unwrap();
        assert!(!steps.is_empty(), "{line:?}");
        for step in steps {
            let first = step["what"].as_str().unwrap().split(' ').next().unwrap();
            assert!(
                text.contains(&format!("next             {first}")),
                "{text}"
            );
            if let Some(command) = step["command"].as_str() {
                assert!(text.contains(command), "{text}\n{command}");
            }
        }
    }
}

/// The command of a step is one that runs.
#[test]
fn a_robot_as_simulated_is_compared_with_a_later_log() {
    let folder = folder();
    let [monday, friday] = logs(folder.path());
    let found = sesc(&["diagnose", &op2(), "--data", &monday, "--json"]);
    let found: Value = serde_json::from_str(&stdout(&found)).unwrap();
    assert_eq!(found["verdict"], "none", "{}", found["sentence"]);
    let command = found["next_steps"][0]["command"].as_str().unwrap();
    let later = command.replace("LATER_LOG", &friday);
    let words: Vec<&str> = later.split(' ').skip(1).collect();
    let (urdf, log) = (op2(), &*friday);
    assert_eq!(words, ["compare", &monday, log, "--urdf", &urdf], "{later}");
    let said = stdout(&sesc(&words));
    assert!(said.contains("Go on with "), "{said}");
}
