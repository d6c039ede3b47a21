//! Days that are put together.

use std::fs;
use std::path::Path;

use sesc_test_support::command::{folder, op2, refused, sesc};
use sesc_test_support::fleet::Fleet;

use super::table::{at, field, fleet, records};

/// Robot, window and postures of each row.
fn rows(path: &str) -> Vec<(String, String, String)> {
    let of = |row: &Vec<(String, String)>| {
        ["robot", "day", "postures"].map(|name| field(row, name).to_string())
    };
    let rows = records(path);
    rows.iter().map(|row| of(row).into()).collect()
}

/// A day of logs under another name.
fn moved(folder: &Path, day: usize, name: &str) {
    let from = folder.join(Fleet::folder(0, day));
    fs::rename(&from, from.with_file_name(format!("day={name}"))).unwrap();
}

#[test]
fn a_row_for_each_robot_and_week_whatever_days_have_logs() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet {
        postures: 30,
        ..Fleet::sound(1, 4, 12)
    };
    hidden.write(folder).unwrap();
    // Thursday to Monday: the last is of another week. However its days are written, a week has
    // one name.
    for (day, name) in [
        (1, "2031-05-01"),
        (2, "20310502"),
        (3, "2031-05-04"),
        (4, "2031-05-05"),
    ] {
        moved(folder, day, name);
    }
    // Younger files are read again.
    std::thread::sleep(std::time::Duration::from_millis(2100));
    let (store, out) = (at(folder, "parts"), at(folder, "weeks.csv"));
    let options = ["--only", "parameters", "--store", &store, "--out", &out];
    let run = |data: &str, more: &[&str]| fleet(folder, data, &[&options[..], more].concat());
    let all = "logs/robot=*/day=*/*.csv";
    let json = run(all, &[]);
    assert_eq!(
        (&json["groups"], &json["logs_read"]),
        (&4.into(), &4.into())
    );

    let json = run(all, &["--window", "7"]);
    assert_eq!(
        (&json["groups"], &json["logs_read"]),
        (&2.into(), &0.into())
    );
    let row =
        |day: &str, postures: &str| ("r00".to_string(), day.to_string(), postures.to_string());
    assert_eq!(
        rows(&out),
        [row("2031-04-28", "90"), row("2031-05-05", "30")]
    );
    // Without the first day of it the week begins where it began.
    run("logs/robot=*/day=*[245]/*.csv", &["--window", "7"]);
    assert_eq!(
        rows(&out),
        [row("2031-04-28", "60"), row("2031-05-05", "30")]
    );
}

#[test]
fn days_that_are_no_dates_have_no_windows() {
    let folder = folder();
    let log = at(folder.path(), "r1_monday.csv");
    fs::write(&log, "pose\n").unwrap();
    let (urdf, out) = (op2(), at(folder.path(), "fleet.csv"));
    let words = ["fleet", &urdf, "--data", &log, "--out", &out, "--window"];
    let with = |days: &str| sesc(&[&words[..], &[days]].concat());
    refused(&with("7"), &["--window", "`monday`", "2031-05-01"]);
    refused(&with("0"), &["--window"]);
}
