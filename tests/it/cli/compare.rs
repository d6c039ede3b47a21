//! `sesc compare` on model files that `fit` and `diagnose` wrote, and on logs.

use serde_json::Value;
use sesc_test_support::command::{Folder, ROOT};

/// Logs of the OP2 on two days, the second of a robot with `hidden`, and their models by `command`.
fn two_days(hidden: &str, command: &str) -> Folder {
    let folder = Folder::with("op2");
    for (day, seed, hidden) in [("monday", 1, ""), ("friday", 2, hidden)] {
        let noise = "--poses 60 --noise 0.0005";
        folder.simulate(&format!("{noise} --seed {seed} --out {day}.csv {hidden}"));
        if !command.is_empty() {
            let files = format!("--data {day}.csv --out {day}_model.toml");
            folder.stdout(&format!("{command} op2.urdf --noise 0.0005 {files}"));
        }
    }
    folder
}

const MODELS: &str = "compare monday_model.toml friday_model.toml";

#[test]
fn two_logs_of_one_robot_differ_by_chance_alone() {
    let folder = two_days("", "fit");
    let json = folder.json(MODELS);
    assert_eq!(json["schema"], 1);
    assert_eq!(json["robot"], "op2");
    assert_eq!(json["changed"], false, "{}", json["sentence"]);
    assert!(json["chance"].as_f64().unwrap() > 0.01);
    assert_eq!(json["parameters"].as_array().unwrap().len(), 43);
    let text = folder.stdout(MODELS);
    assert!(text.contains("by no more than chance"), "{text}");
    // What stands on another link is another model.
    let other = folder.read("friday_model.toml");
    folder.write(
        "friday_model.toml",
        other.replace("\"r_sole\"", "\"l_sole\""),
    );
    folder.refuses(MODELS, &["friday_model.toml", "`l_sole`", "`r_sole`"]);
}

#[test]
fn a_payload_between_two_fits_is_a_change() {
    let folder = two_days("--hide payload:body_link=0.3kg,0.03,0.02,0.05", "fit");
    let json = folder.json(MODELS);
    assert_eq!(json["changed"], true, "{}", json["sentence"]);
    assert!(json["chance"].as_f64().unwrap() < 1e-6);
}

/// Logs are diagnosed and compared on a page, as their model files are.
#[test]
fn an_effect_that_appeared_is_named_with_its_size() {
    let folder = two_days("--hide joint_offset:r_knee=3deg", "");
    for day in ["monday", "friday"] {
        let files = format!("--data {day}.csv --out {day}_model.toml");
        folder.stdout(&format!("diagnose op2.urdf {files}"));
    }
    let by_models = folder.json(MODELS);
    assert_eq!(by_models["changed"], true);
    let effect = &by_models["effects"][0];
    assert_eq!(effect["effect"], "joint_offset");
    assert_eq!(effect["target"], "r_knee");
    assert_eq!(effect["change"], "appeared");
    assert_eq!(effect["parameters"][0]["before"], Value::Null);
    let after = effect["parameters"][0]["after"].as_f64().unwrap();
    assert!((after - 3.0_f64.to_radians()).abs() < 0.01, "{after}");
    let text = folder.stdout(MODELS);
    assert!(text.contains("appeared") && text.contains('°'), "{text}");

    let json = folder.json("compare monday.csv friday.csv --urdf op2.urdf --report page.html");
    assert_eq!(json["effects"], by_models["effects"]);
    let close = |a: &Value, b: &Value| (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-6;
    assert!(close(&json["chi2"], &by_models["chi2"]), "{json}");
    // A URDF beside model files is that of one of them, with a page or without.
    folder.stdout(&format!("{MODELS} --urdf op2.urdf"));
    let arm = format!("{MODELS} --urdf {ROOT}/robots/arm6/arm6.urdf");
    folder.refuses(&arm, &["made for robot hash", "arm6.urdf has"]);
    let logs = "compare monday.csv friday.csv";
    folder.refuses(logs, &["monday.csv is a log", "--urdf", "diagnose --out"]);
    let html = folder.read("page.html");
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
