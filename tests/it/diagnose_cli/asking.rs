//! How `sesc diagnose` is asked, and what of its answer every test holds.

use std::fs;
use std::path::Path;

use serde_json::Value;
use sesc_test_support::command::{op2, sesc, stdout};
use sesc_test_support::hidden::{Effect, Hidden};
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Trial};

pub fn only(effect: Option<Effect>) -> Choice {
    Choice {
        platforms: vec![Platform::Op2],
        only: effect,
        body: false,
        long: false,
        held: 0.0,
    }
}

pub fn hidden(effect: Effect, target: &str, values: &[f64]) -> Hidden {
    Hidden {
        effect,
        target: target.to_owned(),
        values: values.to_vec(),
        begins: 0.0,
        seed: 1,
    }
}

/// A log of 100 balanced postures of the OP2 with this hidden.
pub fn logged(folder: &Path, stem: &str, truth: Vec<Hidden>) -> String {
    let trial = Trial::of(truth, &only(None), 3).unwrap();
    trial.log.write(folder, stem).display().to_string()
}

/// Diagnose with masses that are known well, unless `more` says otherwise.
pub fn diagnose(log: &str, more: &[&str]) -> Value {
    let urdf = op2();
    let mut arguments = vec!["diagnose", &urdf, "--data", log, "--json"];
    if !more.contains(&"--prior") {
        arguments.extend(["--prior", "tight"]);
    }
    arguments.extend(more);
    let output = sesc(&arguments);
    serde_json::from_str(&stdout(&output)).unwrap()
}

pub fn number(value: &Value) -> f64 {
    let number = value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"));
    assert!(number.is_finite());
    number
}

pub fn labels(said: &Value) -> Vec<String> {
    let steps = said["steps"].as_array().unwrap();
    steps
        .iter()
        .map(|step| {
            let (effect, target) = (step["effect"].as_str(), step["target"].as_str());
            match target.unwrap() {
                "-" => effect.unwrap().to_string(),
                target => format!("{}:{target}", effect.unwrap()),
            }
        })
        .collect()
}

/// What to do next does not contradict itself: postures are offered where they tell something.
fn next_steps(said: &Value) {
    let mut commands = String::new();
    for step in said["next_steps"].as_array().unwrap() {
        for key in ["what", "why"] {
            assert!(
                step[key].as_str().is_some_and(|text| !text.is_empty()),
                "{step}"
            );
        }
        commands += step["command"].as_str().unwrap_or_default();
        commands += "\n";
    }
    let next = &said["next_postures"];
    let tells = next["experiments"][0]["splits"].as_u64().unwrap_or(0) > 0;
    let asked = ["--next", "NEXT_LOG"]
        .iter()
        .any(|words| commands.contains(words));
    assert_eq!(asked, tells, "{commands}\n{next}");
    let none = next["why"].as_str().unwrap().starts_with("No experiment");
    assert!(!(none && asked), "{next}");
    assert!(tells || next["file"].is_null(), "{next}");
}

/// Every key of the contract, with its type, and what they say of each other.
pub fn as_agreed(said: &Value) {
    let verdict = said["verdict"].as_str().unwrap();
    for key in ["rmse", "rmse_x", "rmse_y"] {
        assert!(number(&said["baseline"][key]) >= 0.0);
    }
    let bias = said["baseline"]["bias"].as_array().unwrap();
    assert_eq!(bias.iter().map(number).count(), 2);
    assert!(number(&said["noise_floor"]) > 0.0 && number(&said["final"]["rmse"]) > 0.0);
    assert!(
        said["next_postures"]["why"]
            .as_str()
            .is_some_and(|why| !why.is_empty())
    );
    let file = &said["next_postures"]["file"];
    assert!(file.is_null() || file.is_string());
    assert_eq!(
        said["unexplained"].as_bool(),
        Some(verdict == "unexplained")
    );
    next_steps(said);
    let steps = said["steps"].as_array().unwrap();
    for step in steps {
        let keys: Vec<&str> = step
            .as_object()
            .unwrap()
            .keys()
            .map(String::as_str)
            .collect();
        let mut agreed = [
            "effect",
            "target",
            "site",
            "function",
            "parameters",
            "rmse_before",
            "rmse_after",
            "evidence",
            "sentence",
            "remedy",
        ];
        agreed.sort_unstable();
        let mut keys = keys;
        keys.sort_unstable();
        assert_eq!(keys, agreed);
        for quantity in step["parameters"].as_object().unwrap().values() {
            number(&quantity["value"]);
            assert!(number(&quantity["std"]) >= 0.0);
        }
        assert!(number(&step["rmse_after"]) < number(&step["rmse_before"]));
        number(&step["evidence"]);
        assert!(!step["sentence"].as_str().unwrap().is_empty());
    }
    if let Some(last) = steps.last() {
        assert_eq!(last["rmse_after"], said["final"]["rmse"]);
    }
    // Complete explanations, the reported one first.
    let groups = said["indistinguishable"].as_array().unwrap();
    let reported = labels(said);
    match groups.first() {
        None => assert!(reported.is_empty()),
        Some(first) => {
            let first = first.as_array().unwrap().iter();
            let mut first: Vec<&str> = first.map(|label| label.as_str().unwrap()).collect();
            let mut reported: Vec<&str> = reported.iter().map(String::as_str).collect();
            first.sort_unstable();
            reported.sort_unstable();
            assert_eq!(first, reported);
        }
    }
    let count = groups.len();
    match verdict {
        "none" | "absorbed" => assert!(reported.is_empty() && count == 0),
        "named" => assert_eq!(count, 1),
        "class" => assert!(count > 1),
        "unexplained" => assert!(count <= 1),
        other => panic!("`{other}` is no verdict"),
    }
}

/// Postures of a file, its columns in the order of the joints.
pub fn postures(path: &str, joints: &[String]) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places: Vec<usize> = joints
        .iter()
        .map(|joint| header.iter().position(|name| name == joint).unwrap())
        .collect();
    lines
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            places.iter().map(|&at| cells[at]).collect()
        })
        .collect()
}
