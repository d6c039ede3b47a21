//! The table, its store, and what is wrong with logs.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sesc_test_support::command::{folder, in_words, op2, refused, sesc, stdout};
use sesc_test_support::fleet::Fleet;

/// `sesc fleet` on `data` in `folder`, with further options; its JSON.
pub(super) fn fleet(folder: &Path, data: &str, options: &[&str]) -> Value {
    let data = folder.join(data).display().to_string();
    let urdf = op2();
    let mut words = vec!["fleet", &urdf, "--data", &data, "--json"];
    words.extend(options);
    serde_json::from_str(&stdout(&sesc(&words))).unwrap()
}

pub(super) fn at(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// Records of a CSV table by the names of its columns.
pub(super) fn records(path: &str) -> Vec<Vec<(String, String)>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let record = |record: csv::StringRecord| {
        let fields = header.iter().zip(&record);
        fields
            .map(|(name, field)| (name.to_owned(), field.to_owned()))
            .collect()
    };
    reader
        .records()
        .map(|found| record(found.unwrap()))
        .collect()
}

pub(super) fn field<'r>(record: &'r [(String, String)], name: &str) -> &'r str {
    let found = record.iter().find(|(column, _)| column == name);
    found.map_or_else(|| panic!("no column {name}"), |(_, field)| field)
}

#[test]
fn a_row_for_each_robot_and_day_whatever_is_wrong_with_logs() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet::sound(5, 2, 1).with_faults(0);
    hidden.write(folder).unwrap();
    let pattern = "logs/robot=*/day=*/*.csv";
    let (store, first) = (at(folder, "parts"), at(folder, "first.csv"));
    let json = fleet(folder, pattern, &["--store", &store, "--out", &first]);
    assert_eq!(json["groups"], 10);
    assert_eq!(json["from_store"], 0);

    // Truncated logs are named, and nothing else is.
    let log = |(robot, day): (usize, usize)| {
        folder
            .join(Fleet::folder(robot, day))
            .join("log.csv")
            .display()
            .to_string()
    };
    let failed: BTreeSet<&str> = json["failed"]
        .as_array()
        .unwrap()
        .iter()
        .map(|failed| failed["input"].as_str().unwrap())
        .collect();
    let truncated: Vec<String> = hidden.truncated.iter().map(|cut| log(*cut)).collect();
    assert_eq!(failed, truncated.iter().map(String::as_str).collect());
    let twice = json["twice"].as_array().unwrap();
    assert_eq!(twice.len(), 1);
    assert_eq!(
        twice[0]["input"].as_str().unwrap(),
        log(hidden.twice.unwrap()).replace("log.csv", "log_again.csv")
    );
    assert_eq!(twice[0]["counted_once"], true);

    let rows = records(&first);
    assert_eq!(rows.len(), 10);
    let columns = "robot day urdf_hash support postures independent noise_floor held_out_rmse \
                   verdict sentence effects health params std inputs error version";
    let found: Vec<&str> = rows[0].iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(found, columns.split_whitespace().collect::<Vec<_>>());
    for row in &rows {
        let robot: usize = field(row, "robot")[1..].parse().unwrap();
        let day: usize = field(row, "day").parse().unwrap();
        let inputs: Vec<String> = serde_json::from_str(field(row, "inputs")).unwrap();
        assert_eq!(inputs.len(), 1, "{row:?}");
        let broken = hidden.truncated.contains(&(robot, day));
        assert_eq!(!field(row, "error").is_empty(), broken, "{row:?}");
        assert!(!field(row, "error").contains('/'), "a path in {row:?}");
        if broken {
            continue;
        }
        assert_eq!(field(row, "postures"), "60");
        assert_eq!(field(row, "support"), "r_sole");
        let params: Vec<f64> = serde_json::from_str(field(row, "params")).unwrap();
        let std: Vec<Option<f64>> = serde_json::from_str(field(row, "std")).unwrap();
        assert_eq!((params.len(), std.len()), (43, 43));
        // 0.1 mm of noise, and 0.1 mm that ticks might add.
        let floor: f64 = field(row, "noise_floor").parse().unwrap();
        assert!((1e-4..2e-4).contains(&floor), "{floor}");
        let urdfs = field(row, "sentence").contains("This robot has 2 URDFs");
        assert_eq!(
            urdfs,
            hidden.urdf.is_some_and(|(own, _)| own == robot),
            "{row:?}"
        );
        // A row of which a joint is not where the log says agrees with nothing.
        let health = field(row, "health").contains("encoder_stuck");
        assert_eq!(health, hidden.stuck == Some(robot), "{row:?}");
        assert_eq!(field(row, "verdict") == "unusable", health, "{row:?}");
    }

    // A second run makes nothing anew, and a damaged entry is made again.
    let second = at(folder, "second.csv");
    let again = fleet(folder, pattern, &["--store", &store, "--out", &second]);
    assert_eq!(again["from_store"], 10);
    assert_eq!(fs::read(&first).unwrap(), fs::read(&second).unwrap());
    let entries: Vec<PathBuf> = fs::read_dir(&store)
        .unwrap()
        .map(|folder| folder.unwrap().path())
        .flat_map(|folder| fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .collect();
    assert_eq!(entries.len(), 10);
    let text = |entry: &PathBuf| fs::read_to_string(entry).unwrap();
    let is_whole = |entry: &&PathBuf| text(entry).contains("\"postures\":60");
    let whole: Vec<&PathBuf> = entries.iter().filter(is_whole).take(2).collect();
    let other = text(whole[0]).replace("\"postures\":60", "\"postures\":61");
    fs::write(whole[0], other).unwrap();
    let half = text(whole[1]);
    fs::write(whole[1], &half.as_bytes()[..half.len() / 2]).unwrap();
    let third = at(folder, "third.csv");
    let again = fleet(folder, pattern, &["--store", &store, "--out", &third]);
    assert_eq!(again["from_store"], 8);
    assert_eq!(fs::read(&first).unwrap(), fs::read(&third).unwrap());
}

#[test]
fn the_table_depends_on_no_path_and_no_order() {
    let one = folder();
    let other = folder();
    Fleet::sound(2, 1, 3).write(one.path()).unwrap();
    let mut lines = vec!["path,robot,day".to_string()];
    // Both robots' logs are one group here, and each has names that sort the other way round.
    for (robot, name) in [(0, "z"), (1, "a")] {
        let from = one.path().join(Fleet::folder(robot, 1));
        for end in ["", ".toml"] {
            let name = format!("{name}.csv{end}");
            fs::copy(from.join(format!("log.csv{end}")), other.path().join(name)).unwrap();
        }
        lines.push(format!("{name}.csv,r,d"));
    }
    fs::write(other.path().join("manifest.csv"), lines.join("\n")).unwrap();
    let table = |folder: &Path, data: &str| {
        let out = at(folder, "fleet.csv");
        fleet(folder, data, &["--out", &out, "--threads", "1"]);
        fs::read(out).unwrap()
    };
    let manifest = table(other.path(), "manifest.csv");
    let first = one.path().join("manifest.csv");
    let lines = [0, 1].map(|robot| format!("{}/log.csv,r,d", Fleet::folder(robot, 1).display()));
    fs::write(&first, format!("path,robot,day\n{}\n", lines.join("\n"))).unwrap();
    assert_eq!(manifest, table(one.path(), "manifest.csv"));
    let found = records(&at(one.path(), "fleet.csv"));
    assert_eq!(found.len(), 1);
    assert_eq!(field(&found[0], "postures"), "120");
    assert_eq!(field(&found[0], "error"), "");

    // Nor does it depend on the path of the URDF where an error is about the robot.
    for only in [&[][..], &["--only", "parameters"]] {
        let wrong = |folder: &Path, data: &str| {
            let (urdf, out) = (at(folder, "own.urdf"), at(folder, "wrong.csv"));
            fs::copy(op2(), &urdf).unwrap();
            let data = at(folder, data);
            let words = ["fleet", &urdf, "--data", &data, "--support", "nosuch"];
            let words = [&words[..], &["--out", &out, "--json"], only].concat();
            let json: Value = serde_json::from_slice(&sesc(&words).stdout).unwrap();
            let said = json["failed"][0]["error"].as_str().unwrap();
            assert_eq!(said.matches("no link `nosuch`").count(), 1, "{said}");
            fs::read(out).unwrap()
        };
        let table = wrong(other.path(), "manifest.csv");
        assert_eq!(table, wrong(one.path(), "manifest.csv"));
        let found = records(&at(one.path(), "wrong.csv"));
        let error = field(&found[0], "error");
        assert!(error.contains("no link `nosuch`"), "{error}");
        assert!(!error.contains(&at(one.path(), "")), "{error}");
    }
}

#[test]
fn logs_that_are_not_there_and_tables_of_no_kind_are_refused() {
    let folder = folder();
    let urdf = op2();
    let out = at(folder.path(), "fleet.csv");
    let nothing = at(folder.path(), "*.csv");
    refused(
        &sesc(&["fleet", &urdf, "--data", &nothing, "--out", &out]),
        &["no file has such a name"],
    );
    let log = at(folder.path(), "r1_d1.csv");
    fs::write(&log, "pose\n").unwrap();
    let other = at(folder.path(), "fleet.xlsx");
    refused(
        &sesc(&["fleet", &urdf, "--data", &log, "--out", &other]),
        &[".parquet or .csv"],
    );
}

/// Of several logs of a day one that cannot be used is left out, and `health` says why; what their
/// sidecars say may differ.
#[test]
fn a_log_without_data_does_not_take_its_day_along() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet {
        postures: 40,
        ..Fleet::sound(1, 3, 9)
    };
    hidden.write(folder).unwrap();
    let log = |day: usize| {
        let log = folder.join(Fleet::folder(0, day)).join("log.csv");
        log.display().to_string()
    };
    let text = fs::read_to_string(log(2)).unwrap();
    let still = text.lines().enumerate().map(|(k, row)| {
        let cell = |(place, cell): (usize, &str)| {
            let name = text.lines().next().unwrap().split(',').nth(place);
            let is_cop = k > 0 && matches!(name, Some("cop_x" | "cop_y"));
            if is_cop { "0.01" } else { cell }.to_string()
        };
        let cells: Vec<String> = row.split(',').enumerate().map(cell).collect();
        cells.join(",") + "\n"
    });
    fs::write(log(2), still.collect::<String>()).unwrap();
    let sidecar = log(3) + ".toml";
    let said = fs::read_to_string(&sidecar).unwrap();
    fs::write(sidecar, said.replace("= 100", "= 50")).unwrap();
    for only in [&["--only", "parameters"][..], &[]] {
        let out = at(folder, "one.csv");
        fleet(
            folder,
            "logs",
            &[&["--by", "robot", "--out", &out], only].concat(),
        );
        let rows = records(&out);
        assert_eq!(rows.len(), 1);
        let row = &rows[0];
        assert_eq!(field(row, "postures"), "80", "{row:?}");
        assert_eq!(field(row, "error"), "");
        let verdict = if only.is_empty() { "none" } else { "" };
        assert_eq!(field(row, "verdict"), verdict, "{row:?}");
        let health: Value = serde_json::from_str(field(row, "health")).unwrap();
        assert_eq!(health[0]["kind"], "cop_constant", "{row:?}");
        assert_eq!(health.as_array().unwrap().len(), 1, "{row:?}");
        let inputs: Vec<String> = serde_json::from_str(field(row, "inputs")).unwrap();
        assert_eq!(inputs.len(), 3);
    }
}

/// Fits without a diagnosis: the same parameters, no verdict; and changes are seen all the same.
#[test]
fn parameters_alone_are_those_of_the_whole_row() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet {
        postures: 40,
        ..Fleet::sound(2, 1, 6)
    };
    hidden.write(folder).unwrap();
    let table = |name: &str, options: &[&str]| {
        let out = at(folder, name);
        let options = [options, &["--out", &out]].concat();
        let json = fleet(folder, "logs", &options);
        assert_eq!(json["groups"], 2);
        records(&out)
    };
    let whole = table("whole.csv", &[]);
    let alone = table("alone.csv", &["--only", "parameters"]);
    for (whole, alone) in whole.iter().zip(&alone) {
        for name in [
            "robot",
            "day",
            "urdf_hash",
            "support",
            "postures",
            "params",
            "std",
            "inputs",
        ] {
            assert_eq!(field(whole, name), field(alone, name), "{name}");
        }
        assert_eq!(field(whole, "verdict"), "none");
        assert_eq!(field(alone, "verdict"), "");
        let none = r#"{"explanation":[],"instead":[],"scores":[]}"#;
        assert_eq!((field(alone, "effects"), field(alone, "error")), (none, ""));
        assert!(field(alone, "sentence").contains("no diagnosis"));
        let floor: f64 = field(alone, "noise_floor").parse().unwrap();
        assert!((0.8e-4..1.3e-4).contains(&floor), "{floor}");
    }
}

/// Days of one ISO week are one row, also of logs that are diagnosed together.
#[test]
fn a_row_for_each_robot_and_week() {
    let folder = folder();
    let folder = folder.path();
    let hidden = Fleet {
        postures: 30,
        ..Fleet::sound(1, 3, 12)
    };
    hidden.write(folder).unwrap();
    // Thursday, Sunday and Monday.
    for (day, name) in [(1, "2031-05-01"), (2, "20310504"), (3, "2031-05-05")] {
        let from = folder.join(Fleet::folder(0, day));
        fs::rename(&from, from.with_file_name(format!("day={name}"))).unwrap();
    }
    let (out, store) = (at(folder, "weeks.csv"), at(folder, "rows"));
    let options = ["--by", "robot,week", "--store", &store, "--out", &out];
    for from_store in [0, 2] {
        let json = fleet(folder, "logs/robot=*/day=*/*.csv", &options);
        assert_eq!(json["from_store"], from_store);
        let rows = records(&out);
        let of = |row: &Vec<(String, String)>| {
            ["robot", "day", "postures", "verdict"].map(|name| field(row, name).to_string())
        };
        let rows: Vec<[String; 4]> = rows.iter().map(of).collect();
        let row = |week: &str, postures: &str| ["r00", week, postures, "none"].map(String::from);
        assert_eq!(rows, [row("2031-W18", "60"), row("2031-W19", "30")]);
    }
    let log = at(folder, "r1_monday.csv");
    fs::write(&log, "pose\n").unwrap();
    let words = [
        "fleet",
        &op2(),
        "--data",
        &log,
        "--by",
        "robot,week",
        "--out",
        &out,
    ];
    refused(&sesc(&words), &["`week`", "`monday`", "2031-05-01"]);
}

/// Each log stands on the foot that its sidecar says, in a group of both; without one on that of
/// its column `support`, as `fit` and `diagnose` read it.
#[test]
fn logs_stand_where_their_sidecar_or_their_column_says() {
    let folder = folder();
    let folder = folder.path();
    let urdf = op2();
    let mut lines = vec!["path,robot,day".to_string()];
    for (foot, seed) in [("r_sole", "1"), ("l_sole", "2")] {
        let log = at(folder, &format!("{foot}.csv"));
        let words = in_words(
            "simulate @ --support @ --poses 60 --seed @",
            &[&urdf, foot, seed],
        );
        stdout(&sesc(
            &[&words[..], &["--noise", "1e-4", "--out", &log]].concat(),
        ));
        lines.push(format!("{foot}.csv,both,1"));
        let text = fs::read_to_string(&log).unwrap();
        let rows = text.lines().enumerate();
        let with = |(k, row): (usize, &str)| match k {
            0 => format!("{row},support\n"),
            _ => format!("{row},{foot}\n"),
        };
        let column: String = rows.map(with).collect();
        fs::write(at(folder, &format!("{foot}_1.csv")), column).unwrap();
        lines.push(format!("{foot}_1.csv,{foot},1"));
    }
    fs::write(at(folder, "manifest.csv"), lines.join("\n")).unwrap();
    let out = at(folder, "fleet.csv");
    for only in [&["--only", "parameters"][..], &[]] {
        let options = [&["--out", &out][..], only].concat();
        fleet(folder, "manifest.csv", &options);
        let rows = records(&out);
        for (row, support) in rows.iter().zip(["", "l_sole", "r_sole"]) {
            assert_eq!(field(row, "error"), "");
            if !support.is_empty() {
                assert_eq!(field(row, "support"), support);
                assert_eq!(field(row, "postures"), "60");
            }
        }
        if !only.is_empty() {
            assert_eq!(field(&rows[0], "postures"), "120");
            let error: f64 = field(&rows[0], "held_out_rmse").parse().unwrap();
            assert!(error < 3e-4, "{error}");
        }
    }
    let log = at(folder, "l_sole_1.csv");
    for command in ["fit", "diagnose"] {
        let json = stdout(&sesc(&[command, &urdf, "--data", &log, "--json"]));
        let json: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["support"], "l_sole", "{command}");
    }
}
