//! What to do next stands in every answer, for people and for programs alike.

use std::path::Path;

use serde_json::Value;
use sesc_test_support::command::{folder, in_words, op2, sesc, stdout};

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
    let out = folder.path().display().to_string();
    for line in [
        in_words("demo --out @", &[&page]),
        in_words("inspect @ --support r_sole", &[&urdf]),
        in_words("verify @ --support r_sole --samples 20", &[&urdf]),
        in_words(
            "simulate @ --support r_sole --poses 5 --out @",
            &[&urdf, &table],
        ),
        in_words("generate @ --support r_sole --out @", &[&urdf, &out]),
        in_words("predict @ --data @ --out @", &[&urdf, &monday, &predicted]),
        in_words("compare @ @ --urdf @", &[&monday, &friday, &urdf]),
        // Nothing is missing from this log.
        in_words("diagnose @ --data @", &[&urdf, &monday]),
    ] {
        let (text, json) = both(&line);
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
