//! A URDF from a pipe: read once, by its name or as `-`.

use std::process::Stdio;

use sesc_test_support::command::{Folder, refused, stdout};

/// The pipe itself, as `<(xacro robot.xacro)` gives it, and standard input by its sign.
const NAMES: [&str; 2] = ["/dev/stdin", "-"];

#[test]
fn commands_read_a_urdf_from_a_pipe() {
    let folder = Folder::with_log("--poses 60");
    let piped = |line: &str| stdout(&folder.piped(line, "op2.urdf"));
    // Steps to take next have the path that was typed.
    let found = |json: String| json.split("\"next_steps\"").next().unwrap().to_string();
    let inspect = |urdf: &str| format!("inspect {urdf} --support r_sole --json");
    let inspected = found(folder.stdout(&inspect("op2.urdf")));
    folder.stdout("fit op2.urdf --data log.csv --urdf file.urdf");
    for name in NAMES {
        assert_eq!(found(piped(&inspect(name))), inspected);
        piped(&format!("verify {name} --support r_sole --samples 20"));
        piped(&format!("fit {name} --data log.csv --urdf pipe.urdf"));
        assert_eq!(folder.read("pipe.urdf"), folder.read("file.urdf"));
    }
}

#[test]
fn faults_of_standard_input_say_so() {
    let folder = Folder::with("op2");
    let mut command = folder.command("inspect - --support foot");
    let output = command.stdin(Stdio::null()).output().unwrap();
    refused(&output, &["standard input: the file is empty"]);
    folder.write("-", folder.read("op2.urdf"));
    folder.stdout("inspect ./- --support r_sole");
}

/// `<(zcat log.csv.gz)` in the place of a log, which is read more than once.
#[test]
fn a_log_from_a_pipe_gives_what_its_file_gives() {
    let folder = Folder::with_log("--poses 60");
    for (command, key) in [("fit", "parameters"), ("diagnose", "baseline")] {
        let line = |log: &str| format!("{command} op2.urdf --data {log} --support r_sole --json");
        let found = |json: String| {
            let found: serde_json::Value = serde_json::from_str(&json).unwrap();
            found[key].clone()
        };
        let of_file = found(folder.stdout(&line("log.csv")));
        assert!(!of_file.is_null());
        let piped = stdout(&folder.piped(&line("/dev/stdin"), "log.csv"));
        assert_eq!(found(piped), of_file, "{command}");
    }
}
