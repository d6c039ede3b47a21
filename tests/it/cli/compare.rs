//! `sesc compare` on model files that `fit` and `diagnose` wrote.

use std::path::Path;

use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, op2, refused, sesc, stdout};

/// A log of the OP2 with its model by `command`, where `hidden` is or nothing.
fn model(folder: &Path, name: &str, seed: &str, hidden: &[&str], command: &str) -> String {
    let path = |suffix: &str| {
        folder
            .join(format!("{name}.{suffix}"))
            .display()
            .to_string()
    };
    let (log, model) = (path("csv"), path("toml"));
    let urdf = op2();
    let mut simulate = vec!["simulate", &urdf, "--support", "r_sole", "--poses", "60"];
    simulate.extend(["--noise", "0.0005", "--seed", seed, "--out", &log]);
    for what in hidden {
        simulate.extend(["--hide", what]);
    }
    stdout(&sesc(&simulate));
    let model = model.replace(".toml", "_model.toml");
    let made = sesc(&[
        command, &urdf, "--data", &log, "--noise", "0.0005", "--out", &model,
    ]);
    stdout(&made);
    model
}

fn compared(before: &str, after: &str) -> Value {
    let output = sesc(&["compare", before, after, "--json"]);
    serde_json::from_str(&stdout(&output)).unwrap()
}

#[test]
fn two_logs_of_one_robot_differ_by_chance_alone() {
    let folder = folder();
    let monday = model(folder.path(), "monday", "1", &[], "fit");
    let friday = model(folder.path(), "friday", "2", &[], "fit");
    let json = compared(&monday, &friday);
    assert_eq!(json["schema"], 1);
    assert_eq!(json["robot"], "op2");
    assert_eq!(json["changed"], false, "{}", json["sentence"]);
    assert!(json["chance"].as_f64().unwrap() > 0.01);
    assert_eq!(json["parameters"].as_array().unwrap().len(), 43);
    let text = stdout(&sesc(&["compare", &monday, &friday]));
    assert!(text.contains("by no more than chance"), "{text}");
}

#[test]
fn a_payload_between_two_fits_is_a_change() {
    let folder = folder();
    let payload = ["payload:body_link=0.3kg,0.03,0.02,0.05"];
    let monday = model(folder.path(), "monday", "1", &[], "fit");
    let friday = model(folder.path(), "friday", "2", &payload, "fit");
    let json = compared(&monday, &friday);
    assert_eq!(json["changed"], true, "{}", json["sentence"]);
    assert!(json["chance"].as_f64().unwrap() < 1e-6);
}

#[test]
fn an_effect_that_appeared_is_named_with_its_size() {
    let folder = folder();
    let offset = ["joint_offset:r_knee=3deg"];
    let monday = model(folder.path(), "monday", "1", &[], "diagnose");
    let friday = model(folder.path(), "friday", "2", &offset, "diagnose");
    let json = compared(&monday, &friday);
    assert_eq!(json["changed"], true);
    let effect = &json["effects"][0];
    assert_eq!(effect["effect"], "joint_offset");
    assert_eq!(effect["target"], "r_knee");
    assert_eq!(effect["change"], "appeared");
    assert_eq!(effect["parameters"][0]["before"], Value::Null);
    let after = effect["parameters"][0]["after"].as_f64().unwrap();
    assert!((after - 3.0_f64.to_radians()).abs() < 0.01, "{after}");
    let text = stdout(&sesc(&["compare", &monday, &friday]));
    assert!(text.contains("appeared") && text.contains('°'), "{text}");
}

#[test]
fn models_on_other_supports_are_refused() {
    let folder = folder();
    let monday = model(folder.path(), "monday", "1", &[], "fit");
    let text = std::fs::read_to_string(&monday).unwrap();
    let other = folder.path().join("other.toml").display().to_string();
    std::fs::write(&other, text.replace("\"r_sole\"", "\"l_sole\"")).unwrap();
    let output = sesc(&["compare", &monday, &other]);
    refused(&output, &["other.toml", "`l_sole`", "`r_sole`"]);
}

/// A log of the OP2, with `hidden` or nothing in it.
fn log(folder: &Path, name: &str, seed: &str, hidden: &[&str]) -> String {
    let log = folder.join(name).display().to_string();
    let urdf = op2();
    let mut simulate = vec!["simulate", &urdf, "--support", "r_sole", "--poses", "60"];
    simulate.extend(["--noise", "0.0005", "--seed", seed, "--out", &log]);
    simulate.extend(hidden.iter().flat_map(|what| ["--hide", what]));
    stdout(&sesc(&simulate));
    log
}

#[test]
fn two_logs_are_diagnosed_and_compared_on_a_page() {
    let folder = folder();
    let monday = log(folder.path(), "monday.csv", "1", &[]);
    let friday = log(
        folder.path(),
        "friday.csv",
        "2",
        &["joint_offset:r_knee=3deg"],
    );
    let page = folder.path().join("page.html").display().to_string();
    let urdf = op2();
    let words = ["compare", &monday, &friday, "--urdf", &urdf];
    let said = stdout(&sesc(
        &[&words[..], &["--report", &page, "--json"]].concat(),
    ));
    let json: Value = serde_json::from_str(&said).unwrap();
    let effect = &json["effects"][0];
    assert_eq!(
        [&effect["target"], &effect["change"]],
        ["r_knee", "appeared"]
    );
    // The same as by way of model files.
    let models = [&monday, &friday].map(|log| {
        let model = log.replace(".csv", ".toml");
        stdout(&sesc(&["diagnose", &urdf, "--data", log, "--out", &model]));
        model
    });
    let by_models = compared(&models[0], &models[1]);
    assert_eq!(json["effects"], by_models["effects"]);
    let close = |a: &Value, b: &Value| (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-6;
    assert!(close(&json["chi2"], &by_models["chi2"]), "{json}");
    // A URDF beside model files is that of one of them, with a page or without.
    let arm = format!("{ROOT}/robots/arm6/arm6.urdf");
    let beside = |urdf: &str| sesc(&["compare", &models[0], &models[1], "--urdf", urdf]);
    stdout(&beside(&urdf));
    refused(&beside(&arm), &["made for robot hash", "arm6.urdf has"]);
    let html = std::fs::read_to_string(&page).unwrap();
    for words in [
        "friday.csv differs from monday.csv",
        "an offset of r_knee (joint_offset:r_knee)",
        "60 rows, hash ",
    ] {
        assert!(html.contains(words), "{words}");
    }
    // Two of the robot, and the deviations.
    assert_eq!(html.matches("<svg ").count(), 3);
}

#[test]
fn logs_without_a_robot_are_refused_with_the_remedy() {
    let folder = folder();
    let monday = log(folder.path(), "monday.csv", "1", &[]);
    let friday = log(folder.path(), "friday.csv", "2", &[]);
    let output = sesc(&["compare", &monday, &friday]);
    refused(
        &output,
        &["monday.csv is a log", "--urdf", "diagnose --out"],
    );
}
