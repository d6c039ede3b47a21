//! `-` for logs, tables and model files, and predictions in files.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, program, refused, stdout};

/// A folder with a robot and a log of it.
struct Inputs(tempfile::TempDir);

impl Inputs {
    fn new() -> Inputs {
        let inputs = Inputs(folder());
        let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
        fs::copy(urdf, inputs.path("a.urdf")).unwrap();
        stdout(&inputs.run(
            "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out log.csv",
            None,
        ));
        inputs
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `sesc` with these words, and a file on its standard input.
    fn run(&self, line: &str, input: Option<&Path>) -> Output {
        let mut command = Command::new(program());
        command.current_dir(self.0.path()).args(line.split(' '));
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        if let Some(path) = input {
            stdin.write_all(&fs::read(path).unwrap()).unwrap();
        }
        drop(stdin);
        child.wait_with_output().unwrap()
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }
}

/// The format is told by the first bytes, as that of a file.
#[test]
fn logs_are_read_from_standard_input() {
    let inputs = Inputs::new();
    let simulate = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out";
    let mut logs = vec!["log.csv", "log.csv.gz"];
    logs.extend(cfg!(feature = "parquet").then_some("log.parquet"));
    for log in logs {
        stdout(&inputs.run(&format!("{simulate} {log}"), None));
        let path = inputs.path(log);
        for command in [
            "predict a.urdf --support foot",
            "fit a.urdf --support foot --json",
        ] {
            let of_file = stdout(&inputs.run(&format!("{command} --data {log}"), None));
            let of_stream = stdout(&inputs.run(&format!("{command} --data -"), Some(&path)));
            assert_eq!(
                of_file.replace(&format!("\"{log}\""), "\"standard input\""),
                of_stream
            );
        }
    }
    let log = inputs.path("log.csv");
    let diagnose = "diagnose a.urdf --support foot --data - --json";
    let json: Value = serde_json::from_str(&stdout(&inputs.run(diagnose, Some(&log)))).unwrap();
    assert_eq!(json["log"], "standard input");
    // A stream has no sidecar.
    refused(
        &inputs.run("fit a.urdf --data -", Some(&log)),
        &["--support"],
    );
    for line in ["fit - --data -", "fit a.urdf --data - --data -"] {
        refused(&inputs.run(line, Some(&log)), &["`-` is given twice"]);
    }
    assert!(!inputs.path("-").exists());
}

#[test]
fn logs_and_model_files_are_written_to_standard_output() {
    let inputs = Inputs::new();
    let simulate = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out -";
    assert_eq!(stdout(&inputs.run(simulate, None)), inputs.read("log.csv"));
    for command in ["fit", "diagnose"] {
        let line = format!("{command} a.urdf --data log.csv --out");
        stdout(&inputs.run(&format!("{line} model.toml"), None));
        let output = inputs.run(&format!("{line} -"), None);
        assert_eq!(stdout(&output), inputs.read("model.toml"));
        // The report is said beside it.
        assert!(String::from_utf8_lossy(&output.stderr).lines().count() > 3);
        refused(&inputs.run(&format!("{line} - --json"), None), &["--json"]);
    }
    let plan = "plan a.urdf --support foot --poses 3 --cop-box 0.2 --candidates 50 --out";
    stdout(&inputs.run(&format!("{plan} poses.csv"), None));
    let output = inputs.run(&format!("{plan} -"), None);
    assert_eq!(stdout(&output), inputs.read("poses.csv"));
    assert!(!inputs.path("-").exists() && !inputs.path("-.toml").exists());
}

#[test]
fn where_a_stream_makes_no_sense_it_is_an_error() {
    let inputs = Inputs::new();
    for line in [
        "fit a.urdf --data log.csv --urdf -",
        "fit a.urdf --data log.csv --report -",
        "fit a.urdf --data log.csv --prior -",
        "fit a.urdf --data log.csv --partial -",
        "diagnose a.urdf --data log.csv --next -",
        "diagnose a.urdf --data log.csv --servos -",
        "predict a.urdf --model - --data log.csv",
        "verify a.urdf --support foot --model -",
        "generate a.urdf --support foot --out g --model -",
        "plan a.urdf --support foot --poses 3 --limits - --out p.csv",
        "compare - -",
        "fleet a.urdf --data - --out f.csv",
        "fleet a.urdf --data log.csv --out -",
        "demo --out -",
    ] {
        refused(&inputs.run(line, None), &["`./-` is"]);
    }
    let names = fs::read_dir(inputs.0.path()).unwrap().count();
    assert_eq!(names, 3, "a file came");
}

/// From Parquet to Parquet, with the numbers of standard output.
#[test]
fn predictions_are_written_to_files() {
    let inputs = Inputs::new();
    let predict = "predict a.urdf --data log.csv";
    let printed = stdout(&inputs.run(predict, None));
    let mut names = vec!["p.csv", "p.csv.gz"];
    names.extend(cfg!(feature = "parquet").then_some("p.parquet"));
    for name in names {
        // Twice: its own output is replaced.
        for _ in 0..2 {
            let output = inputs.run(&format!("{predict} --out {name} --json"), None);
            let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
            assert_eq!(json["postures"], 60);
            assert_eq!(json["file"], name);
            assert!(json["schema"].is_u64());
        }
        assert!(!inputs.path(&format!("{name}.toml")).exists());
    }
    assert_eq!(inputs.read("p.csv"), printed);
    refused(
        &inputs.run(&format!("{predict} --out p.txt"), None),
        &["p.txt", ".csv, .csv.gz or .parquet"],
    );
    refused(
        &inputs.run("simulate a.urdf --support foot --poses 3 --out p.csv", None),
        &["p.csv is there already"],
    );
    let json: Value = serde_json::from_str(&stdout(
        &inputs.run("predict a.urdf --data log.csv --json", None),
    ))
    .unwrap();
    let first: Vec<f64> = printed
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .map(|x| x.parse().unwrap())
        .collect();
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(json["com_m"].as_array().unwrap().len(), 60);
    assert_eq!(number(&json["com_m"][0][2]), first[3]);
    assert_eq!(number(&json["cop_m"][0][1]), first[5]);
}

/// Whoever closes a pipe has read enough.
#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let inputs = Inputs::new();
    for line in [
        "simulate a.urdf --support foot --poses 20000 --out -",
        "fit a.urdf --data log.csv --out -",
        "predict a.urdf --data log.csv",
    ] {
        let mut command = Command::new(program());
        command.current_dir(inputs.0.path()).args(line.split(' '));
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = child.spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
    }
}
