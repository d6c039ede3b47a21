//! docs/formats.md names what readers take.

use std::collections::BTreeSet;
use std::fs;

use sesc_test_support::command::{ROOT, folder, op2, sesc};

use super::{blocks, read, run};

/// Keys of a row of a table: what stands in backticks.
fn keys_of(row: &str) -> BTreeSet<String> {
    let words = row.split('`').skip(1).step_by(2);
    words.map(str::to_string).collect()
}

/// The reader says itself which keys a sidecar may have.
#[test]
fn formats_name_every_key_of_sidecars() {
    let formats = read("docs/formats.md");
    let (folder, op2) = (folder(), op2());
    let line = "sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.001 --out log.csv";
    run(folder.path(), &line.replace("op2.urdf", &op2));
    let log = folder.path().join("log.csv");
    fs::write(log.with_extension("csv.toml"), "wxyz_uvw = 1\n").unwrap();
    let log = log.display().to_string();
    let said = sesc(&["fit", &op2, "--data", &log, "--support", "r_sole"]);
    let said = String::from_utf8(said.stderr).unwrap();
    let keys = said
        .split("known are ")
        .nth(1)
        .unwrap_or_else(|| panic!("{said}"));
    let keys = keys.lines().next().unwrap();
    let keys: Vec<&str> = keys.trim().split(", ").collect();
    assert!(keys.len() > 9, "{keys:?}");
    for key in keys {
        assert!(formats.contains(&format!("\n| `{key}` | ")), "{key}");
    }
}

/// Columns are those that the commands name in their help.
#[test]
fn formats_name_every_column_and_key() {
    let formats = read("docs/formats.md");
    let columns = sesc_identify::logs::columns_text();
    // Further lines of a meaning stand below its first.
    let starts = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    for line in columns.lines().skip(1).filter(starts) {
        let names = line
            .split("  ")
            .find(|part| !part.trim().is_empty())
            .unwrap();
        for name in names.split(',').map(str::trim) {
            let name = match name {
                "JOINT" => "a joint's name".to_string(),
                "fsr_k" => "`fsr_1`".to_string(),
                "fsr_k_std" => "`fsr_1_std`".to_string(),
                name => format!("`{name}`"),
            };
            assert!(formats.contains(&name), "{name}");
        }
    }
}

/// The topics of a recording of a diagnosis, and the types of their messages, are those of its
/// table.
#[test]
fn formats_name_every_topic_of_a_recording() {
    let formats = read("docs/formats.md");
    let (_, part) = formats.split_once("### Recording of a diagnosis").unwrap();
    let (part, _) = part.split_once("\n## ").unwrap();
    let folder = folder();
    let simulate =
        "sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.0005 --out log.csv";
    run(folder.path(), &simulate.replace("op2.urdf", &op2()));
    let diagnose = format!("sesc diagnose {} --data log.csv --mcap out.mcap", op2());
    run(folder.path(), &diagnose);
    let bytes = fs::read(folder.path().join("out.mcap")).unwrap();
    let text = String::from_utf8_lossy(&bytes);
    let rows = part.lines().filter(|line| line.starts_with("| `/"));
    let named: BTreeSet<String> = rows.flat_map(keys_of).collect();
    assert_eq!(named.len(), 6 + 3, "{named:?}");
    for name in named {
        assert!(text.contains(&name), "{name}");
    }
}

/// The blocks of TOML are what the readers take.
#[test]
fn files_of_the_formats_page_are_read() {
    let formats = read("docs/formats.md");
    let blocks = blocks(&formats, "toml");
    assert_eq!(blocks.len(), 4);
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::copy(format!("{ROOT}/robots/op2/op2.urdf"), at("op2.urdf")).unwrap();
    let run = |line: &str| run(folder.path(), line);
    run("sesc simulate op2.urdf --support r_sole --poses 60 --noise 0.001 --out run.csv");
    // The log has its CoP already, and is of no experiment.
    let unused = ["cells", "experiment", "topic", "readings_per_pose"];
    let sidecar = blocks[0]
        .lines()
        .filter(|line| !unused.iter().any(|key| line.starts_with(key)));
    fs::write(at("run.csv.toml"), sidecar.collect::<Vec<_>>().join("\n")).unwrap();
    fs::write(at("prior.toml"), &blocks[1]).unwrap();
    fs::write(at("servos.toml"), &blocks[2]).unwrap();
    let warned = run("sesc fit op2.urdf --data run.csv --prior prior.toml 2>&1 >/dev/null");
    assert_eq!(warned, "");
    run("sesc diagnose op2.urdf --data run.csv --servos servos.toml");

    fs::write(at("sesc.toml"), &blocks[3]).unwrap();
    fs::write(
        at("limits.csv"),
        "joint,lower_deg,upper_deg\nhead_pan,-5,5\n",
    )
    .unwrap();
    let planned = run("sesc plan op2.urdf --poses 3 --candidates 100 --out poses.csv 2>&1");
    assert!(
        planned.contains("--support=r_sole --prior=tight --noise=0.0005"),
        "{planned}"
    );
}
