//! The command line as its users meet it: contracts of the JSON, files that
//! appear whole or not at all, what the commands say.

mod answers;
mod compare;
mod defaults;
mod ignored;
mod manners;
mod model_files;
mod next;
mod pipes;
mod processors;
mod sole;
mod streams;
mod unfinished;

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc, stdout, write};

#[test]
fn inspect_reports_what_the_contract_says() {
    let output = sesc(&["inspect", &op2(), "--support", "r_sole", "--json"]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["dof"], 20);
    assert_eq!(json["bodies"], 21);
    assert_eq!(json["full_params"], 63);
    assert_eq!(json["base_params"], 43);
    assert_eq!(json["rank"], serde_json::json!({"xyz": 43, "cop": 42}));
    assert_eq!(json["joints"].as_array().unwrap().len(), 20);
    assert_eq!(json["operations"]["com"]["mul"], 80);
    assert_eq!(json["operations"]["com"]["sin_cos"], 20);
    assert!(json["rounding_bound"]["com"]["f32"].as_f64().unwrap() < 3e-6);
    let unobservable = json["unobservable"].as_array().unwrap();
    assert!(unobservable.iter().any(|u| {
        u["sentence"]
            .as_str()
            .unwrap()
            .contains("along the axis of `l_knee` moves to its parent")
    }));
    // The elbows are written as 1.57079633.
    assert_eq!(json["snaps"].as_array().unwrap().len(), 2);
    let literal = sesc(&in_words(
        "inspect @ --support r_sole --json --no-snap",
        &[&op2()],
    ));
    let json: Value = serde_json::from_str(&stdout(&literal)).unwrap();
    assert_eq!(json["snaps"], serde_json::json!([]));
}

#[test]
fn verify_reports_errors_and_bounds() {
    let output = sesc(&in_words(
        "verify @ --support l_sole --samples 200 --json",
        &[&op2()],
    ));
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["pass"], true);
    assert!(json["samples"].as_u64().unwrap() >= 200);
    for function in [
        "com",
        "com_jacobian",
        "gravity_moments",
        "regressor",
        "regressor_cop",
        "cop",
        "zmp",
    ] {
        let error = json["worst_error"][function].as_f64().unwrap();
        assert!(
            error <= json["bound"][function].as_f64().unwrap(),
            "{function}"
        );
    }
}

#[test]
fn generate_writes_once_and_leaves_the_same_bytes_alone() {
    let folder = folder();
    let out = folder.path().join("new/src").display().to_string();
    let run = || {
        sesc(&in_words(
            "generate @ --support r_sole --name op2_r_sole --out @",
            &[&op2(), &out],
        ))
    };
    let path = PathBuf::from(stdout(&run()).trim());
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        fs::read_to_string(format!("{ROOT}/generated/src/op2_r_sole.rs")).unwrap()
    );
    let before = fs::metadata(&path).unwrap().modified().unwrap();
    stdout(&run());
    assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), before);
    assert_eq!(
        fs::read_dir(path.parent().unwrap()).unwrap().count(),
        1,
        "no leftovers"
    );
}

/// simulate → predict: a noise-free log is what predict says, to the last digit.
#[test]
fn predict_reads_back_what_simulate_wrote() {
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let urdf = op2();
    let simulate = "simulate @ --support r_sole --poses 50 --range 30 --out @";
    let simulate = in_words(simulate, &[&urdf, &log]);
    stdout(&sesc(&simulate));
    let first = fs::read_to_string(&log).unwrap();
    stdout(&sesc(&simulate));
    assert_eq!(
        first,
        fs::read_to_string(&log).unwrap(),
        "same seed, same log"
    );
    // The support comes from the sidecar.
    let predicted = stdout(&sesc(&["predict", &op2(), "--data", &log]));
    assert_eq!(
        predicted.lines().next(),
        Some("pose,com_x,com_y,com_z,cop_x,cop_y")
    );
    for (row, line) in predicted.lines().skip(1).zip(first.lines().skip(1)) {
        let predicted: Vec<&str> = row.split(',').collect();
        let logged: Vec<&str> = line.split(',').collect();
        assert_eq!(predicted[4..], logged[21..], "pose {}", predicted[0]);
        assert_eq!(
            predicted[1..3],
            predicted[4..],
            "level ground: CoP is below the CoM"
        );
    }
    assert_eq!(predicted.lines().count(), 51);
}

#[test]
fn predict_follows_gravity_supports_and_degrees() {
    let folder = folder();
    let urdf = write(
        folder.path(),
        "pole.urdf",
        "<robot name='pole'><link name='foot'/><link name='top'><inertial><mass value='2'/></inertial></link>\
         <joint name='hip' type='revolute'><parent link='foot'/><child link='top'/>\
         <origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>",
    );
    let log = write(
        folder.path(),
        "a.csv",
        "hip,pose,support\n90,7,foot\n0,9,top\n",
    );
    // Gravity leans 0.1 to the front: the CoP runs ahead by 0.1 m per metre of height.
    write(
        folder.path(),
        "a.toml",
        "gravity = [0.980665, 0.0, -9.80665]\n",
    );
    let predicted = stdout(&sesc(&["predict", &urdf, "--data", &log, "--degrees"]));
    assert_eq!(predicted.lines().nth(1), Some("7,0,0,1,0.1,0"));
    assert_eq!(predicted.lines().nth(2), Some("9,0,0,0,0,0"));
    refused(
        &sesc(&["predict", &urdf, "--data", &log]),
        &["a.csv:2", "`hip`", "--degrees"],
    );
}

#[test]
fn every_command_helps_with_an_example() {
    for command in [
        "inspect", "generate", "verify", "simulate", "plan", "predict", "fit", "diagnose", "demo",
    ] {
        let text = stdout(&sesc(&[command, "--help"]));
        assert!(
            ["Example", "Examples"]
                .iter()
                .any(|title| text.contains(&format!("{title}:\n  sesc {command}"))),
            "{text}"
        );
        if ["predict", "fit", "diagnose"].contains(&command) {
            let columns = sesc_identify::logs::columns_text();
            assert!(text.contains(&columns), "{text}");
        }
    }
}

#[test]
fn the_demo_finds_what_the_paper_and_theory_say() {
    let folder = folder();
    let page = folder.path().join("demo.html").display().to_string();
    let text = stdout(&sesc(&["demo", "--out", &page]));
    let number = |line: &str| -> f64 {
        let line = text
            .lines()
            .find(|l| l.contains(line))
            .unwrap_or_else(|| panic!("{text}"));
        line.split_whitespace()
            .find_map(|word| word.parse().ok())
            .unwrap()
    };
    assert!(
        (3.9..=4.02).contains(&number("against noisy readings")),
        "{text}"
    );
    assert!(
        (0.6..=0.85).contains(&number("against the true CoP")),
        "{text}"
    );
    let html = fs::read_to_string(&page).unwrap();
    assert!(
        html.contains("<svg") && !html.contains("src=\"http"),
        "self-contained"
    );
}
