//! A URDF from a pipe: read once, by its name or as `-`.

use std::fs;
use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use sesc_test_support::command::{folder, op2, refused, sesc, stdout, write};

/// `sesc` with the OP2's URDF on standard input.
fn piped(arguments: &[&str]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sesc"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(&fs::read(op2()).unwrap()).unwrap();
    drop(stdin);
    child.wait_with_output().unwrap()
}

/// The pipe itself, as `<(xacro robot.xacro)` gives it, and standard input by its sign.
const NAMES: [&str; 2] = ["/dev/stdin", "-"];

#[test]
fn inspect_and_verify_read_a_pipe() {
    let json = ["--support", "r_sole", "--json"];
    // Steps to take next have the path that was typed.
    let found = |json: String| json.split("\"next_steps\"").next().unwrap().to_string();
    let inspected = stdout(&sesc(&[&["inspect", &op2()][..], &json].concat()));
    for name in NAMES {
        let output = piped(&[&["inspect", name][..], &json].concat());
        assert_eq!(found(stdout(&output)), found(inspected.clone()));
        let verify = ["verify", name, "--support", "r_sole", "--samples", "20"];
        stdout(&piped(&verify));
    }
}

#[test]
fn fit_writes_the_corrected_urdf_of_a_pipe() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let log = at("log.csv");
    let support = ["--support", "r_sole"];
    let simulate = ["simulate", &op2(), "--poses", "60", "--out", &log];
    stdout(&sesc(&[&simulate[..], &support].concat()));
    let fit = |urdf: &str, out: &str, run: &dyn Fn(&[&str]) -> Output| {
        let arguments = ["fit", urdf, "--data", &log, "--urdf", out];
        stdout(&run(&arguments));
        fs::read_to_string(out).unwrap()
    };
    let expected = fit(&op2(), &at("file.urdf"), &sesc);
    for name in NAMES {
        assert_eq!(fit(name, &at("pipe.urdf"), &piped), expected);
    }
}

#[test]
fn faults_of_standard_input_say_so() {
    let output = Command::new(env!("CARGO_BIN_EXE_sesc"))
        .args(["inspect", "-", "--support", "foot"])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    refused(&output, &["standard input: the file is empty"]);
    let folder = folder();
    let named = write(folder.path(), "-", fs::read(op2()).unwrap());
    stdout(&sesc(&["inspect", &named, "--support", "r_sole"]));
}
