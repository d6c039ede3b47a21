//! What `sesc diagnose` refuses, and how: exit code 2, what is wrong and what to do,
//! nothing written. What is only odd is diagnosed.

use std::process::Output;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_reference::{Robot, World};
use sesc_test_support::command::{Folder, list, refused, rows, says, stdout};
use sesc_test_support::recording::normal;
use sesc_test_support::trees::Urdf;

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
    let row = |k: usize| {
        let q = [0.5 * (1.3 * k as f64).sin(), 0.9 * (2.1 * k as f64).cos()];
        let [x, y] = world.cop(&q).map(|x| x + NOISE * normal(&mut random));
        let [hip, knee] = q.map(|q| q / unit);
        format!("{k},{hip},{knee},{x},{y},{NOISE},{NOISE}\n")
    };
    format!("{HEADER}\n") + &(0..60).map(row).collect::<String>()
}

/// Two skewed joints on a foot.
fn skew() -> String {
    let robot = Urdf::new("skew").link("foot", 2.0, "0.01 0.02 0.05");
    let robot = robot.revolute("hip", ["foot", "thigh"], "0 0 0.1", "0.3 0.8 0.2", 0.6);
    let robot = robot.link("thigh", 3.0, "0.05 0.1 0.2");
    let knee = ["thigh", "shank"];
    let robot = robot.revolute("knee", knee, "0.02 0.01 0.4", "0.9 -0.2 0.3", 1.0);
    robot.link("shank", 4.0, "0.1 -0.05 0.3").text()
}

fn world() -> World {
    World::new(&Robot::from_urdf(&skew()).unwrap(), "foot").unwrap()
}

/// A folder with the robot.
fn case() -> Folder {
    let folder = Folder::empty();
    folder.write("skew.urdf", skew());
    folder
}

/// A diagnosis with every output asked for, and masses that are known well.
fn run(case: &Folder, log: &str, more: &str) -> Output {
    let outputs = OUTPUTS
        .map(|(flag, name)| format!("{flag} {name} "))
        .concat();
    let prior = ["--prior tight", ""][usize::from(more.contains("--prior"))];
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
    let [empty, cut]: [&[u8]; 2] = [b"", cut.as_bytes()];
    let binary: &[u8] = &[0, 159, 146, 150, 255, 10, 3, 200];
    let words = ["cut.csv:61", "fields", "7"];
    for (name, text, words) in [
        ("empty.csv", empty, &["empty.csv", "header"][..]),
        (
            "header.csv",
            HEADER.as_bytes(),
            &["header.csv", "no postures"],
        ),
        ("cut.csv", cut, &words),
        ("binary.csv", binary, &["binary.csv"]),
    ] {
        case.write(name, text);
        refuses(&case, name, "", words);
    }
    let lines = "hip,knee,cop_x,cop_y 1,0,0,0,0 2,0,inf,0,0 | log.csv:3 | `knee` | not finite | mend
        hip,knee,cop_x,cop_y 1,0,0,left,0 | log.csv:2 | cop_x | `left`
        hip,kne,cop_x,cop_y 1,0,0,0,0 | log.csv:1 | `knee` | kne
        hip,hip,knee,cop_x,cop_y | log.csv:1 | `hip` | twice
        hip,knee,cop_x,cop_y 1.5,0,0,0,0 | log.csv:2 | whole number
        cop_x,cop_y 1,0,0 | log.csv:1 | `hip` | `knee`
        hip,knee 1,0,0 | log.csv:1 | cop_x | fsr_1
        hip,knee,cop_x 1,0,0,0 | log.csv:1 | cop_y
        hip,knee,cop_x,cop_y,cop_x_std,cop_y_std 1,0,0,0,0,0.001,-0.001 | log.csv:2 | cop_y_std
        hip,knee,fsr_1,fsr_2 1,0,0,10,10 | log.csv | cells | sidecar
        support,hip,knee,cop_x,cop_y 1,hand,0,0,0,0 | log.csv:2 | `hand`
        support,hip,knee,cop_x,cop_y 1,shank,0,0,0,0 | log.csv | no posture stands on `foot` | --support";
    for row in rows(lines) {
        let cells: Vec<&str> = row.iter().map(String::as_str).collect();
        case.write("log.csv", format!("pose,{}\n", cells[0].replace(' ', "\n")));
        refuses(&case, "log.csv", "", &cells[1..]);
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
    let usage = "--noise -0.001 | --noise | metres
        --noise 0 | --noise | metres
        --noise nan | --noise | metres
        --noise 20 | --noise | metres
        --floor -0.0001 | --floor | metres
        --floor inf | --floor | metres
        --noise little | --noise | little
        --prior tigth | tigth | tight, cad, free or a file
        --prior prior.toml | prior.toml | `elbow`";
    for row in rows(usage) {
        let cells: Vec<&str> = row.iter().map(String::as_str).collect();
        refuses(&case, "log.csv", cells[0], &cells[1..]);
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

/// The answer of a diagnosis that goes on.
fn json(output: &Output) -> serde_json::Value {
    serde_json::from_str(&stdout(output)).unwrap()
}

/// Angles in degrees are no fault of a log: with the flag nothing is missing, and
/// without it that is the finding.
#[test]
fn degrees_are_taken_with_the_flag_and_named_without() {
    let case = case();
    case.write("degrees.csv", log(&world(), 1f64.to_radians()));
    let found = |log, more| json(&run(&case, log, &format!("{more} --json")));
    let with = found("degrees.csv", "--degrees");
    assert_eq!(with["verdict"], "none", "{}", with["sentence"]);
    let without = found("degrees.csv", "");
    let steps = list(&without, "/steps");
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
    let last = last.replace(",foot,", ",shank,");
    let rows = format!("{}\n{last}\n", rows.join("\n"));
    case.write("few.csv", rows);
    let found = json(&run(&case, "few.csv", "--json"));
    assert_ne!(found["verdict"], "unexplained", "{}", found["sentence"]);
    says(found["warnings"].to_string(), &["1 rows stand on `shank`"]);
}
