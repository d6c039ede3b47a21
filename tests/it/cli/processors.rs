//! One processor or several: the same answers, to the last bit.

use std::fs;
use std::process::Command;

use sesc_test_support::command::{folder, op2, program, sesc, stdout};

/// A processor that this process may use.
fn a_processor() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let allowed = status
        .lines()
        .find_map(|line| line.strip_prefix("Cpus_allowed_list:"))
        .unwrap();
    let first = |list: &str| list.split([',', '-']).next().unwrap().trim().to_string();
    first(allowed)
}

/// What a command says on one processor; it says the same on all.
fn says(arguments: &[&str]) -> String {
    let one = Command::new("taskset")
        .args(["--cpu-list", &a_processor()])
        .arg(program())
        .args(arguments)
        .output()
        .unwrap();
    let one = stdout(&one);
    assert!(one == stdout(&sesc(arguments)), "{arguments:?}");
    one
}

/// Rows are folded in on other processors from the first whole block on, and a robot in motion has
/// its polynomials there, too.
#[test]
#[cfg(target_os = "linux")]
fn fits_and_predictions_have_the_same_bits_on_one_processor() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let robot = op2();
    for (name, more) in [
        ("stand.csv", &["--noise", "0.002"][..]),
        ("move.csv", &["--noise", "0.001", "--rate", "100"][..]),
    ] {
        let log = at(name);
        let simulate = ["simulate", &robot, "--support", "r_sole", "--poses", "9000"];
        let range = ["--range", "30", "--seed", "3", "--out", &log];
        stdout(&sesc(&[&simulate[..], &range, more].concat()));
        let fit = says(&["fit", &robot, "--data", &log, "--json"]);
        assert!(fit.contains("\"covariance\"") || fit.contains("\"parameters\""));
        says(&["predict", &robot, "--data", &log]);
    }
}

/// Fields of a CSV file become numbers on all processors: each stays in its row and column.
#[test]
fn a_csv_file_has_the_numbers_of_the_same_log_in_parquet() {
    let (folder, robot) = (folder(), op2());
    let predicted = |name: &str| {
        let log = folder.path().join(name).display().to_string();
        let simulate = ["simulate", &robot, "--support", "r_sole", "--poses", "9000"];
        let range = ["--range", "30", "--seed", "3", "--out", &log];
        stdout(&sesc(&[&simulate[..], &range].concat()));
        stdout(&sesc(&["predict", &robot, "--data", &log]))
    };
    let of_csv = predicted("log.csv");
    assert_eq!(of_csv.lines().count(), 9001);
    assert!(of_csv == predicted("log.parquet"));
}

/// Hypotheses are fitted side by side, and functions are compared so.
#[test]
#[cfg(target_os = "linux")]
fn diagnoses_and_comparisons_have_the_same_bits_on_one_processor() {
    let (folder, robot) = (folder(), op2());
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = ["simulate", &robot, "--support", "r_sole", "--poses", "300"];
    let hidden = ["--hide", "joint_offset:r_knee=1.5deg", "--noise", "0.0005"];
    let range = ["--range", "30", "--seed", "3", "--out", &log];
    stdout(&sesc(&[&simulate[..], &range, &hidden].concat()));
    let diagnosis = says(&["diagnose", &robot, "--data", &log, "--json"]);
    assert!(diagnosis.contains("r_knee"), "{diagnosis}");
    let verify = ["verify", &robot, "--support", "r_sole"];
    let compared = says(&[&verify[..], &["--samples", "500"]].concat());
    assert!(compared.contains("pass on"), "{compared}");
}
