//! One processor or several: the same answers, to the last bit.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::Command;

use sesc_test_support::command::{Folder, program, stdout};

/// A processor that this process may use.
fn a_processor() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let mut lines = status.lines();
    let allowed = lines.find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    let first = allowed.unwrap().split([',', '-']).next();
    first.unwrap().trim().to_string()
}

/// What a command says on one processor; it says the same on all.
fn says(folder: &Folder, line: &str) -> String {
    let mut one = Command::new("taskset");
    one.args(["--cpu-list", &a_processor()]).arg(program());
    one.args(line.split(' ')).current_dir(folder.path());
    let one = stdout(&one.output().unwrap());
    assert!(one == folder.stdout(line), "{line}");
    one
}

/// Rows are folded in on other processors from the first whole block on, and a robot in motion has
/// its polynomials there, too. Fields of a CSV file become numbers on all processors: each stays in
/// its row and column, as in the same log in Parquet.
#[test]
fn fits_and_predictions_have_the_same_bits_on_one_processor() {
    let folder = Folder::with("op2");
    let log = "--poses 9000 --range 30 --seed 3";
    for more in ["--noise 0.002", "--noise 0.001 --rate 100"] {
        folder.simulate(&format!("{log} {more} --out log.csv"));
        let fit = says(&folder, "fit op2.urdf --data log.csv --json");
        assert!(fit.contains("\"parameters\""));
        says(&folder, "predict op2.urdf --data log.csv");
    }
    let predicted = ["log.csv", "log.parquet"].map(|name| {
        folder.simulate(&format!("{log} --out {name}"));
        folder.stdout(&format!("predict op2.urdf --data {name}"))
    });
    assert_eq!(predicted[0].lines().count(), 9001);
    assert!(predicted[0] == predicted[1]);
}

/// Hypotheses are fitted side by side, and functions are compared so.
#[test]
fn diagnoses_and_comparisons_have_the_same_bits_on_one_processor() {
    let hidden = "--hide joint_offset:r_knee=1.5deg --noise 0.0005";
    let folder = Folder::with_log(&format!("--poses 300 --range 30 --seed 3 {hidden}"));
    let diagnosis = says(&folder, "diagnose op2.urdf --data log.csv --json");
    assert!(diagnosis.contains("r_knee"), "{diagnosis}");
    let compared = says(&folder, "verify op2.urdf --support r_sole --samples 500");
    assert!(compared.contains("pass on"), "{compared}");
}
