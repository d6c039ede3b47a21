//! The log of the next experiment, taken and given back.

use std::fs;
use std::path::Path;

use serde_json::Value;
use sesc_reference::{Robot, World};
use sesc_test_support::command::{folder, op2, refused, sesc, write};
use sesc_test_support::hidden::Effect;

use super::asking::*;

/// What `--next` asked for, taken and given back with `--then`.
#[test]
fn the_log_of_the_next_experiment_is_taken_with_the_first() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let log = logged(
        folder.path(),
        "log",
        vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.01])],
    );
    let [next, model] = ["next.csv", "model.toml"].map(path);
    let before = diagnose(&log, &["--next", &next]);
    assert_eq!(before["verdict"], "class");
    let side: toml::Table = fs::read_to_string(path("next.csv.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let (support, turned) = (side["support"].as_str().unwrap(), "turned");
    assert_eq!(side["experiment"].as_str(), Some(turned));
    let robot = Robot::from_file(Path::new(&op2())).unwrap();
    let world = World::new(&robot, support).unwrap();
    let world = world.joint_offset("r_ank_roll", 0.01).unwrap();
    let joints: Vec<String> = robot.movable_joints().map(|j| j.name.clone()).collect();
    let mut text = format!(
        "pose,{},cop_x,cop_y,cop_x_std,cop_y_std\n",
        joints.join(",")
    );
    for (k, q) in postures(&next, &joints).iter().enumerate() {
        // Any numbers of the size of the noise.
        let noise = [7.1, 3.3].map(|step| 5e-4 * 1.4 * (step * k as f64).sin());
        let cop = world.cop(q);
        let angles: Vec<String> = q.iter().map(f64::to_string).collect();
        let [x, y] = [0, 1].map(|axis| cop[axis] + noise[axis]);
        text += &format!("{k},{},{x},{y},0.0005,0.0005\n", angles.join(","));
    }
    let second = write(folder.path(), "second.csv", &text);
    fs::copy(path("next.csv.toml"), path("second.csv.toml")).unwrap();
    let after = diagnose(&log, &["--then", &second, "--out", &model]);
    as_agreed(&after);
    let holds = |said: &Value, label: &str| {
        let groups = said["indistinguishable"].as_array().unwrap();
        groups.contains(&serde_json::json!([label]))
    };
    assert!(holds(&before, "ground_slope"));
    assert!(!holds(&after, "ground_slope"), "{}", after["sentence"]);
    assert!(
        holds(&after, "joint_offset:r_ank_roll"),
        "{}",
        after["sentence"]
    );
    assert_eq!(after["log"], "log.csv + second.csv");
    let file: toml::Table = fs::read_to_string(&model).unwrap().parse().unwrap();
    let used = file["data"].as_array().unwrap();
    assert_eq!(used[0]["file"].as_str(), Some("log.csv"));
    assert_eq!(used[1]["file"].as_str(), Some("second.csv"));
    // Rows that cannot be used are left out of it, as of the first log.
    let (_, rows) = text.split_once('\n').unwrap();
    let copied = write(folder.path(), "copied.csv", text.clone() + rows);
    fs::copy(path("next.csv.toml"), path("copied.csv.toml")).unwrap();
    let copied = diagnose(&log, &["--then", &copied]);
    assert_eq!(copied["steps"], after["steps"]);
    let warnings = copied["warnings"].as_array().unwrap();
    let is_it = |said: &Value| {
        let said = said.as_str().unwrap();
        said.contains("copied.csv: ") && said.contains("they are copies")
    };
    assert!(warnings.iter().any(is_it), "{warnings:?}");
    // What no log can say is refused, and so is another foot that is none.
    for (experiment, words) in [
        ("known_weight", ["known_weight", "Diagnose it alone"]),
        ("other_foot", ["other_foot", "mend"]),
    ] {
        let side = format!("support = \"r_sole\"\nexperiment = \"{experiment}\"\n");
        write(folder.path(), "second.csv.toml", side);
        let urdf = op2();
        let output = sesc(&["diagnose", &urdf, "--data", &log, "--then", &second]);
        refused(&output, &words);
    }
}
