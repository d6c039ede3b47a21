//! The table, its store, and what is wrong with logs.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;
use sesc_test_support::command::{Folder, Sheet, json, list, says, texts};
use sesc_test_support::fleet::Fleet;

/// A folder with the OP2 and the logs of a fleet of it.
pub(super) fn folder(fleet: &Fleet) -> Folder {
    let folder = Folder::with("op2");
    fleet.write(folder.path()).unwrap();
    folder
}

/// The file of a log in it.
pub(super) fn log((robot, day): (usize, usize)) -> String {
    format!("{}/log.csv", Fleet::folder(robot, day).display())
}

/// `sesc fleet` on `data` with further options; its table and its JSON.
pub(super) fn fleet(folder: &Folder, data: &str, options: &str) -> (Sheet, Value) {
    let json = folder.json(&format!(
        "fleet op2.urdf --data {data} --out fleet.csv {options}"
    ));
    (folder.sheet("fleet.csv"), json)
}

/// What a field holds, as JSON.
pub(super) fn held(table: &Sheet, row: usize, name: &str) -> Value {
    serde_json::from_str(table.field(row, name)).unwrap()
}

/// With diagnoses, and without.
const DEPTHS: [&str; 2] = ["--only parameters", ""];

#[test]
fn a_row_for_each_robot_and_day_whatever_is_wrong_with_logs() {
    let hidden = Fleet::sound(5, 2, 1).with_faults(0);
    let folder = folder(&hidden);
    let run = || fleet(&folder, "logs/robot=*/day=*/*.csv", "--store parts");
    let (table, json) = run();
    assert_eq!(
        (&json["groups"], &json["from_store"]),
        (&10.into(), &0.into())
    );

    // Truncated logs are named, and nothing else is.
    let failed = list(&json, "/failed").iter();
    let mut failed: Vec<&str> = failed.map(|f| f["input"].as_str().unwrap()).collect();
    failed.sort_unstable();
    let mut truncated: Vec<String> = hidden.truncated.iter().map(|cut| log(*cut)).collect();
    truncated.sort();
    assert_eq!(failed, truncated);
    let [twice] = &list(&json, "/twice")[..] else {
        panic!("{json}")
    };
    let again = log(hidden.twice.unwrap()).replace("log.csv", "log_again.csv");
    assert_eq!(
        (&twice["input"], &twice["counted_once"]),
        (&again.into(), &true.into())
    );

    assert_eq!(table.rows.len(), 10);
    let columns = "robot day urdf_hash support postures independent noise_floor held_out_rmse \
                   verdict sentence effects health params std inputs error version";
    assert_eq!(table.names.join(" "), columns);
    for row in 0..10 {
        let field = |name: &str| table.field(row, name);
        let robot: usize = field("robot")[1..].parse().unwrap();
        let day: usize = field("day").parse().unwrap();
        assert_eq!(held(&table, row, "inputs").as_array().unwrap().len(), 1);
        let broken = hidden.truncated.contains(&(robot, day));
        assert_eq!(!field("error").is_empty(), broken, "{robot} {day}");
        assert!(
            !field("error").contains('/'),
            "a path in {}",
            field("error")
        );
        if broken {
            continue;
        }
        assert_eq!((field("postures"), field("support")), ("60", "r_sole"));
        for name in ["params", "std"] {
            let all: Vec<Option<f64>> = serde_json::from_value(held(&table, row, name)).unwrap();
            assert_eq!(all.len(), 43);
            assert!(name == "std" || all.iter().all(Option::is_some));
        }
        // 0.1 mm of noise, and 0.1 mm that ticks might add.
        let floor: f64 = field("noise_floor").parse().unwrap();
        assert!((1e-4..2e-4).contains(&floor), "{floor}");
        let urdfs = field("sentence").contains("This robot has 2 URDFs");
        assert_eq!(urdfs, hidden.urdf.is_some_and(|(own, _)| own == robot));
        // A row of which a joint is not where the log says agrees with nothing.
        let health = field("health").contains("encoder_stuck");
        assert_eq!(health, hidden.stuck == Some(robot), "{robot}");
        assert_eq!(field("verdict") == "unusable", health, "{robot}");
    }

    // A second run makes nothing anew, and a damaged entry is made again.
    let first = folder.read("fleet.csv");
    assert_eq!(run().1["from_store"], 10);
    assert_eq!(folder.read("fleet.csv"), first);
    let mut entries = sesc_test_support::command::files(&folder.join("parts"));
    assert_eq!(entries.len(), 10);
    let text = |bytes: &Vec<u8>| String::from_utf8(bytes.clone()).unwrap();
    entries.retain(|_, entry| text(entry).contains("\"postures\":60"));
    let whole: Vec<(&PathBuf, &Vec<u8>)> = entries.iter().take(2).collect();
    let other = text(whole[0].1).replace("\"postures\":60", "\"postures\":61");
    fs::write(whole[0].0, other).unwrap();
    fs::write(whole[1].0, &whole[1].1[..whole[1].1.len() / 2]).unwrap();
    assert_eq!(run().1["from_store"], 8);
    assert_eq!(folder.read("fleet.csv"), first);
}

#[test]
fn the_table_depends_on_no_path_and_no_order() {
    let (one, other) = (folder(&Fleet::sound(2, 1, 3)), Folder::with("op2"));
    // Both robots' logs are one group here, and each has names that sort the other way round.
    let mut manifests = ["path,robot,day\n"; 2].map(String::from);
    for (robot, name) in [(0, "z"), (1, "a")] {
        let from = log((robot, 1));
        for end in ["", ".toml"] {
            other.write(
                &format!("{name}.csv{end}"),
                one.read(&format!("{from}{end}")),
            );
        }
        manifests[0] += &format!("{from},r,d\n");
        manifests[1] += &format!("{name}.csv,r,d\n");
    }
    let folders = [&one, &other];
    let tables = folders
        .into_iter()
        .zip(&manifests)
        .map(|(folder, manifest)| {
            folder.write("manifest.csv", manifest);
            fleet(folder, &folder.at("manifest.csv"), "--threads 1").0
        });
    let tables: Vec<Sheet> = tables.collect();
    assert_eq!(tables[0].to_string(), tables[1].to_string());
    assert_eq!(tables[0].rows.len(), 1);
    assert_eq!(
        (tables[0].field(0, "postures"), tables[0].field(0, "error")),
        ("120", "")
    );

    // Nor does it depend on the path of the URDF where an error is about the robot.
    for only in DEPTHS {
        let wrong = folders.map(|folder| {
            let [urdf, out, data] = ["op2.urdf", "wrong.csv", "manifest.csv"].map(|n| folder.at(n));
            let to = format!("--out {out} --support nosuch --json {only}");
            let json = json(&folder.run(&format!("fleet {urdf} --data {data} {to}")));
            let said = json["failed"][0]["error"].as_str().unwrap();
            assert_eq!(said.matches("no link `nosuch`").count(), 1, "{said}");
            let table = folder.sheet("wrong.csv");
            says(table.field(0, "error"), &["no link `nosuch`"]);
            assert!(!table.field(0, "error").contains(&folder.at("")));
            table.to_string()
        });
        assert_eq!(wrong[0], wrong[1]);
    }
}

#[test]
fn logs_that_are_not_there_and_tables_of_no_kind_are_refused() {
    let folder = Folder::with("op2");
    for log in ["r1_d1.csv", "r1_monday.csv"] {
        folder.write(log, "pose\n");
    }
    folder.refuses_each(
        "fleet op2.urdf --data no*.csv --out fleet.csv | no file has such a name
         fleet op2.urdf --data r1_d1.csv --out fleet.xlsx | .parquet or .csv
         fleet op2.urdf --data r1_monday.csv --by robot,week --out weeks.csv
            | `week` | `monday` | 2031-05-01",
    );
}

/// Of several logs of a day one that cannot be used is left out, and `health` says why; what their
/// sidecars say may differ.
#[test]
fn a_log_without_data_does_not_take_its_day_along() {
    let folder = folder(&Fleet {
        postures: 40,
        ..Fleet::sound(1, 3, 9)
    });
    let mut still = folder.sheet(&log((0, 2)));
    still.set("cop_x", None, "0.01");
    still.set("cop_y", None, "0.01");
    folder.write(&log((0, 2)), still.to_string());
    let sidecar = log((0, 3)) + ".toml";
    folder.write(&sidecar, folder.read(&sidecar).replace("= 100", "= 50"));
    for only in DEPTHS {
        let (table, _) = fleet(&folder, "logs", &format!("--by robot {only}"));
        assert_eq!(table.rows.len(), 1);
        assert_eq!(
            (table.field(0, "postures"), table.field(0, "error")),
            ("80", "")
        );
        let verdict = if only.is_empty() { "none" } else { "" };
        assert_eq!(table.field(0, "verdict"), verdict);
        let health = held(&table, 0, "health");
        assert_eq!(health[0]["kind"], "cop_constant");
        assert_eq!(health.as_array().unwrap().len(), 1);
        assert_eq!(texts(&held(&table, 0, "inputs"), "").len(), 3);
    }
}

/// Fits without a diagnosis: the same parameters, no verdict; and changes are seen all the same.
#[test]
fn parameters_alone_are_those_of_the_whole_row() {
    let folder = folder(&Fleet {
        postures: 40,
        ..Fleet::sound(2, 1, 6)
    });
    let [alone, whole] = DEPTHS.map(|only| {
        let (table, json) = fleet(&folder, "logs", only);
        assert_eq!(json["groups"], 2);
        table
    });
    for row in 0..2 {
        let same = "robot day urdf_hash support postures params std inputs";
        for name in same.split(' ') {
            assert_eq!(whole.field(row, name), alone.field(row, name), "{name}");
        }
        assert_eq!(whole.field(row, "verdict"), "none");
        assert_eq!(alone.field(row, "verdict"), "");
        let none = r#"{"explanation":[],"instead":[],"scores":[]}"#;
        assert_eq!(
            (alone.field(row, "effects"), alone.field(row, "error")),
            (none, "")
        );
        says(alone.field(row, "sentence"), &["no diagnosis"]);
        let floor: f64 = alone.field(row, "noise_floor").parse().unwrap();
        assert!((0.8e-4..1.3e-4).contains(&floor), "{floor}");
    }
}

/// Days of one ISO week are one row, also of logs that are diagnosed together.
#[test]
fn a_row_for_each_robot_and_week() {
    let folder = folder(&Fleet {
        postures: 30,
        ..Fleet::sound(1, 3, 12)
    });
    // Thursday, Sunday and Monday.
    for (day, name) in [(1, "2031-05-01"), (2, "20310504"), (3, "2031-05-05")] {
        let from = folder.path().join(Fleet::folder(0, day));
        fs::rename(&from, from.with_file_name(format!("day={name}"))).unwrap();
    }
    for from_store in [0, 2] {
        let options = "--by robot,week --store rows";
        let (table, json) = fleet(&folder, "logs/robot=*/day=*/*.csv", options);
        assert_eq!(json["from_store"], from_store);
        let of = |row| ["robot", "day", "postures", "verdict"].map(|name| table.field(row, name));
        let rows: Vec<[&str; 4]> = (0..table.rows.len()).map(of).collect();
        let row = |week, postures| ["r00", week, postures, "none"];
        assert_eq!(rows, [row("2031-W18", "60"), row("2031-W19", "30")]);
    }
}

/// Each log stands on the foot that its sidecar says, in a group of both; without one on that of
/// its column `support`, as `fit` and `diagnose` read it.
#[test]
fn logs_stand_where_their_sidecar_or_their_column_says() {
    let folder = Folder::with("op2");
    let mut manifest = "path,robot,day\n".to_string();
    for (foot, seed) in [("r_sole", 1), ("l_sole", 2)] {
        let log = format!("--poses 60 --seed {seed} --noise 1e-4 --out {foot}.csv");
        folder.stdout(&format!("simulate op2.urdf --support {foot} {log}"));
        let mut sheet = folder.sheet(&format!("{foot}.csv"));
        sheet.add("support", |_| foot.to_string());
        folder.write(&format!("{foot}_1.csv"), sheet.to_string());
        manifest += &format!("{foot}.csv,both,1\n{foot}_1.csv,{foot},1\n");
    }
    folder.write("manifest.csv", manifest);
    for only in DEPTHS {
        let (table, _) = fleet(&folder, "manifest.csv", only);
        for (row, support) in ["", "l_sole", "r_sole"].into_iter().enumerate() {
            assert_eq!(table.field(row, "error"), "");
            if !support.is_empty() {
                assert_eq!(table.field(row, "support"), support);
                assert_eq!(table.field(row, "postures"), "60");
            }
        }
        if !only.is_empty() {
            assert_eq!(table.field(0, "postures"), "120");
            let error: f64 = table.field(0, "held_out_rmse").parse().unwrap();
            assert!(error < 3e-4, "{error}");
        }
    }
    for command in ["fit", "diagnose"] {
        let json = folder.json(&format!("{command} op2.urdf --data l_sole_1.csv"));
        assert_eq!(json["support"], "l_sole", "{command}");
    }
}
