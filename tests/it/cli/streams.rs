//! `-` for logs, tables and model files, and predictions in files.

use std::process::Stdio;

use serde_json::Value;
use sesc_test_support::command::{Folder, refused, stderr, stdout};

const SIMULATE: &str = "simulate two_link.urdf --support foot --poses 60 --noise 0.0005 --out";

/// A folder with a robot and a log of it.
fn inputs() -> Folder {
    let folder = Folder::with("two_link");
    folder.stdout(&format!("{SIMULATE} log.csv"));
    folder
}

/// Names of tables of every format.
fn tables(stem: &str) -> Vec<String> {
    let parquet = cfg!(feature = "parquet").then_some("parquet");
    let ends = ["csv", "csv.gz"].into_iter().chain(parquet);
    ends.map(|end| format!("{stem}.{end}")).collect()
}

/// The format is told by the first bytes, as that of a file.
#[test]
fn logs_are_read_from_standard_input() {
    let inputs = inputs();
    for log in tables("log") {
        inputs.stdout(&format!("{SIMULATE} {log}"));
        for command in ["predict", "fit --json"] {
            let command = format!("{command} two_link.urdf --support foot --data");
            let of_file = inputs.stdout(&format!("{command} {log}"));
            let of_stream = stdout(&inputs.piped(&format!("{command} -"), &log));
            let named = of_file.replace(&format!("\"{log}\""), "\"standard input\"");
            assert_eq!(named, of_stream);
        }
    }
    let diagnose = "diagnose two_link.urdf --support foot --data - --json";
    let json: Value = serde_json::from_str(&stdout(&inputs.piped(diagnose, "log.csv"))).unwrap();
    assert_eq!(json["log"], "standard input");
    for (line, word) in [
        // A stream has no sidecar.
        ("fit two_link.urdf --data -", "--support"),
        ("fit - --data -", "`-` is given twice"),
        ("fit two_link.urdf --data - --data -", "`-` is given twice"),
    ] {
        refused(&inputs.piped(line, "log.csv"), &[word]);
    }
    assert!(!inputs.join("-").exists());
}

#[test]
fn logs_and_model_files_are_written_to_standard_output() {
    let inputs = inputs();
    let simulated = inputs.stdout(&format!("{SIMULATE} -"));
    assert_eq!(simulated, inputs.read("log.csv"));
    for command in ["fit", "diagnose"] {
        let line = format!("{command} two_link.urdf --data log.csv --out");
        inputs.stdout(&format!("{line} model.toml"));
        let output = inputs.run(&format!("{line} -"));
        assert_eq!(stdout(&output), inputs.read("model.toml"));
        // The report is said beside it.
        assert!(stderr(&output).lines().count() > 3);
        inputs.refuses(&format!("{line} - --json"), &["--json"]);
    }
    let plan = "plan two_link.urdf --support foot --poses 3 --cop-box 0.2 --candidates 50 --out";
    inputs.stdout(&format!("{plan} poses.csv"));
    let planned = inputs.stdout(&format!("{plan} -"));
    assert_eq!(planned, inputs.read("poses.csv"));
    assert!(!inputs.join("-").exists() && !inputs.join("-.toml").exists());
}

#[test]
fn where_a_stream_makes_no_sense_it_is_an_error() {
    let inputs = inputs();
    inputs.refuses_each(
        "fit two_link.urdf --data log.csv --urdf -                          | `./-` is
         fit two_link.urdf --data log.csv --report -                        | `./-` is
         fit two_link.urdf --data log.csv --prior -                         | `./-` is
         fit two_link.urdf --data log.csv --partial -                       | `./-` is
         diagnose two_link.urdf --data log.csv --next -                     | `./-` is
         diagnose two_link.urdf --data log.csv --servos -                   | `./-` is
         predict two_link.urdf --model - --data log.csv                     | `./-` is
         verify two_link.urdf --support foot --model -                      | `./-` is
         generate two_link.urdf --support foot --out g --model -            | `./-` is
         plan two_link.urdf --support foot --poses 3 --limits - --out p.csv | `./-` is
         compare - -                                                        | `./-` is
         fleet two_link.urdf --data - --out f.csv                           | `./-` is
         fleet two_link.urdf --data log.csv --out -                         | `./-` is
         demo --out -                                                       | `./-` is",
    );
    assert_eq!(inputs.names().len(), 3, "a file came");
}

/// From Parquet to Parquet, with the numbers of standard output.
#[test]
fn predictions_are_written_to_files() {
    let inputs = inputs();
    let predict = "predict two_link.urdf --data log.csv";
    let printed = inputs.stdout(predict);
    for name in tables("p") {
        // Twice: its own output is replaced.
        for _ in 0..2 {
            let json = inputs.json(&format!("{predict} --out {name}"));
            assert_eq!(json["postures"], 60);
            assert_eq!(json["file"], *name);
            assert!(json["schema"].is_u64());
        }
        assert!(!inputs.join(&format!("{name}.toml")).exists());
    }
    assert_eq!(inputs.read("p.csv"), printed);
    inputs.refuses_each(
        "predict two_link.urdf --data log.csv --out p.txt | p.txt | .csv, .csv.gz or .parquet
         simulate two_link.urdf --support foot --poses 3 --out p.csv | p.csv is there already",
    );
    let json = inputs.json(predict);
    let row = printed.lines().nth(1).unwrap().split(',');
    let first: Vec<f64> = row.map(|x| x.parse().unwrap()).collect();
    assert_eq!(json["com_m"].as_array().unwrap().len(), 60);
    assert_eq!(json["com_m"][0][2].as_f64().unwrap(), first[3]);
    assert_eq!(json["cop_m"][0][1].as_f64().unwrap(), first[5]);
}

/// Whoever closes a pipe has read enough, and files are written all the same.
#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_fault() {
    let inputs = inputs();
    for name in ["log.csv", "log.csv.toml"] {
        inputs.write(&format!("logs/robot=1/day=1/{name}"), inputs.read(name));
    }
    for (line, out) in [
        ("simulate --support foot --poses 20000 --out -", None),
        ("fit --data log.csv --out -", None),
        ("predict --data log.csv", None),
        ("fit --data log.csv --out m.toml", Some("m.toml")),
        ("diagnose --data log.csv --report p.html", Some("p.html")),
        (
            "fleet --data logs --out t.csv --only parameters",
            Some("t.csv"),
        ),
        ("generate --support foot --name leg --out .", Some("leg.rs")),
    ] {
        let mut command = inputs.command(line);
        let child = command.arg("two_link.urdf").stdout(Stdio::piped());
        let mut child = child.stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
        assert!(!said.contains("panicked"), "{line}: {said}");
        assert!(out.is_none_or(|out| inputs.join(out).exists()), "{line}");
    }
}
