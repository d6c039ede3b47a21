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
