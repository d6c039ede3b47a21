//! Files that are no logs, logs that do not say where they stand, and what the command says of them.

use std::fs;
use std::process::Command;

use sesc_test_support::command::{Folder, json, list, printed, says};
use sesc_test_support::fleet::Fleet;

use super::table;

/// One robot's log of one day in a folder, which it is copied from.
fn fleet() -> (Folder, String) {
    let folder = table::folder(&Fleet::sound(1, 1, 5));
    let log = folder.read(&table::log((0, 1)));
    (folder, log)
}

/// What the table has as errors, and the JSON of a fleet that may fail.
fn errors(folder: &Folder, data: &str, more: &str) -> (Vec<[String; 2]>, serde_json::Value) {
    let line = format!("fleet op2.urdf --data {data} --out fleet.csv --json {more}");
    let json = json(&folder.run(&line));
    let table = folder.sheet("fleet.csv");
    let of = |row| ["robot", "error"].map(|name| table.field(row, name).to_string());
    ((0..table.rows.len()).map(of).collect(), json)
}

/// A pipe that nobody writes to and a device without an end would hold up the run for ever.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_an_error_of_its_row() {
    let (folder, log) = fleet();
    let sidecar = folder.read(&(table::log((0, 1)) + ".toml"));
    folder.write("mixed/a_1.csv.toml", sidecar);
    for name in ["a_1.csv", "d_1.csv"] {
        folder.write(&format!("mixed/{name}"), &log);
    }
    for pipe in ["mixed/b_1.csv", "mixed/d_1.csv.toml"] {
        printed(Command::new("mkfifo").arg(folder.join(pipe)));
    }
    std::os::unix::fs::symlink("/dev/zero", folder.join("mixed/c_1.csv")).unwrap();
    let (found, json) = errors(&folder, "mixed", "--only parameters");
    let said = |name: &str| {
        format!("cannot read {name}: it is a pipe or a device, where a regular file is read")
    };
    let [b, c, d] = ["b_1.csv", "c_1.csv", "d_1.csv.toml"].map(said);
    let expected = [("a", String::new()), ("b", b), ("c", c), ("d", d)];
    let expected = expected.map(|(robot, error)| [robot.to_string(), error]);
    assert_eq!(found, expected);
    assert_eq!(list(&json, "/failed").len(), 3);
    // A pipe that is given by its name is no manifest that has to be looked at.
    let (_, json) = errors(&folder, "mixed/b_1.csv", "");
    says(json["failed"][0]["error"].to_string(), &["pipe"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_log_whose_name_is_no_utf8_is_a_row_that_says_so() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    let folder = Folder::with("op2");
    fs::create_dir(folder.join("logs")).unwrap();
    let name = OsStr::from_bytes(b"r\xff_1.csv");
    fs::write(folder.join("logs").join(name), "cop_x,cop_y\n0,0\n").unwrap();
    for data in ["logs", "logs/*.csv"] {
        let (_, json) = errors(&folder, data, "");
        assert_eq!(json["groups"], 1, "{data}");
        let words = ["its name is no text in UTF-8; give it another name"];
        says(json["failed"][0]["error"].to_string(), &words);
    }
}

/// The log is looked at before a support is missed, and where to say it is told.
#[test]
fn what_is_wrong_with_a_log_is_said_before_its_support_is_missed() {
    let (folder, log) = fleet();
    folder.write("bare/a_1.csv", log);
    folder.write("bare/b_1.csv", "pose,cop_x,cop_y\n0,zero,0\n");
    for only in ["--only parameters", ""] {
        let (found, json) = errors(&folder, "bare", only);
        assert_eq!(list(&json, "/failed").len(), 2);
        let [[_, first], [_, second]] = &found[..] else {
            panic!("{found:?}")
        };
        let no_support = ["no support link given", "for all logs"];
        says(
            first,
            &[&no_support[..], &["sidecar", "column `support`"]].concat(),
        );
        let is_of_log = !second.contains("support") && second.contains("column");
        assert!(is_of_log, "{second}");
    }
    // No threads are refused, and one robot is one.
    let fleet = "fleet op2.urdf --data logs --out fleet.csv";
    folder.refuses_each(&format!("{fleet} --threads 0 | --threads | give 1 or more"));
    let said = folder.stdout(&format!("{fleet} --only parameters"));
    assert!(said.starts_with("1 robot, 1 row, 0 of them"), "{said}");
}
