//! Values that no robot, sensor or gear has: refused where they stand, with their line and
//! column, before anything is computed, printed or written.

use std::fmt::Write as _;
use std::fs;

use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};

use sesc_test_support::command::{ROOT, folder, op2, refused, sesc, stdout, write};

pub(super) fn two_link() -> String {
    format!("{ROOT}/robots/two_link/two_link.urdf")
}

/// A log of the OP2 on its right sole, as lines.
fn log(folder: &Path) -> Vec<String> {
    let path = folder.join("true.csv").display().to_string();
    let simulate = ["simulate", &op2(), "--support", "r_sole", "--poses", "60"];
    let noise = ["--range", "20", "--noise", "0.0005", "--out", &path];
    stdout(&sesc(&[&simulate[..], &noise].concat()));
    let text = fs::read_to_string(path).unwrap();
    text.lines().map(str::to_string).collect()
}

/// The same with the column `name` of the rows `rows` (from 1) changed.
fn changed(lines: &[String], name: &str, value: &str, all: bool) -> String {
    let place = lines[0].split(',').position(|own| own == name).unwrap();
    let mut out = String::new();
    for (k, line) in lines.iter().enumerate() {
        let mut cells: Vec<&str> = line.split(',').collect();
        if k > 0 && (all || k == 17) {
            cells[place] = value;
        }
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// The output, which must come within seconds.
pub(super) fn soon(arguments: &[&str]) -> Output {
    let begun = Instant::now();
    let output = sesc(arguments);
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(20), "{arguments:?}: {took:?}");
    output
}

#[test]
fn a_value_beyond_every_sensor_is_refused_with_line_and_column() {
    let folder = folder();
    let lines = log(folder.path());
    for (column, value, word) in [
        ("cop_x", "1.7976931348623157e308", "beyond 1e6"),
        ("cop_y", "-1e200", "beyond 1e6"),
        ("cop_x", "NaN", "finite"),
        ("cop_x_std", "1e300", "beyond 1e6"),
        ("cop_y_std", "0", "positive"),
        // A servo that answers with the largest integer.
        ("r_knee", "2147483647", "rad"),
        ("l_el", "1e308", "rad"),
    ] {
        let text = changed(&lines, column, value, false);
        let log = write(folder.path(), "log.csv", text);
        let out = folder.path().join("m.toml").display().to_string();
        for way in WAYS {
            let output = evaluated(&[way, &["--out", &out]].concat(), &log);
            refused(&output, &["log.csv:18", &format!("`{column}`"), word]);
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(message.len() < 400, "{message}");
        }
        assert!(!Path::new(&out).exists());
    }
    for value in ["1e16", "-1e300"] {
        let mut lines = lines.clone();
        lines[0] += ",t";
        for (k, line) in lines.iter_mut().enumerate().skip(1) {
            let t = k.to_string();
            *line += &format!(",{}", if k == 17 { value } else { &t });
        }
        let log = write(folder.path(), "log.csv", lines.join("\n"));
        let output = soon(&["fit", &op2(), "--support", "r_sole", "--data", &log]);
        refused(&output, &["log.csv:18", "`t`", "seconds"]);
    }
}

/// Ways to fit and to diagnose.
const WAYS: [&[&str]; 5] = [
    &["fit", "--robust", "tukey"],
    &["fit", "--robust", "huber"],
    &["fit", "--prior", "free", "--physical"],
    &["diagnose", "--prior", "free"],
    &["diagnose"],
];

/// One way on a log of the OP2.
fn evaluated(way: &[&str], log: &str) -> Output {
    let urdf = op2();
    let rest = [
        urdf.as_str(),
        "--support",
        "r_sole",
        "--data",
        log,
        "--json",
    ];
    soon(&[&way[..1], &rest, &way[1..]].concat())
}

/// A reading 100 m away is named, left out, and does not spoil the rest.
#[test]
fn one_outlier_is_named_and_left_out() {
    let folder = folder();
    let lines = log(folder.path());
    let text = changed(&lines, "cop_x", "100", false);
    let log = write(folder.path(), "log.csv", text);
    for way in WAYS {
        let answer = stdout(&evaluated(way, &log));
        assert!(answer.contains("cop_outside_sole"), "{way:?}: {answer}");
        assert!(!answer.contains("NaN"), "{way:?}");
    }
}

/// One row, or two, again and again are no data: nothing is left to tell the noise by, and
/// what a fit says of itself would be perfect.
#[test]
fn copies_of_one_reading_are_refused() {
    let folder = folder();
    let mut lines = log(folder.path());
    let out = folder.path().join("model.toml").display().to_string();
    for stated in [true, false] {
        if !stated {
            // Without the columns of deviations, which stand last.
            let until = lines[0].find(",cop_x_std").unwrap();
            let columns = lines[0][..until].split(',').count();
            for line in &mut lines {
                *line = line.split(',').take(columns).collect::<Vec<_>>().join(",");
            }
        }
        for distinct in [1, 2] {
            let row = |k: usize| lines[if k == 0 { 0 } else { 1 + k % distinct }].clone();
            let text: String = (0..61).map(|k| row(k) + "\n").collect();
            let log = write(folder.path(), "log.csv", text);
            for way in WAYS {
                let way = [way, &["--out", &out]].concat();
                refused(&evaluated(&way, &log), &["log.csv", "60 rows are copies"]);
            }
        }
    }
    assert!(!Path::new(&out).exists());
}

#[test]
fn deviations_in_another_unit_are_named() {
    let folder = folder();
    let lines = log(folder.path());
    let x = changed(&lines, "cop_x_std", "0.5", true);
    let x: Vec<String> = x.lines().map(str::to_string).collect();
    let log = write(
        folder.path(),
        "log.csv",
        changed(&x, "cop_y_std", "0.5", true),
    );
    for command in ["fit", "diagnose"] {
        let output = sesc(&[command, &op2(), "--support", "r_sole", "--data", &log]);
        refused(&output, &["cop_x_std", "0.7", "metres"]);
    }
}

/// A sensor that is not connected: no fit is "exact".
#[test]
fn a_sensor_that_never_changes_is_no_noise_free_one() {
    let folder = folder();
    let lines = log(folder.path());
    for value in ["0", "0.0123"] {
        let x = changed(&lines, "cop_x", value, true);
        let x: Vec<String> = x.lines().map(str::to_string).collect();
        let log = write(folder.path(), "log.csv", changed(&x, "cop_y", value, true));
        let output = sesc(&["fit", &op2(), "--support", "r_sole", "--data", &log]);
        assert_eq!(output.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&output.stdout).contains("does not move"));
    }
}

#[test]
fn gravity_along_the_sole_is_refused() {
    let folder = folder();
    let lines = log(folder.path());
    let log = write(folder.path(), "log.csv", lines.join("\n"));
    for gravity in [
        "1e308, 0.0, -1.0",
        "9.8, 0.0, -1e-9",
        "0.0, 0.0, -1e300",
        "nan, 0.0, -1.0",
    ] {
        let sidecar = format!("support = 'r_sole'\ngravity = [{gravity}]\n");
        write(folder.path(), "log.csv.toml", sidecar);
        for command in ["fit", "diagnose", "predict"] {
            refused(&soon(&[command, &op2(), "--data", &log]), &["gravity"]);
        }
    }
}

/// A robot of two links; the second follows the first by `mimic`.
fn tied(mimic: &str) -> String {
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
        joint("j2", "a", "b", mimic),
        joint("j3", "b", "c", "<mimic joint='j2' multiplier='3e3'/>"),
    ];
    format!("<robot name='r'>{links}{}</robot>", joints.concat())
}

#[test]
fn mimics_beyond_every_gear_are_refused() {
    let folder = folder();
    for (mimic, joint) in [
        ("<mimic joint='j1' multiplier='2e6'/>", "`j2`"),
        ("<mimic joint='j1' multiplier='1e17'/>", "`j2`"),
        ("<mimic joint='j1' offset='1e6'/>", "`j2`"),
        // Each is a gear, the two of them are none.
        ("<mimic joint='j1' multiplier='4e3'/>", "`j3`"),
    ] {
        let urdf = write(folder.path(), "r.urdf", tied(mimic));
        let out = folder.path().join("out.csv").display().to_string();
        for command in [
            &["verify"][..],
            &["inspect"],
            &["simulate", "--poses", "5", "--out", &out],
            &["plan", "--poses", "5", "--out", &out],
            &["generate", "--out", &out],
        ] {
            let robot = [urdf.as_str(), "--support", "foot"];
            let output = soon(&[&command[..1], &robot, &command[1..]].concat());
            refused(&output, &["r.urdf:1", joint, "gear"]);
        }
        assert!(!Path::new(&out).exists());
    }
    let urdf = write(
        folder.path(),
        "r.urdf",
        tied("<mimic joint='j1' multiplier='3'/>"),
    );
    stdout(&sesc(&["inspect", &urdf, "--support", "foot"]));
}

/// Agreement within metres would verify nothing of a robot with a gear of 9000.
#[test]
fn a_bound_beyond_use_is_replaced_by_a_billionth_of_the_reach() {
    let folder = folder();
    let robot = |factor: &str| {
        let mimic = format!("<mimic joint='j1' multiplier='{factor}'/>");
        let text = tied(&mimic).replace("multiplier='3e3'", "multiplier='1'");
        write(folder.path(), "r.urdf", text)
    };
    let verify = |urdf: &str| {
        let samples = ["--samples", "20", "--json"];
        soon(&[&["verify", urdf, "--support", "foot"][..], &samples].concat())
    };
    let wide = robot("9e3");
    let output = verify(&wide);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // The robot reaches no metre.
    let allowed = json["bound"]["zmp"].as_f64().unwrap();
    assert!(allowed <= 1e-9, "{allowed}");
    // What errs by more than that fails, whatever the proven bound would allow.
    let errors = json["worst_error"].as_object().unwrap();
    let within = errors.iter().all(|(function, error)| {
        let allowed = json["bound"][function].as_f64().unwrap();
        error.as_f64().unwrap() <= allowed
    });
    assert_eq!(json["pass"], within);
    assert_eq!(output.status.code(), Some(i32::from(!within)));
    let beyond = json["beyond_use"].as_array().unwrap();
    assert!(beyond.contains(&"zmp".into()), "{beyond:?}");
    let table = sesc(&["verify", &wide, "--support", "foot", "--samples", "20"]);
    let table = String::from_utf8_lossy(&table.stdout);
    assert!(table.contains("thousandth of the robot's reach"), "{table}");
    let json: serde_json::Value = serde_json::from_str(&stdout(&verify(&robot("3")))).unwrap();
    assert_eq!(json["pass"], true);
    assert_eq!(json["beyond_use"].as_array().unwrap().len(), 0);
}

/// Hundreds of joints that follow one: numbers cannot tell the rank, and that is what is said.
#[test]
fn inspect_says_where_numbers_tell_no_rank() {
    let folder = folder();
    let urdf = write(folder.path(), "r.urdf", super::sizes::chain(200, true));
    let output = soon(&["inspect", &urdf, "--support", "l0", "--json"]);
    let said = String::from_utf8_lossy(&output.stderr);
    let json: serde_json::Value = serde_json::from_str(&stdout(&output)).unwrap();
    match json["rank"] == json["numeric_rank"] {
        true => assert_eq!(json["rank_check"], "agrees"),
        false => {
            assert_eq!(json["rank_check"], "undecided");
            assert!(said.contains("without a gap"), "{said}");
        }
    }
}

/// Effects that no robot has give neither numbers nor code.
#[test]
fn model_files_with_absurd_values_are_refused() {
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let urdf = two_link();
    let robot = [urdf.as_str(), "--support", "foot"];
    let simulate = ["--poses", "30", "--noise", "0.0005", "--out", &log];
    stdout(&sesc(&[&["simulate"], &robot[..], &simulate].concat()));
    let good = folder.path().join("good.toml").display().to_string();
    stdout(&sesc(&["fit", &two_link(), "--data", &log, "--out", &good]));
    let good = fs::read_to_string(good).unwrap();
    let effect = |name: &str, target: &str, parameter: &str, value: &str| {
        format!(
            "[[effects]]\neffect = \"{name}\"\ntarget = \"{target}\"\nparameters.{parameter} = \
             {{ value = {value} }}\n"
        )
    };
    let first = good.find("value = ").unwrap();
    let end = first + good[first..].find('\n').unwrap();
    let information = good.find("[information]").unwrap_or(good.len());
    let plus = |effect: String| format!("{}{effect}{}", &good[..information], &good[information..]);
    for bad in [
        good.replacen(&good[first..end], "value = 1e39", 1),
        good.replacen(&good[first..end], "value = inf", 1),
        plus(effect("joint_offset", "knee", "offset_rad", "1e7")),
        plus(effect("sensor_offset", "-", "x_m", "1e308")),
        plus(effect("joint_offset", "knee", "offset_rad", "nan")),
    ] {
        let model = write(folder.path(), "model.toml", bad);
        let out = folder.path().join("out").display().to_string();
        for command in [
            &["generate", "--lang", "c", "--scalar", "f32", "--out", &out][..],
            &["generate", "--out", &out],
            &["predict", "--data", &log],
            &["simulate", "--poses", "3", "--out", &out],
        ] {
            let with = ["--model", model.as_str()];
            let output = soon(&[&command[..1], &robot, &with, &command[1..]].concat());
            refused(&output, &["model.toml"]);
        }
        assert!(!Path::new(&out).exists());
    }
}

#[test]
fn angles_beyond_all_turns_and_robots_of_no_weight_are_refused() {
    let folder = folder();
    let of = |rpy: &str, mass: &str, inertia: &str| {
        format!(
            "<robot name='r'><link name='foot'/><link name='a'><inertial><mass value='{mass}'/>\
             <inertia ixx='1' iyy='{inertia}' izz='1'/></inertial></link><joint name='j' type='revolute'><parent link='foot'/><child \
             link='a'/><origin rpy='{rpy} 0 0'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/>\
             </joint></robot>"
        )
    };
    for (urdf, word) in [
        (of("1e17", "1", "1"), "whole turns"),
        (of("0", "1e-310", "1"), "no mass"),
        (of("0", "1e308", "1"), "give it in kg"),
        (of("0", "1", "1e308"), "inertia iyy is 1e308 kg m²"),
        (of("0", "1", "-1e16"), "inertia iyy is -1e16 kg m²"),
    ] {
        let urdf = write(folder.path(), "r.urdf", urdf);
        for command in ["verify", "inspect"] {
            refused(&sesc(&[command, &urdf, "--support", "foot"]), &[word]);
        }
        let out = folder.path().join("out").display().to_string();
        refused(
            &sesc(&["generate", &urdf, "--support", "foot", "--out", &out]),
            &[word],
        );
    }
}
