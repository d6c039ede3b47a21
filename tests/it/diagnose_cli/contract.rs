//! Verdicts, their keys, their bytes.

use std::fs;

use sesc_test_support::command::{folder, op2, sesc, stdout};
use sesc_test_support::hidden::{Effect, NOWHERE};
use sesc_test_support::trial::{Question, Trial};

use super::asking::*;

#[test]
fn every_verdict_has_the_keys_of_the_contract() {
    let folder = folder();
    let offset = || vec![hidden(Effect::SensorOffset, NOWHERE, &[0.005, -0.004])];
    for (verdict, truth, prior) in [
        ("none", vec![], "tight"),
        (
            "named",
            vec![hidden(Effect::SensorRotation, NOWHERE, &[0.1])],
            "tight",
        ),
        (
            "class",
            vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.008])],
            "tight",
        ),
        ("absorbed", offset(), "free"),
        (
            "unexplained",
            vec![hidden(Effect::KneeSine, "r_knee", &[0.006])],
            "tight",
        ),
    ] {
        let log = logged(folder.path(), verdict, truth);
        let said = diagnose(&log, &["--prior", prior]);
        assert_eq!(said["verdict"], verdict, "{}", said["sentence"]);
        as_agreed(&said);
    }
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let folder = folder();
    let log = logged(
        folder.path(),
        "log",
        // One of a class: there are postures that would tell.
        vec![hidden(Effect::JointOffset, "r_ank_roll", &[0.01])],
    );
    let names = [
        "model.toml",
        "corrected.urdf",
        "report.html",
        "next.csv",
        "next.csv.toml",
    ];
    let urdf_file = op2();
    let run = || {
        let paths = names
            .iter()
            .map(|name| folder.path().join(name).display().to_string());
        let paths: Vec<String> = paths.collect();
        let [model, urdf, report, next, _] = &paths[..] else {
            unreachable!("there are five files")
        };
        let arguments = [
            "diagnose", &urdf_file, "--data", &log, "--out", model, "--urdf", urdf, "--report",
            report, "--next", next, "--prior", "tight", "--json",
        ];
        let said = stdout(&sesc(&arguments));
        let files: Vec<Vec<u8>> = paths.iter().map(|path| fs::read(path).unwrap()).collect();
        paths.iter().for_each(|path| fs::remove_file(path).unwrap());
        (said, files)
    };
    let (once, again) = (run(), run());
    assert_eq!(once.0, again.0);
    for (name, (a, b)) in names.iter().zip(once.1.iter().zip(&again.1)) {
        assert!(!a.is_empty() && a == b, "{name}");
    }
}

/// The first draw of this effect that is clear beyond doubt and logged as wanted.
fn clear(effect: Effect, wanted: &str) -> Trial {
    (0..)
        .map(|seed| Trial::draw(Question::Library(1), &only(Some(effect)), seed))
        .find(|trial| {
            let folder = folder();
            let csv = trial.log.write(folder.path(), "log");
            let text = fs::read_to_string(csv).unwrap();
            trial.chi2 > 1500.0 && text.lines().next().unwrap().contains(wanted)
        })
        .unwrap()
}

#[test]
fn faulty_cells_and_late_angles_are_named() {
    let folder = folder();
    for (effect, wanted) in [(Effect::CellGain, "fsr_4"), (Effect::TimeDelay, ",t,")] {
        let trial = clear(effect, wanted);
        let csv = trial.log.write(folder.path(), effect.name());
        let said = diagnose(&csv.display().to_string(), &[]);
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
        let pull = (number(&found["value"]) - truth) / number(&found["std"]);
        // A motion known by its samples alone is not known exactly.
        assert!(pull.abs() < 5.0, "{found} is not {truth}");
        as_agreed(&said);
    }
}
