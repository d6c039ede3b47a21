//! Verdicts, their keys, their bytes; the log of the next experiment, taken and given back.

use std::fs;

use serde_json::{Value, json};
use sesc_reference::World;
use sesc_test_support::command::{Folder, list, number, says, texts};
use sesc_test_support::hidden::{Effect, Hidden, NOWHERE};
use sesc_test_support::stage::{Platform, Stage};
use sesc_test_support::trial::{Choice, Question, Trial};

use super::{as_agreed, diagnose, labels, logged, logged_all};

#[test]
fn every_verdict_has_the_keys_of_the_contract() {
    let offset = Hidden::new(Effect::SensorOffset, NOWHERE, &[0.005, -0.004]);
    for (verdict, folder, prior) in [
        ("none", logged(&[]), "tight"),
        (
            "named",
            logged(&[(Effect::SensorRotation, NOWHERE, 0.1)]),
            "tight",
        ),
        (
            "class",
            logged(&[(Effect::JointOffset, "r_ank_roll", 0.008)]),
            "tight",
        ),
        ("absorbed", logged_all(vec![offset]), "free"),
        (
            "unexplained",
            logged(&[(Effect::KneeSine, "r_knee", 0.006)]),
            "tight",
        ),
    ] {
        let said = diagnose(&folder, &format!("--prior {prior}"));
        assert_eq!(said["verdict"], verdict, "{}", said["sentence"]);
        as_agreed(&said);
    }
}

/// One of a class: there are postures that would tell.
#[test]
fn the_same_command_gives_the_same_bytes() {
    let folder = logged(&[(Effect::JointOffset, "r_ank_roll", 0.01)]);
    let line = "diagnose op2.urdf --data log.csv --prior tight --json --out model.toml \
                --urdf corrected.urdf --report report.html --next next.csv";
    let written = "corrected.urdf model.toml next.csv next.csv.toml report.html".split(' ');
    let before = folder.names().len();
    let run = || {
        let said = folder.stdout(line);
        assert_eq!(folder.names().len(), before + 5);
        let files = written.clone().map(|name| {
            let bytes = fs::read(folder.join(name)).unwrap();
            assert!(!bytes.is_empty(), "{name}");
            fs::remove_file(folder.join(name)).unwrap();
            bytes
        });
        (said, files.collect::<Vec<_>>())
    };
    let (once, again) = (run(), run());
    assert_eq!(once.0, again.0);
    assert!(once.1 == again.1);
}

/// The first draw of this effect that is clear beyond doubt and logged as wanted.
fn clear(effect: Effect, wanted: &str) -> (Trial, Folder) {
    let choice = Choice {
        only: Some(effect),
        ..Choice::on(Platform::Op2)
    };
    let draws = (0..).map(|seed| {
        let trial = Trial::draw(Question::Library(1), &choice, seed);
        let folder = Folder::with("op2");
        trial.log.write(folder.path(), "log");
        (trial, folder)
    });
    let is_clear = |(trial, folder): &(Trial, Folder)| {
        trial.chi2 > 1500.0 && folder.sheet("log.csv").names.contains(&wanted.to_string())
    };
    draws.into_iter().find(is_clear).unwrap()
}

#[test]
fn faulty_cells_and_late_angles_are_named() {
    for (effect, wanted) in [(Effect::CellGain, "fsr_4"), (Effect::TimeDelay, "t")] {
        let (trial, folder) = clear(effect, wanted);
        let said = diagnose(&folder, "");
        assert_eq!(
            labels(&said),
            [trial.hidden[0].label()],
            "{}",
            said["sentence"]
        );
        let truth = trial.hidden[0].values[0];
        let (name, truth) = match effect {
            Effect::CellGain => ("gain", 1.0 + truth),
            _ => ("delay_s", truth),
        };
        let found = &said["steps"][0]["parameters"][name];
        let pull = (number(found, "/value") - truth) / number(found, "/std");
        // A motion known by its samples alone is not known exactly.
        assert!(pull.abs() < 5.0, "{found} is not {truth}");
        as_agreed(&said);
    }
}

/// What `--next` asked for, taken and given back with `--then`.
#[test]
fn the_log_of_the_next_experiment_is_taken_with_the_first() {
    let folder = logged(&[(Effect::JointOffset, "r_ank_roll", 0.01)]);
    let before = diagnose(&folder, "--next next.csv");
    assert_eq!(before["verdict"], "class");
    let side = folder.toml("next.csv.toml");
    assert_eq!(side["experiment"].as_str(), Some("turned"));
    let stage = Stage::new(Platform::Op2);
    let world = World::new(&stage.robot, side["support"].as_str().unwrap());
    let world = world.unwrap().joint_offset("r_ank_roll", 0.01).unwrap();
    let mut second = folder.sheet("next.csv");
    let joints = stage.joint_names();
    let cop: Vec<[f64; 2]> = second
        .numbers(&joints)
        .iter()
        .map(|q| world.cop(q))
        .collect();
    // Any numbers of the size of the noise.
    for (axis, (name, step)) in [("cop_x", 7.1_f64), ("cop_y", 3.3)].into_iter().enumerate() {
        let noise = |k: usize| 5e-4 * 1.4 * (step * k as f64).sin();
        second.add(name, |k| (cop[k][axis] + noise(k)).to_string());
        second.add(&format!("{name}_std"), |_| "0.0005".to_string());
    }
    let give = |name: &str, text: String| {
        folder.write(name, text);
        folder.write(&format!("{name}.toml"), folder.read("next.csv.toml"));
        diagnose(&folder, &format!("--then {name} --out model.toml"))
    };
    let after = give("second.csv", second.to_string());
    as_agreed(&after);
    let holds =
        |said: &Value, label: &str| list(said, "/indistinguishable").contains(&json!([label]));
    assert!(holds(&before, "ground_slope"));
    assert!(!holds(&after, "ground_slope"), "{}", after["sentence"]);
    assert!(
        holds(&after, "joint_offset:r_ank_roll"),
        "{}",
        after["sentence"]
    );
    assert_eq!(after["log"], "log.csv + second.csv");
    let file = folder.toml("model.toml");
    let used = file["data"].as_array().unwrap();
    let files: Vec<_> = used
        .iter()
        .map(|own| own["file"].as_str().unwrap())
        .collect();
    assert_eq!(files, ["log.csv", "second.csv"]);
    // Rows that cannot be used are left out of it, as of the first log.
    second.rows.extend_from_within(..);
    let copied = give("copied.csv", second.to_string());
    assert_eq!(copied["steps"], after["steps"]);
    let warnings = texts(&copied, "/warnings").join("\n");
    says(warnings, &["copied.csv: ", "they are copies"]);
    // What no log can say is refused, and so is another foot that is none.
    for (experiment, remedy) in [
        ("known_weight", "Diagnose it alone"),
        ("other_foot", "mend"),
    ] {
        let side = format!("support = \"r_sole\"\nexperiment = \"{experiment}\"\n");
        folder.write("second.csv.toml", side);
        let line = "diagnose op2.urdf --data log.csv --then second.csv";
        folder.refuses(line, &[experiment, remedy]);
    }
}
