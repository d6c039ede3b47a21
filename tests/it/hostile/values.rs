//! Values that no robot, sensor or gear has: refused where they stand, with their line and
//! column, before anything is computed, printed or written.

use std::process::Output;
use std::time::{Duration, Instant};

use sesc_test_support::command::{Folder, refused, stderr};

/// A log of the OP2 on its right sole, and its lines.
fn log() -> (Folder, Vec<String>) {
    let folder = Folder::with_log("--poses 60 --range 20 --noise 0.0005");
    let lines = folder.read("log.csv");
    let lines = lines.lines().map(str::to_string).collect();
    (folder, lines)
}

/// The log with another value in a column: in every row, or in one.
fn changed(lines: &[String], name: &str, value: &str, all: bool) -> Vec<String> {
    let place = lines[0].split(',').position(|own| own == name).unwrap();
    let change = |(k, line): (usize, &String)| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if k > 0 && (all || k == 17) {
            cells[place] = value;
        }
        cells.join(",")
    };
    lines.iter().enumerate().map(change).collect()
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
    let (folder, lines) = log();
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
        folder.write("log.csv", changed(&lines, column, value, false).join("\n"));
        for way in WAYS {
            let line = format!("{way} --out m.toml");
            let words = ["log.csv:18", &format!("`{column}`"), word];
            let output = refuses(&folder, &line, &words);
            assert!(output.stderr.len() < 400, "{}", stderr(&output));
        }
    }
    let number = |(k, line): (usize, &String)| match k {
        0 => format!("{line},t"),
        k => format!("{line},{k}"),
    };
    let timed: Vec<String> = lines.iter().enumerate().map(number).collect();
    for value in ["1e16", "-1e300"] {
        folder.write("log.csv", changed(&timed, "t", value, false).join("\n"));
        refuses(&folder, FIT, &["log.csv:18", "`t`", "seconds"]);
    }
    // Deviations in another unit.
    let wide = changed(&lines, "cop_x_std", "0.5", true);
    let wide = changed(&wide, "cop_y_std", "0.5", true);
    folder.write("log.csv", wide.join("\n"));
    for way in [FIT, DIAGNOSE] {
        refuses(&folder, way, &["cop_x_std", "0.7", "metres"]);
    }
}

/// A reading 100 m away is named, left out, and does not spoil the rest; a sensor that is not
/// connected makes no fit "exact".
#[test]
fn one_outlier_is_named_and_left_out_and_a_dead_sensor_is_no_noise_free_one() {
    let (folder, lines) = log();
    folder.write("log.csv", changed(&lines, "cop_x", "100", false).join("\n"));
    for way in WAYS {
        let answer = folder.json(way).to_string();
        assert!(answer.contains("cop_outside_sole"), "{way:?}: {answer}");
        assert!(!answer.contains("NaN"), "{way:?}");
    }
    for value in ["0", "0.0123"] {
        let dead = changed(&lines, "cop_x", value, true);
        folder.write("log.csv", changed(&dead, "cop_y", value, true).join("\n"));
        let output = folder.run(FIT);
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stdout).contains("does not move"));
    }
}

/// One row, or two, again and again are no data: nothing is left to tell the noise by, and
/// what a fit says of itself would be perfect.
#[test]
fn copies_of_one_reading_are_refused() {
    let (folder, lines) = log();
    // Columns of deviations stand last.
    let until = lines[0].find(",cop_x_std").unwrap();
    let columns = lines[0].split(',').count();
    for kept in [columns, lines[0][..until].split(',').count()] {
        for distinct in [1, 2] {
            let row = |k: usize| {
                let line = &lines[if k == 0 { 0 } else { 1 + k % distinct }];
                line.split(',').take(kept).collect::<Vec<_>>().join(",") + "\n"
            };
            folder.write("log.csv", (0..61).map(row).collect::<String>());
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
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial>\
             </link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, rest: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child \
             link='{child}'/><origin xyz='0 0 0.2'/><axis xyz='0 1 0'/><limit lower='-2' \
             upper='2'/>{rest}</joint>"
        )
    };
    let links = ["foot", "a", "b", "c"].map(link).concat();
    let joints = [
        joint("j1", "foot", "a", ""),
        joint("j2", "a", "b", &format!("<mimic joint='j1' {mimic}/>")),
        joint(
            "j3",
            "b",
            "c",
            &format!("<mimic joint='j2' multiplier='{factor}'/>"),
        ),
    ];
    format!("<robot name='r'>{links}{}</robot>", joints.concat())
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
        for command in [
            "verify",
            "inspect",
            "simulate --poses 5 --out out.csv",
            "plan --poses 5 --out out.csv",
            "generate --out out",
        ] {
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
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The robot reaches no metre.
    let allowed = json["bound"]["zmp"].as_f64().unwrap();
    assert!(allowed <= 1e-9, "{allowed}");
    // What errs by more than that fails, whatever the proven bound would allow.
    let mut errors = json["worst_error"].as_object().unwrap().iter();
    let within = errors.all(|(function, error)| {
        error.as_f64().unwrap() <= json["bound"][function].as_f64().unwrap()
    });
    assert_eq!(json["pass"], within);
    assert_eq!(output.status.code(), Some(i32::from(!within)));
    let beyond = json["beyond_use"].as_array().unwrap();
    assert!(beyond.contains(&"zmp".into()), "{beyond:?}");
    let table = folder.run(verify).stdout;
    let table = String::from_utf8_lossy(&table);
    assert!(table.contains("thousandth of the robot's reach"), "{table}");
    folder.write("r.urdf", tied("multiplier='3'", "1"));
    let json = folder.json(verify);
    assert_eq!(json["pass"], true);
    assert_eq!(json["beyond_use"].as_array().unwrap().len(), 0);
}

/// Hundreds of joints that follow one: numbers cannot tell the rank, and that is what is said.
#[test]
fn inspect_says_where_numbers_tell_no_rank() {
    let folder = Folder::empty();
    folder.write("r.urdf", super::sizes::chain(200, true));
    let output = folder.run("inspect r.urdf --support l0 --json");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
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
            refuses(
                &folder,
                &format!("{command} --support foot r.urdf"),
                &[word],
            );
        }
    }
}
