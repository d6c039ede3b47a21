//! Files that are no logs, logs that do not say where they stand, and what the command says of them.

use std::fs;
use std::process::Command;

use sesc_test_support::command::{folder, op2, refused, sesc, stdout};
use sesc_test_support::fleet::Fleet;

use super::table::{at, field, fleet, records};

/// A pipe that nobody writes to and a device without an end would hold up the run for ever.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_an_error_of_its_row() {
    let folder = folder();
    let folder = folder.path();
    Fleet::sound(1, 1, 5).write(folder).unwrap();
    let log = folder.join(Fleet::folder(0, 1)).join("log.csv");
    let logs = folder.join("mixed");
    fs::create_dir(&logs).unwrap();
    fs::copy(&log, logs.join("a_1.csv")).unwrap();
    fs::copy(log.with_extension("csv.toml"), logs.join("a_1.csv.toml")).unwrap();
    fs::copy(&log, logs.join("d_1.csv")).unwrap();
    for pipe in ["b_1.csv", "d_1.csv.toml"] {
        let made = Command::new("mkfifo")
            .arg(logs.join(pipe))
            .status()
            .unwrap();
        assert!(made.success());
    }
    std::os::unix::fs::symlink("/dev/zero", logs.join("c_1.csv")).unwrap();
    let out = at(folder, "fleet.csv");
    let json = fleet(folder, "mixed", &["--out", &out, "--only", "parameters"]);
    let errors: Vec<(String, String)> = records(&out)
        .iter()
        .map(|row| {
            (
                field(row, "robot").to_string(),
                field(row, "error").to_string(),
            )
        })
        .collect();
    let said = |name: &str| {
        format!("cannot read {name}: it is a pipe or a device; a fleet reads regular files")
    };
    let expected = [
        ("a", String::new()),
        ("b", said("b_1.csv")),
        ("c", said("c_1.csv")),
        ("d", said("d_1.csv.toml")),
    ];
    assert_eq!(
        errors,
        expected.map(|(robot, error)| (robot.to_string(), error))
    );
    assert_eq!(json["failed"].as_array().unwrap().len(), 3);
    // A pipe that is given by its name is no manifest that has to be looked at.
    let pipe = at(folder, "mixed/b_1.csv");
    let found = sesc(&["fleet", &op2(), "--data", &pipe, "--out", &out, "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    assert!(
        json["failed"][0]["error"]
            .as_str()
            .unwrap()
            .contains("pipe")
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_whose_name_is_no_utf8_is_a_row_that_says_so() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = folder();
    let folder = folder.path();
    fs::create_dir(folder.join("logs")).unwrap();
    let name = OsStr::from_bytes(b"r\xff_1.csv");
    fs::write(folder.join("logs").join(name), "cop_x,cop_y\n0,0\n").unwrap();
    let out = at(folder, "fleet.csv");
    for data in ["logs", "logs/*.csv"] {
        let output = sesc(&[
            "fleet",
            &op2(),
            "--data",
            &at(folder, data),
            "--out",
            &out,
            "--json",
        ]);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(json["groups"], 1, "{data}");
        let said = json["failed"][0]["error"].as_str().unwrap();
        assert!(
            said.contains("its name is no text in UTF-8; give it another name"),
            "{said}"
        );
    }
}

/// The log is looked at before a support is missed, and where to say it is told.
#[test]
fn what_is_wrong_with_a_log_is_said_before_its_support_is_missed() {
    let folder = folder();
    let folder = folder.path();
    Fleet::sound(1, 1, 5).write(folder).unwrap();
    let logs = folder.join("bare");
    fs::create_dir(&logs).unwrap();
    let log = folder.join(Fleet::folder(0, 1)).join("log.csv");
    fs::copy(&log, logs.join("a_1.csv")).unwrap();
    fs::write(logs.join("b_1.csv"), "pose,cop_x,cop_y\n0,zero,0\n").unwrap();
    for only in [&["--only", "parameters"][..], &[]] {
        let out = at(folder, "fleet.csv");
        let data = at(folder, "bare");
        let urdf = op2();
        let words = ["fleet", &urdf, "--data", &data, "--out", &out];
        let words = [&words[..], only].concat();
        assert_eq!(sesc(&words).status.code(), Some(1));
        let rows = records(&out);
        let error = |at: usize| field(&rows[at], "error");
        for words in [
            "no support link given",
            "for all logs",
            "sidecar",
            "column `support`",
        ] {
            assert!(error(0).contains(words), "{}", error(0));
        }
        assert!(
            !error(1).contains("support") && error(1).contains("column"),
            "{}",
            error(1)
        );
    }
}

#[test]
fn no_threads_are_refused_and_one_robot_is_one() {
    let folder = folder();
    let folder = folder.path();
    Fleet::sound(1, 1, 5).write(folder).unwrap();
    let (urdf, data, out) = (op2(), at(folder, "logs"), at(folder, "fleet.csv"));
    let words = ["fleet", &urdf, "--data", &data, "--out", &out];
    refused(
        &sesc(&[&words[..], &["--threads", "0"]].concat()),
        &["--threads", "give 1 or more"],
    );
    let said = stdout(&sesc(&[&words[..], &["--only", "parameters"]].concat()));
    assert!(said.starts_with("1 robot, 1 row, 0 of them"), "{said}");
}
