//! What `sesc fit` writes besides the model file, from the command line.

use std::fs;

use sesc_test_support::command::{folder, in_words, op2, refused, sesc, stdout};

/// A log of the OP2 as CAD has it, read with `noise` m; its path.
fn log(folder: &std::path::Path, poses: &str, noise: &str) -> String {
    let path = folder.join("log.csv").display().to_string();
    let words = ["simulate", &op2(), "--support", "r_sole", "--poses", poses];
    let more = [
        "--range", "30", "--noise", noise, "--seed", "4", "--out", &path,
    ];
    stdout(&sesc(&[&words[..], &more[..]].concat()));
    path
}

#[test]
fn a_corrected_robot_and_a_page_are_written() {
    let folder = folder();
    let data = log(folder.path(), "120", "0.0005");
    let [urdf, page] = ["corrected.urdf", "report.html"]
        .map(|name| folder.path().join(name).display().to_string());
    let fit = sesc(&in_words(
        "fit @ --data @ --support r_sole --urdf @ --total-mass 3.1 --physical --report @ --json",
        &[&op2(), &data, &urdf, &page],
    ));
    let json: serde_json::Value = serde_json::from_str(&stdout(&fit)).unwrap();
    assert_eq!(json["residuals"].as_array().unwrap().len(), 120);
    assert_eq!(json["active_bounds"].as_array().unwrap().len(), 0);
    assert_eq!(json["corrected"]["total_mass"], 3.1);
    let text = fs::read_to_string(&urdf).unwrap();
    let mass = sesc_reference::Robot::from_urdf(&text).unwrap();
    let mass: f64 = mass.links().iter().map(|link| link.mass_kg).sum();
    assert!((mass - 3.1).abs() < 1e-12, "{mass}");
    // What was fitted to the robot is CAD of the corrected one.
    let inspected = sesc(&["inspect", &urdf, "--support", "r_sole", "--json"]);
    assert!(stdout(&inspected).contains("base_params"));
    let page = fs::read_to_string(&page).unwrap();
    assert!(page.contains("On postures it never saw") && page.contains("--total-mass 3.1"));
}

#[test]
fn masses_that_cannot_be_are_refused_and_nothing_is_written() {
    let folder = folder();
    let data = log(folder.path(), "40", "0.02");
    let [urdf, model] = ["corrected.urdf", "model.toml"].map(|name| folder.path().join(name));
    let arguments = |more: &[&str]| {
        let first = ["fit", &op2(), "--data", &data, "--support", "r_sole"];
        sesc(&[&first[..], more].concat())
    };
    let [to_urdf, to_model] = [&urdf, &model].map(|path| path.display().to_string());
    let free = arguments(&["--prior", "free", "--urdf", &to_urdf, "--out", &to_model]);
    refused(
        &free,
        &[
            "no URDF has the identified parameters",
            "--physical",
            "Nothing was written",
        ],
    );
    assert!(!urdf.exists() && !model.exists());
    refused(&arguments(&["--urdf", &op2()]), &["is read here"]);
    refused(&arguments(&["--total-mass", "3"]), &["--urdf"]);
    refused(
        &arguments(&["--urdf", &to_urdf, "--total-mass", "0"]),
        &["--total-mass"],
    );
    let physical = arguments(&["--prior", "free", "--physical", "--urdf", &to_urdf]);
    assert!(stdout(&physical).contains("held by a bound"));
    assert!(urdf.exists());
}

/// A log that states no noise and repeats nothing is asked for five of its postures once more,
/// by both commands; one whose postures were all reached again is not.
#[test]
fn five_postures_are_named_where_nothing_tells_the_noise() {
    let folder = folder();
    let data = log(folder.path(), "90", "0.0005");
    let stated = fs::read_to_string(&data).unwrap();
    // Without the two columns of deviations.
    let text: String = stated
        .lines()
        .map(|row| row.rsplitn(3, ',').last().unwrap().to_string() + "\n")
        .collect();
    fs::write(&data, &text).unwrap();
    let poses: Vec<i64> = text
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    let ask = |command: &str, data: &str| -> (serde_json::Value, String) {
        let words = [command, &op2(), "--data", data, "--support", "r_sole"];
        let json = stdout(&sesc(&[&words[..], &["--json"]].concat()));
        (serde_json::from_str(&json).unwrap(), stdout(&sesc(&words)))
    };
    let mut named = Vec::new();
    for command in ["fit", "diagnose"] {
        let (json, said) = ask(command, &data);
        let again = json["again"]["poses"]
            .as_array()
            .unwrap_or_else(|| panic!("{command}"));
        let again: Vec<i64> = again.iter().map(|pose| pose.as_i64().unwrap()).collect();
        assert_eq!(again.len(), 5, "{command}");
        assert!(again.windows(2).all(|pair| pair[0] < pair[1]), "{again:?}");
        assert!(again.iter().all(|pose| poses.contains(pose)), "{again:?}");
        let list: Vec<String> = again.iter().map(i64::to_string).collect();
        let listed = format!("reach poses {} once more", list.join(", "));
        assert!(said.contains(&listed), "{said}");
        named.push(again);
    }
    assert_eq!(named[0], named[1]);
    // Each posture once more after all others, a little off.
    let mut twice = text.clone();
    for (k, row) in text.lines().skip(1).enumerate() {
        let (rest, y) = row.rsplit_once(',').unwrap();
        let off = 5e-4 * (7.0 * k as f64).sin();
        let y: f64 = y.parse().unwrap();
        twice += &format!("{rest},{:.6}\n", y + off);
    }
    let repeated = folder.path().join("twice.csv").display().to_string();
    fs::write(&repeated, twice).unwrap();
    for command in ["fit", "diagnose"] {
        let (json, _) = ask(command, &repeated);
        assert!(json.get("again").is_none(), "{command}: {}", json["again"]);
    }
}
