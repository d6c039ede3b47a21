//! Values that no robot, sensor or gear has: refused where they stand, with their line and
//! column, before anything is computed, printed or written.

use std::process::Output;
use std::time::{Duration, Instant};

use sesc_test_support::command::{Folder, Sheet, json, list, number, refused, says, stderr, texts};
use sesc_test_support::trees::Urdf;

/// A log of the OP2 on its right sole.
fn log() -> (Folder, Sheet) {
    let folder = Folder::with_log("--poses 60 --range 20 --noise 0.0005");
    let log = folder.sheet("log.csv");
    (folder, log)
}

/// Writes the log with other values in columns: in every row, or in the seventeenth.
fn changed(folder: &Folder, log: &Sheet, values: &[(&str, &str)], all: bool) {
    let mut log = log.clone();
    let row = (!all).then_some(16);
    values
        .iter()
        .for_each(|(name, value)| log.set(name, row, value));
    folder.write("log.csv", log.to_string());
}

/// Ways to fit and to diagnose a log of the OP2.
const WAYS: [&str; 5] = [
    "fit op2.urdf --support r_sole --data log.csv --robust tukey",
    "fit op2.urdf --support r_sole --data log.csv --robust huber",
    "fit op2.urdf --support r_sole --data log.csv --prior free --physical",
    "diagnose op2.urdf --support r_sole --data log.csv --prior free",
    DIAGNOSE,
];
const FIT: &str = "fit op2.urdf --support r_sole --data log.csv";
const DIAGNOSE: &str = "diagnose op2.urdf --support r_sole --data log.csv";

/// Refuses a command with these words, within seconds and without a file.
fn refuses(folder: &Folder, line: &str, words: &[&str]) -> Output {
    let (before, begun) = (folder.names(), Instant::now());
    let output = folder.run(line);
    refused(&output, words);
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(20), "{line}: {took:?}");
    assert_eq!(folder.names(), before, "{line}");
    output
}

#[test]
fn a_value_beyond_every_sensor_is_refused_with_line_and_column() {
    let (folder, log) = log();
    for (column, value, word) in [
        ("cop_x", "1.7976931348623157e308", "beyond 1e6"),
        ("cop_y", "-1e200", "beyond 1e6"),
        ("cop_x", "inf", "finite"),
        ("cop_x_std", "1e300", "beyond 1e6"),
        ("cop_y_std", "0", "positive"),
        // A servo that answers with the largest integer.
        ("r_knee", "2147483647", "rad"),
        ("l_el", "1e308", "rad"),
    ] {
        changed(&folder, &log, &[(column, value)], false);
        for way in WAYS {
            let line = format!("{way} --out m.toml");
            let words = ["log.csv:18", &format!("`{column}`"), word];
            let output = refuses(&folder, &line, &words);
            assert!(output.stderr.len() < 400, "{}", stderr(&output));
        }
    }
    let mut timed = log.clone();
    timed.add("t", |k| k.to_string());
    for value in ["1e16", "-1e300"] {
        changed(&folder, &timed, &[("t", value)], false);
        refuses(&folder, FIT, &["log.csv:18", "`t`", "seconds"]);
    }
    // Deviations in another unit.
    let wide = [("cop_x_std", "0.5"), ("cop_y_std", "0.5")];
    changed(&folder, &log, &wide, true);
    for way in [FIT, DIAGNOSE] {
        refuses(&folder, way, &["cop_x_std", "0.7", "metres"]);
    }
}

/// A reading 100 m away is named, left out, and does not spoil the rest; a sensor that is not
/// connected makes no fit "exact".
#[test]
fn one_outlier_is_named_and_left_out_and_a_dead_sensor_is_no_noise_free_one() {
    let (folder, log) = log();
    changed(&folder, &log, &[("cop_x", "100")], false);
    for way in WAYS {
        let answer = folder.json(way).to_string();
        assert!(answer.contains("cop_outside_sole"), "{way:?}: {answer}");
        assert!(!answer.contains("NaN"), "{way:?}");
    }
    for value in ["0", "0.0123"] {
        changed(&folder, &log, &[("cop_x", value), ("cop_y", value)], true);
        says(folder.json_of(1, FIT).to_string(), &["does not move"]);
    }
}

/// One row, or two, again and again are no data: nothing is left to tell the noise by, and
/// what a fit says of itself would be perfect.
#[test]
fn copies_of_one_reading_are_refused() {
    let (folder, log) = log();
    for is_stated in [true, false] {
        for distinct in [1, 2] {
            let mut copies = log.clone();
            copies.keep(|name| is_stated || !name.ends_with("_std"));
            let rows = copies.rows[..distinct].iter().cycle();
            copies.rows = rows.take(60).cloned().collect();
            folder.write("log.csv", copies.to_string());
            for way in WAYS {
                let line = format!("{way} --out m.toml");
                refuses(&folder, &line, &["log.csv", "60 rows are copies"]);
            }
        }
    }
}

#[test]
fn gravity_along_the_sole_is_refused() {
    let (folder, _) = log();
    for gravity in [
        "1e308, 0.0, -1.0",
        "9.8, 0.0, -1e-9",
        "0.0, 0.0, -1e300",
        "nan, 0.0, -1.0",
    ] {
        let sidecar = format!("support = 'r_sole'\ngravity = [{gravity}]\n");
        folder.write("log.csv.toml", sidecar);
        for command in ["fit", "diagnose", "predict"] {
            let line = format!("{command} op2.urdf --data log.csv");
            refuses(&folder, &line, &["gravity"]);
        }
    }
}

/// A robot of three joints; the second follows the first by `mimic`, the third the second by
/// `factor`.
fn tied(mimic: &str, factor: &str) -> String {
    let links = ["foot", "a", "b", "c"].into_iter();
    let robot = links.fold(Urdf::new("r"), |robot, name| {
        robot.link(name, 1.0, "0 0 0.1")
    });
    let tied = [
        String::new(),
        format!("<mimic joint='j1' {mimic}/>"),
        format!("<mimic joint='j2' multiplier='{factor}'/>"),
    ];
    let pairs = [["foot", "a"], ["a", "b"], ["b", "c"]]
        .into_iter()
        .zip(tied);
    let robot = (1..).zip(pairs).fold(robot, |robot, (k, (links, mimic))| {
        let rest = "<origin xyz='0 0 0.2'/><axis xyz='0 1 0'/><limit lower='-2' upper='2'/>";
        robot.joint(
            &format!("j{k}"),
            "revolute",
            links,
            &format!("{rest}{mimic}"),
        )
    });
    robot.text()
}

#[test]
fn mimics_beyond_every_gear_are_refused() {
    let folder = Folder::empty();
    for (mimic, joint) in [
        ("multiplier='2e6'", "`j2`"),
        ("multiplier='1e17'", "`j2`"),
        ("offset='1e6'", "`j2`"),
        // Each is a gear, the two of them are none.
        ("multiplier='4e3'", "`j3`"),
    ] {
        folder.write("r.urdf", tied(mimic, "3e3"));
        let out = "--poses 5 --out out.csv";
        let writing = [format!("simulate {out}"), format!("plan {out}")];
        let others = ["verify", "inspect", "generate --out out"].map(String::from);
        for command in writing.iter().chain(&others) {
            let line = format!("{command} --support foot r.urdf");
            refuses(&folder, &line, &["r.urdf:1", joint, "gear"]);
        }
    }
    folder.write("r.urdf", tied("multiplier='3'", "3e3"));
    folder.stdout("inspect r.urdf --support foot");
}

/// Agreement within metres would verify nothing of a robot with a gear of 9000.
#[test]
fn a_bound_beyond_use_is_replaced_by_a_billionth_of_the_reach() {
    let folder = Folder::empty();
    folder.write("r.urdf", tied("multiplier='9e3'", "1"));
    let verify = "verify r.urdf --support foot --samples 20";
    let output = folder.run(&format!("{verify} --json"));
    let found = json(&output);
    // The robot reaches no metre.
    assert!(number(&found, "/bound/zmp") <= 1e-9, "{found}");
    // What errs by more than that fails, whatever the proven bound would allow.
    let mut errors = found["worst_error"].as_object().unwrap().keys();
    let is_within = |function: &String| {
        let [error, bound] = ["worst_error", "bound"].map(|key| format!("/{key}/{function}"));
        number(&found, &error) <= number(&found, &bound)
    };
    let within = errors.all(is_within);
    assert_eq!(found["pass"], within);
    assert_eq!(output.status.code(), Some(i32::from(!within)));
    assert!(texts(&found, "/beyond_use").contains(&"zmp"), "{found}");
    let table = folder.run(verify).stdout;
    let table = String::from_utf8_lossy(&table);
    says(table, &["thousandth of the robot's reach"]);
    folder.write("r.urdf", tied("multiplier='3'", "1"));
    let json = folder.json(verify);
    assert_eq!(json["pass"], true);
    assert_eq!(list(&json, "/beyond_use").len(), 0);
}

/// Hundreds of joints that follow one: numbers cannot tell the rank, and that is what is said.
#[test]
fn inspect_says_where_numbers_tell_no_rank() {
    let folder = Folder::empty();
    folder.write("r.urdf", super::sizes::chain(200, true));
    let output = folder.run("inspect r.urdf --support l0 --json");
    let json = json(&output);
    let agrees = json["rank"] == json["numeric_rank"];
    let expected = if agrees { "agrees" } else { "undecided" };
    assert_eq!(json["rank_check"], expected);
    let said = stderr(&output);
    assert!(agrees || said.contains("without a gap"), "{said}");
}

/// Effects that no robot has give neither numbers nor code.
#[test]
fn model_files_with_absurd_values_are_refused() {
    let folder = Folder::with("two_link");
    folder.stdout("simulate two_link.urdf --support foot --poses 30 --noise 0.0005 --out log.csv");
    folder.stdout("fit two_link.urdf --data log.csv --out good.toml");
    let good = folder.read("good.toml");
    let first = good.find("value = ").unwrap();
    let end = first + good[first..].find('\n').unwrap();
    let information = good.find("[information]").unwrap_or(good.len());
    let plus = |effect: &str, target: &str, parameter: &str, value: &str| {
        let effect = format!(
            "[[effects]]\neffect = \"{effect}\"\ntarget = \"{target}\"\n\
             parameters.{parameter} = {{ value = {value} }}\n"
        );
        format!("{}{effect}{}", &good[..information], &good[information..])
    };
    for bad in [
        good.replacen(&good[first..end], "value = 1e39", 1),
        good.replacen(&good[first..end], "value = inf", 1),
        plus("joint_offset", "knee", "offset_rad", "1e7"),
        plus("sensor_offset", "-", "x_m", "1e308"),
        plus("joint_offset", "knee", "offset_rad", "nan"),
    ] {
        folder.write("model.toml", bad);
        for command in [
            "generate --lang c --scalar f32 --out out",
            "generate --out out",
            "predict --data log.csv",
            "simulate --poses 3 --out out.csv",
        ] {
            let line = format!("{command} --support foot --model model.toml two_link.urdf");
            refuses(&folder, &line, &["model.toml"]);
        }
    }
}

#[test]
fn angles_beyond_all_turns_and_robots_of_no_weight_are_refused() {
    let folder = Folder::empty();
    for (rpy, mass, inertia, word) in [
        ("1e17", "1", "1", "whole turns"),
        ("0", "1e-310", "1", "no mass"),
        ("0", "1e308", "1", "give it in kg"),
        ("0", "1", "1e308", "inertia iyy is 1e308 kg m²"),
        ("0", "1", "-1e16", "inertia iyy is -1e16 kg m²"),
    ] {
        let text = format!(
            "<robot name='r'><link name='foot'/><link name='a'><inertial><mass value='{mass}'/>\
             <inertia ixx='1' iyy='{inertia}' izz='1'/></inertial></link>\
             <joint name='j' type='revolute'><parent link='foot'/><child link='a'/>\
             <origin rpy='{rpy} 0 0'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint>\
             </robot>"
        );
        folder.write("r.urdf", text);
        for command in ["verify", "inspect", "generate --out out"] {
            let line = format!("{command} --support foot r.urdf");
            refuses(&folder, &line, &[word]);
        }
    }
}
