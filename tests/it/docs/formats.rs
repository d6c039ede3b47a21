//! docs/formats.md names what readers take and what is written.

use std::collections::BTreeSet;

use sesc_test_support::command::Folder;

use super::{blocks, read, run};

/// Keys of tables, but those that are names of something.
fn keys(table: &toml::Table, all: &mut BTreeSet<String>) {
    for (key, value) in table {
        all.insert(key.clone());
        let inner: Vec<&toml::Value> = match value {
            toml::Value::Array(values) => values.iter().collect(),
            value => vec![value],
        };
        for inner in inner.into_iter().filter_map(toml::Value::as_table) {
            keys(inner, all);
        }
    }
}

/// Columns and keys that readers know, keys of a model file: each stands in backticks.
#[test]
fn formats_name_every_column_and_key() {
    let columns = sesc_identify::logs::COLUMNS.iter();
    let columns = columns.flat_map(|column| column.names).copied();
    let sidecar = sesc_identify::logs::SIDECAR_KEYS.map(|(key, _)| key);
    let options = sesc::cli::robot_keys();
    let known = columns
        .filter(|name| *name != "JOINT")
        .chain(sidecar)
        .chain(options);
    let known = known.map(|name| name.replace("fsr_k", "fsr_1"));
    let mut all: BTreeSet<String> = known.collect();
    let folder = Folder::with("op2");
    for line in [
        "sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 \
         --hide joint_offset:r_knee=3deg --out log.csv",
        "sesc diagnose op2.urdf --data log.csv --out model.toml",
    ] {
        run(folder.path(), line);
    }
    let model = folder.read("model.toml");
    keys(&model.parse().unwrap(), &mut all);
    let formats = read("docs/formats.md");
    for name in all {
        let named = [
            format!("`{name}`"),
            format!("`[{name}]`"),
            format!("`[[{name}]]`"),
        ];
        assert!(named.iter().any(|name| formats.contains(name)), "{name}");
    }
}

/// The blocks of TOML are what the readers take.
#[test]
fn files_of_the_formats_page_are_read() {
    let formats = read("docs/formats.md");
    let blocks = blocks(&formats, "toml");
    assert_eq!(blocks.len(), 4);
    let folder = Folder::with("op2");
    let run = |line: &str| run(folder.path(), line);
    run("sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.001 --out run.csv");
    // The log has its CoP already, and is of no experiment.
    let unused = ["cells", "experiment", "topic", "readings_per_pose"];
    let sidecar = blocks[0]
        .lines()
        .filter(|line| !unused.iter().any(|key| line.starts_with(key)));
    folder.write("run.csv.toml", sidecar.collect::<Vec<_>>().join("\n"));
    folder.write("prior.toml", &blocks[1]);
    folder.write("servos.toml", &blocks[2]);
    let warned = run("sesc fit op2.urdf --data run.csv --prior prior.toml 2>&1 >/dev/null");
    assert_eq!(warned, "");
    run("sesc diagnose op2.urdf --data run.csv --servos servos.toml");

    folder.write("sesc.toml", &blocks[3]);
    folder.write("limits.csv", "joint,lower_deg,upper_deg\nhead_pan,-5,5\n");
    let planned = run("sesc plan op2.urdf --poses 3 --candidates 100 --out poses.csv 2>&1");
    assert!(
        planned.contains("--support=r_sole --prior=tight --noise=0.0005"),
        "{planned}"
    );
}
