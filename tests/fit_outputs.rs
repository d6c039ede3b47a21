//! What `sesc fit` writes besides the model file, from the command line.

use std::fs;

use sesc_test_support::command::{folder, op2, refused, sesc, stdout};

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
    let fit = sesc(&[
        "fit",
        &op2(),
        "--data",
        &data,
        "--support",
        "r_sole",
        "--urdf",
        &urdf,
        "--total-mass",
        "3.1",
        "--physical",
        "--report",
        &page,
        "--json",
    ]);
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
