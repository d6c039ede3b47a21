//! The store: what a second run reads and what it makes.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use sesc_test_support::command::{folder, op2, sesc, stdout};
use sesc_test_support::fleet::Fleet;

use super::table::{at, field, fleet, records};

/// Files that are younger when they are read are read again.
const SETTLED: Duration = Duration::from_millis(2100);

/// Bytes of the table that a run with these options writes, and its JSON.
fn table(folder: &Path, out: &str, options: &[&str]) -> (Vec<u8>, serde_json::Value) {
    let out = at(folder, out);
    let options = [options, &["--only", "parameters", "--out", &out]].concat();
    let json = fleet(folder, "logs/robot=*/day=*/*.csv", &options);
    (fs::read(&out).unwrap(), json)
}

/// The parts of logs in a store.
fn parts(store: &str) -> Vec<PathBuf> {
    let folders = fs::read_dir(Path::new(store).join("parts")).unwrap();
    let parts = folders.flat_map(|folder| fs::read_dir(folder.unwrap().path()).unwrap());
    parts.map(|part| part.unwrap().path()).collect()
}

/// A log is read once: with another one of its robot and day it counts by its part, and the table
/// has the bytes of a run that read both.
#[test]
fn a_new_log_of_a_group_is_the_only_one_that_is_read() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet {
        postures: 40,
        ..Fleet::sound(2, 3, 8)
    };
    hidden.write(folder).unwrap();
    let own = |robot: usize, day: usize| folder.join(Fleet::folder(robot, day));
    // Logs of the third day arrive later, as logs of the first.
    let later = at(folder, "later");
    fs::create_dir(&later).unwrap();
    for robot in [0, 1] {
        fs::rename(own(robot, 3), format!("{later}/{robot}")).unwrap();
    }
    let arrive = |robot: usize, name: &str| {
        for end in ["", ".toml"] {
            let from = format!("{later}/{robot}/log.csv{end}");
            fs::copy(from, own(robot, 1).join(format!("{name}.csv{end}"))).unwrap();
        }
    };
    std::thread::sleep(SETTLED);
    let store = at(folder, "parts");
    let (_, json) = table(folder, "first.csv", &["--store", &store]);
    assert_eq!(
        (&json["logs_read"], &json["from_store"]),
        (&4.into(), &0.into())
    );
    assert_eq!(parts(&store).len(), 4);

    arrive(0, "another");
    std::thread::sleep(SETTLED);
    let (second, json) = table(folder, "second.csv", &["--store", &store]);
    assert_eq!(
        (&json["logs_read"], &json["from_store"]),
        (&1.into(), &3.into())
    );
    let rows = records(&at(folder, "second.csv"));
    assert_eq!(
        (field(&rows[0], "postures"), field(&rows[0], "error")),
        ("80", "")
    );
    let (without, _) = table(folder, "without.csv", &[]);
    assert!(second == without, "a part from the store is another one");
    let (again, json) = table(folder, "again.csv", &["--store", &store]);
    assert_eq!(
        (&json["logs_read"], &json["from_store"]),
        (&0.into(), &4.into())
    );
    assert!(again == second);

    // A part that is damaged is made again, of its log alone.
    arrive(1, "another");
    std::thread::sleep(SETTLED);
    for part in parts(&store) {
        let bytes = fs::read(&part).unwrap();
        fs::write(&part, &bytes[..bytes.len() - 1]).unwrap();
    }
    let (third, json) = table(folder, "third.csv", &["--store", &store, "--threads", "1"]);
    assert_eq!(
        (&json["logs_read"], &json["from_store"]),
        (&2.into(), &3.into())
    );
    let (without, _) = table(folder, "without.csv", &[]);
    assert!(third == without);
}

/// What a log that is cut comes to is kept, too.
#[test]
fn a_log_that_is_cut_is_read_once() {
    let folder = folder();
    let folder = folder.path();
    Fleet {
        postures: 30,
        ..Fleet::sound(1, 2, 9)
    }
    .write(folder)
    .unwrap();
    let [first, other] = [1, 2].map(|day| folder.join(Fleet::folder(0, day)));
    let text = fs::read_to_string(other.join("log.csv")).unwrap();
    fs::write(first.join("cut.csv"), &text[..text.len() / 2 + 3]).unwrap();
    fs::copy(other.join("log.csv.toml"), first.join("cut.csv.toml")).unwrap();
    std::thread::sleep(SETTLED);
    let store = at(folder, "parts");
    let (_, json) = table(folder, "one.csv", &["--store", &store]);
    assert_eq!(json["logs_read"], 3);
    assert_eq!(json["failed"].as_array().unwrap().len(), 1);
    for end in ["", ".toml"] {
        let name = format!("log.csv{end}");
        fs::copy(other.join(&name), first.join(format!("b{name}"))).unwrap();
    }
    std::thread::sleep(SETTLED);
    let (found, json) = table(folder, "two.csv", &["--store", &store]);
    assert_eq!(json["logs_read"], 1);
    assert_eq!(json["failed"].as_array().unwrap().len(), 1);
    let rows = records(&at(folder, "two.csv"));
    assert_eq!(field(&rows[0], "postures"), "60");
    assert!(field(&rows[0], "error").starts_with("log "));
    assert!(found == table(folder, "without.csv", &[]).0);
}

/// Each log stands on the foot that its sidecar says, in a group of both.
#[test]
fn logs_of_both_feet_are_fitted_each_on_its_own() {
    let folder = folder();
    let folder = folder.path();
    let urdf = op2();
    let mut lines = vec!["path,robot,day".to_string()];
    for (foot, seed) in [("r_sole", "1"), ("l_sole", "2")] {
        let log = at(folder, &format!("{foot}.csv"));
        let words = [
            "simulate",
            &urdf,
            "--support",
            foot,
            "--poses",
            "60",
            "--seed",
            seed,
        ];
        stdout(&sesc(
            &[&words[..], &["--noise", "1e-4", "--out", &log]].concat(),
        ));
        lines.push(format!("{foot}.csv,r,1"));
    }
    fs::write(at(folder, "manifest.csv"), lines.join("\n")).unwrap();
    let out = at(folder, "fleet.csv");
    let options = ["--only", "parameters", "--out", &out];
    fleet(folder, "manifest.csv", &options);
    let rows = records(&out);
    assert_eq!(
        (field(&rows[0], "postures"), field(&rows[0], "error")),
        ("120", "")
    );
    assert_eq!(
        (field(&rows[0], "verdict"), field(&rows[0], "health")),
        ("", "[]")
    );
    let error: f64 = field(&rows[0], "held_out_rmse").parse().unwrap();
    assert!(error < 3e-4, "{error}");
}
