//! What `sesc diagnose` refuses, and how: exit code 2, what is wrong and what to do,
//! nothing written. What is only odd is diagnosed.

use std::fmt::Write as _;
use std::process::Output;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_reference::{Robot, World};
use sesc_test_support::command::{Folder, refused, stdout};

/// Two skewed joints on a foot.
const SKEW: &str = "<robot name='skew'>\
    <link name='foot'><inertial><origin xyz='0.01 0.02 0.05'/><mass value='2'/></inertial></link>\
    <joint name='hip' type='revolute'><parent link='foot'/><child link='thigh'/>\
    <origin xyz='0 0 0.1'/><axis xyz='0.3 0.8 0.2'/><limit lower='-0.6' upper='0.6'/></joint>\
    <link name='thigh'><inertial><origin xyz='0.05 0.1 0.2'/><mass value='3'/></inertial></link>\
    <joint name='knee' type='revolute'><parent link='thigh'/><child link='shank'/>\
    <origin xyz='0.02 0.01 0.4'/><axis xyz='0.9 -0.2 0.3'/><limit lower='-1' upper='1'/></joint>\
    <link name='shank'><inertial><origin xyz='0.1 -0.05 0.3'/><mass value='4'/></inertial></link>\
    </robot>";
const HEADER: &str = "pose,hip,knee,cop_x,cop_y,cop_x_std,cop_y_std";
/// Standard deviation of a reading, m.
const NOISE: f64 = 1e-3;
/// Every output that there is.
const OUTPUTS: [(&str, &str); 4] = [
    ("--out", "model.toml"),
    ("--urdf", "corrected.urdf"),
    ("--next", "next.csv"),
    ("--report", "report.html"),
];

/// A log of this world, angles in units of `unit` rad.
fn log(world: &World, unit: f64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut text = format!("{HEADER}\n");
    for k in 0..60 {
        let q = [0.5 * (1.3 * k as f64).sin(), 0.9 * (2.1 * k as f64).cos()];
        let noise = |random: &mut ChaCha8Rng| -> f64 {
            let gauss: f64 = StandardNormal.sample(random);
            NOISE * gauss
        };
        let [x, y] = world.cop(&q).map(|x| x + noise(&mut random));
        let [hip, knee] = q.map(|q| q / unit);
        let _ = writeln!(text, "{k},{hip},{knee},{x},{y},{NOISE},{NOISE}");
    }
    text
}

fn world() -> World {
    World::new(&Robot::from_urdf(SKEW).unwrap(), "foot").unwrap()
}

/// A folder with the robot.
fn case() -> Folder {
    let folder = Folder::empty();
    folder.write("skew.urdf", SKEW);
    folder
}

/// A diagnosis with every output asked for, and masses that are known well.
fn run(case: &Folder, log: &str, more: &str) -> Output {
    let outputs = OUTPUTS
        .map(|(flag, name)| format!("{flag} {name} "))
        .concat();
    let prior = match more.contains("--prior") {
        true => "",
        false => "--prior tight",
    };
    let line = format!("diagnose skew.urdf --support foot --data {log} {outputs}");
    case.run(&format!("{line} {prior} {more}"))
}

/// Refused with these words, and none of the outputs is there, nor a part of one.
fn refuses(case: &Folder, log: &str, more: &str, words: &[&str]) {
    let before = case.names();
    refused(&run(case, log, more), words);
    assert_eq!(case.names(), before);
}

#[test]
fn logs_that_are_none_are_refused_by_place_and_remedy() {
    let case = case();
    let good = log(&world(), 1.0);
    let cut = &good[..good.len() - 40];
    let cases: [(&str, &[u8], &[&str]); 16] = [
        ("empty.csv", b"", &["empty.csv", "header"]),
        (
            "header.csv",
            HEADER.as_bytes(),
            &["header.csv", "no postures"],
        ),
        ("cut.csv", cut.as_bytes(), &["cut.csv:61", "fields", "7"]),
        (
            "binary.csv",
            &[0, 159, 146, 150, 255, 10, 3, 200],
            &["binary.csv"],
        ),
        (
            "inf.csv",
            b"pose,hip,knee,cop_x,cop_y\n1,0,0,0,0\n2,0,inf,0,0\n",
            &["inf.csv:3", "`knee`", "not finite", "mend"],
        ),
        (
            "word.csv",
            b"pose,hip,knee,cop_x,cop_y\n1,0,0,left,0\n",
            &["word.csv:2", "cop_x", "`left`"],
        ),
        (
            "unknown.csv",
            b"pose,hip,kne,cop_x,cop_y\n1,0,0,0,0\n",
            &["unknown.csv:1", "`knee`", "kne"],
        ),
        (
            "twice.csv",
            b"pose,hip,hip,knee,cop_x,cop_y\n",
            &["twice.csv:1", "`hip`", "twice"],
        ),
        (
            "poses.csv",
            b"pose,hip,knee,cop_x,cop_y\n1.5,0,0,0,0\n",
            &["poses.csv:2", "whole number"],
        ),
        (
            "jointless.csv",
            b"pose,cop_x,cop_y\n1,0,0\n",
            &["jointless.csv:1", "`hip`", "`knee`"],
        ),
        (
            "blind.csv",
            b"pose,hip,knee\n1,0,0\n",
            &["blind.csv:1", "cop_x", "fsr_1"],
        ),
        (
            "half.csv",
            b"pose,hip,knee,cop_x\n1,0,0,0\n",
            &["half.csv:1", "cop_y"],
        ),
        (
            "std.csv",
            b"pose,hip,knee,cop_x,cop_y,cop_x_std,cop_y_std\n1,0,0,0,0,0.001,-0.001\n",
            &["std.csv:2", "cop_y_std"],
        ),
        (
            "cells.csv",
            b"pose,hip,knee,fsr_1,fsr_2\n1,0,0,10,10\n",
            &["cells.csv", "cells", "sidecar"],
        ),
        (
            "foot.csv",
            b"pose,support,hip,knee,cop_x,cop_y\n1,hand,0,0,0,0\n",
            &["foot.csv:2", "`hand`"],
        ),
        (
            "elsewhere.csv",
            b"pose,support,hip,knee,cop_x,cop_y\n1,shank,0,0,0,0\n",
            &["elsewhere.csv", "no posture stands on `foot`", "--support"],
        ),
    ];
    for (name, text, words) in cases {
        case.write(name, text);
        refuses(&case, name, "", words);
    }
    refuses(&case, "gone.csv", "", &["gone.csv"]);
    refuses(&case, &case.at(""), "", &[]);
    case.write("side.csv", &good);
    case.write("side.toml", "readings_per_pose = 0\n");
    refuses(&case, "side.csv", "", &["side.toml", "readings_per_pose"]);
}

#[test]
fn usage_is_checked_before_anything_is_read_or_written() {
    let case = case();
    case.write("log.csv", log(&world(), 1.0));
    case.write("prior.toml", "[links.elbow]\nmass = 0.1\n");
    for (more, words) in [
        ("--noise -0.001", ["--noise", "metres"]),
        ("--noise 0", ["--noise", "metres"]),
        ("--noise nan", ["--noise", "metres"]),
        ("--noise 20", ["--noise", "metres"]),
        ("--floor -0.0001", ["--floor", "metres"]),
        ("--floor inf", ["--floor", "metres"]),
        ("--noise little", ["--noise", "little"]),
        ("--prior tigth", ["tigth", "tight, cad, free or a file"]),
        ("--prior prior.toml", ["prior.toml", "`elbow`"]),
    ] {
        refuses(&case, "log.csv", more, &words);
    }
    let before = case.names();
    case.refuses_each(
        "diagnose skew.urdf --data log.csv --support sole | `sole` | foot | thigh | shank
         diagnose skew.urdf --data log.csv | --support | foot, thigh, shank
         diagnose gone.urdf --data log.csv | gone.urdf
         diagnose skew.urdf --support foot --data log.csv --out a --report a | two outputs",
    );
    for (flag, name) in OUTPUTS {
        // A folder that is not there, one that is, and what is read.
        let plain = format!("diagnose skew.urdf --support foot --data log.csv {flag}");
        case.refuses(&format!("{plain} nowhere/{name}"), &[name]);
        case.refuses(&format!("{plain} {}", case.at("")), &["no regular file"]);
        case.refuses(&format!("{plain} log.csv"), &["is read here"]);
    }
    assert_eq!(case.names(), before);
}

fn json(output: &Output) -> serde_json::Value {
    serde_json::from_str(&stdout(output)).unwrap()
}

/// Angles in degrees are no fault of a log: with the flag nothing is missing, and
/// without it that is the finding.
#[test]
fn degrees_are_taken_with_the_flag_and_named_without() {
    let case = case();
    case.write("degrees.csv", log(&world(), 1f64.to_radians()));
    let with = json(&run(&case, "degrees.csv", "--degrees --json"));
    assert_eq!(with["verdict"], "none", "{}", with["sentence"]);
    let without = json(&run(&case, "degrees.csv", "--json"));
    let steps = without["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 1, "{}", without["sentence"]);
    assert_eq!(steps[0]["effect"], "units");
    assert_eq!(steps[0]["target"], "-");
    assert!(without["sentence"].as_str().unwrap().contains("degrees"));
}

/// Rows on two links are explained together: the readings of one are none of the other.
#[test]
fn rows_on_another_link_are_explained_with_the_first() {
    let case = case();
    let plain = log(&world(), 1.0);
    let both = plain.lines().enumerate().flat_map(|(k, line)| {
        let (pose, rest) = line.split_once(',').unwrap();
        let own = |link: &str| format!("{pose},{link},{rest}\n");
        match k {
            0 => vec![own("support")],
            // The same numbers mean something else on another link.
            _ => vec![own("foot"), format!("{},shank,{rest}\n", 1000 + k)],
        }
    });
    let both = both.collect::<String>();
    case.write("both.csv", &both);
    let found = json(&run(&case, "both.csv", "--json"));
    assert_eq!(found["verdict"], "unexplained", "{}", found["sentence"]);
    assert_eq!(found["support"], "foot");
    // A few such rows are left out, and said to be.
    let rows = both.lines().filter(|row| !row.contains(",shank,"));
    let rows: Vec<&str> = rows.collect();
    let (last, rows) = rows.split_last().unwrap();
    let rows = format!(
        "{}\n{}\n",
        rows.join("\n"),
        last.replace(",foot,", ",shank,")
    );
    case.write("few.csv", rows);
    let found = json(&run(&case, "few.csv", "--json"));
    assert_ne!(found["verdict"], "unexplained", "{}", found["sentence"]);
    let said = found["warnings"].to_string();
    assert!(said.contains("1 rows stand on `shank`"), "{said}");
}
