//! The command line as its users meet it: contracts of the JSON, exit codes,
//! bad input, files that appear whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn sesc(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sesc"))
        .args(arguments)
        .output()
        .unwrap()
}

fn op2() -> String {
    format!("{ROOT}/robots/op2/op2.urdf")
}

fn stdout(output: &Output) -> String {
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Exit code 2, nothing on stdout, and every one of `words` in the message.
fn refused(output: &Output, words: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        output.stdout.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn write(folder: &Path, name: &str, text: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn inspect_reports_what_the_contract_says() {
    let output = sesc(&["inspect", &op2(), "--support", "r_sole", "--json"]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["dof"], 20);
    assert_eq!(json["bodies"], 21);
    assert_eq!(json["full_params"], 63);
    assert_eq!(json["base_params"], 43);
    assert_eq!(json["rank"], serde_json::json!({"xyz": 43, "cop": 42}));
    assert_eq!(json["joints"].as_array().unwrap().len(), 20);
    assert_eq!(json["operations"]["com"]["mul"], 80);
    assert_eq!(json["operations"]["com"]["sin_cos"], 20);
    assert!(json["rounding_bound"]["com"]["f32"].as_f64().unwrap() < 3e-6);
    let unobservable = json["unobservable"].as_array().unwrap();
    assert!(unobservable.iter().any(|u| {
        u["sentence"]
            .as_str()
            .unwrap()
            .contains("along the axis of `l_knee` moves to its parent")
    }));
    // The elbows are written as 1.57079633.
    assert_eq!(json["snaps"].as_array().unwrap().len(), 2);
    let literal = sesc(&[
        "inspect",
        &op2(),
        "--support",
        "r_sole",
        "--json",
        "--no-snap",
    ]);
    let json: Value = serde_json::from_str(&stdout(&literal)).unwrap();
    assert_eq!(json["snaps"], serde_json::json!([]));
}

#[test]
fn verify_reports_errors_and_bounds() {
    let output = sesc(&[
        "verify",
        &op2(),
        "--support",
        "l_sole",
        "--samples",
        "200",
        "--json",
    ]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["pass"], true);
    assert!(json["samples"].as_u64().unwrap() >= 200);
    for function in [
        "com",
        "com_jacobian",
        "gravity_moments",
        "regressor",
        "regressor_cop",
        "cop",
    ] {
        let error = json["worst_error"][function].as_f64().unwrap();
        assert!(
            error <= json["bound"][function].as_f64().unwrap(),
            "{function}"
        );
    }
}

#[test]
fn generate_writes_once_and_leaves_the_same_bytes_alone() {
    let folder = folder();
    let out = folder.path().join("new/src").display().to_string();
    let run = || {
        sesc(&[
            "generate",
            &op2(),
            "--support",
            "r_sole",
            "--name",
            "op2_r_sole",
            "--out",
            &out,
        ])
    };
    let path = PathBuf::from(stdout(&run()).trim());
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        fs::read_to_string(format!("{ROOT}/generated/src/op2_r_sole.rs")).unwrap()
    );
    let before = fs::metadata(&path).unwrap().modified().unwrap();
    stdout(&run());
    assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), before);
    assert_eq!(
        fs::read_dir(path.parent().unwrap()).unwrap().count(),
        1,
        "no leftovers"
    );
}

/// simulate → predict: a noise-free log is what predict says, to the last digit.
#[test]
fn predict_reads_back_what_simulate_wrote() {
    let folder = folder();
    let log = folder.path().join("log.csv").display().to_string();
    let simulate = [
        "simulate",
        &op2(),
        "--support",
        "r_sole",
        "--poses",
        "50",
        "--range",
        "30",
        "--out",
        &log,
    ];
    stdout(&sesc(&simulate));
    let first = fs::read_to_string(&log).unwrap();
    stdout(&sesc(&simulate));
    assert_eq!(
        first,
        fs::read_to_string(&log).unwrap(),
        "same seed, same log"
    );
    // The support comes from the sidecar.
    let predicted = stdout(&sesc(&["predict", &op2(), "--data", &log]));
    assert_eq!(
        predicted.lines().next(),
        Some("pose,com_x,com_y,com_z,cop_x,cop_y")
    );
    for (row, line) in predicted.lines().skip(1).zip(first.lines().skip(1)) {
        let predicted: Vec<&str> = row.split(',').collect();
        let logged: Vec<&str> = line.split(',').collect();
        assert_eq!(predicted[4..], logged[21..], "pose {}", predicted[0]);
        assert_eq!(
            predicted[1..3],
            predicted[4..],
            "level ground: CoP is below the CoM"
        );
    }
    assert_eq!(predicted.lines().count(), 51);
}

#[test]
fn predict_follows_gravity_supports_and_degrees() {
    let folder = folder();
    let urdf = write(
        folder.path(),
        "pole.urdf",
        "<robot name='pole'><link name='foot'/><link name='top'><inertial><mass value='2'/></inertial></link>\
         <joint name='hip' type='revolute'><parent link='foot'/><child link='top'/>\
         <origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint></robot>",
    );
    let log = write(
        folder.path(),
        "a.csv",
        "hip,pose,support\n90,7,foot\n0,9,top\n",
    );
    // Gravity leans 0.1 to the front: the CoP runs ahead by 0.1 m per metre of height.
    write(
        folder.path(),
        "a.toml",
        "gravity = [0.980665, 0.0, -9.80665]\n",
    );
    let predicted = stdout(&sesc(&["predict", &urdf, "--data", &log, "--degrees"]));
    assert_eq!(predicted.lines().nth(1), Some("7,0,0,1,0.1,0"));
    assert_eq!(predicted.lines().nth(2), Some("9,0,0,0,0,0"));
    refused(
        &sesc(&["predict", &urdf, "--data", &log]),
        &["a.csv:2", "`hip`", "--degrees"],
    );
}

#[test]
fn bad_logs_are_refused_by_line_and_column() {
    let folder = folder();
    let joints = "head_pan,head_tilt,l_hip_yaw,l_hip_roll,l_hip_pitch,l_knee,l_ank_pitch,l_ank_roll,\
                  l_sho_pitch,l_sho_roll,l_el,r_hip_yaw,r_hip_roll,r_hip_pitch,r_knee,r_ank_pitch,\
                  r_ank_roll,r_sho_pitch,r_sho_roll,r_el";
    let zeros = ",0".repeat(20);
    let cases: [(&str, String, &[&str]); 9] = [
        (
            "nan",
            format!(
                "pose,{joints}\n1{zeros}\n2{}\n",
                zeros.replacen("0", "NaN", 1)
            ),
            &["nan.csv:3", "head_pan"],
        ),
        (
            "word",
            format!("pose,{joints}\n1{}\n", zeros.replacen("0", "x", 1)),
            &["word.csv:2", "head_pan", "`x`"],
        ),
        (
            "ragged",
            format!("pose,{joints}\n1{zeros}\n2,0,0\n"),
            &["ragged.csv:3", "3 fields", "21"],
        ),
        (
            "twice",
            format!("pose,head_pan,{joints}\n"),
            &["twice.csv:1", "head_pan", "twice"],
        ),
        (
            "missing",
            "pose,head_pan\n1,0\n".into(),
            &["missing.csv:1", "`l_knee`", "and 7 more"],
        ),
        ("empty", String::new(), &["empty.csv", "header"]),
        (
            "rowless",
            format!("pose,{joints}\n"),
            &["rowless.csv", "no postures"],
        ),
        (
            "poses",
            format!("pose,{joints}\n1.5{zeros}\n"),
            &["poses.csv:2", "whole number"],
        ),
        (
            "degrees",
            format!("pose,{joints}\n1{}\n", zeros.replacen("0", "45", 1)),
            &["degrees.csv:2", "--degrees"],
        ),
    ];
    for (name, text, words) in cases {
        let log = write(folder.path(), &format!("{name}.csv"), text);
        refused(
            &sesc(&["predict", &op2(), "--support", "r_sole", "--data", &log]),
            words,
        );
    }
    let binary = write(
        folder.path(),
        "binary.csv",
        [0u8, 159, 146, 150, 255, 10, 3, 200],
    );
    refused(
        &sesc(&["predict", &op2(), "--support", "r_sole", "--data", &binary]),
        &["binary.csv"],
    );
    refused(
        &sesc(&[
            "predict",
            &op2(),
            "--support",
            "r_sole",
            "--data",
            "gone.csv",
        ]),
        &["gone.csv"],
    );
    let log = write(
        folder.path(),
        "side.csv",
        format!("pose,{joints}\n1{zeros}\n"),
    );
    write(folder.path(), "side.toml", "suport = 'r_sole'\n");
    refused(
        &sesc(&["predict", &op2(), "--data", &log]),
        &["side.toml", "suport"],
    );
}

#[test]
fn bad_robots_and_usage_exit_with_two_and_write_nothing() {
    let folder = folder();
    let out = folder.path().join("out").display().to_string();
    let bad = format!("{ROOT}/tests/bad_urdf/everything_at_once.urdf");
    let generate = |urdf: &str, support: &str, name: &str| {
        sesc(&[
            "generate",
            urdf,
            "--support",
            support,
            "--name",
            name,
            "--out",
            &out,
        ])
    };
    refused(
        &generate(&bad, "base", "x"),
        &["everything_at_once.urdf:14", "axis is zero"],
    );
    refused(
        &generate(&op2(), "sole", "x"),
        &["no link `sole`", "has l_sole, r_sole, body_link"],
    );
    refused(
        &generate(&op2(), "r_sole", "2fast"),
        &["`2fast`", "`robot_2fast`"],
    );
    refused(&generate(&op2(), "r_sole", "fn"), &["`fn`"]);
    refused(&sesc(&["inspect", &op2()]), &["--support"]);
    refused(
        &sesc(&["inspect", "nowhere.urdf", "--support", "x"]),
        &["nowhere.urdf"],
    );
    refused(
        &sesc(&["verify", &op2(), "--support", "r_sole", "--samples", "0"]),
        &["--samples"],
    );
    refused(
        &sesc(&[
            "generate",
            &op2(),
            "--support",
            "r_sole",
            "--lang",
            "ada",
            "--out",
            &out,
        ]),
        &["ada", "rust"],
    );
    let log = folder.path().join("log.csv");
    for (flag, value) in [
        ("--noise", "nan"),
        ("--noise", "-1"),
        ("--range", "0"),
        ("--poses", "0"),
    ] {
        let mut arguments = vec!["simulate".to_string(), op2(), "--support=r_sole".into()];
        if flag != "--poses" {
            arguments.push("--poses=5".into());
        }
        arguments.extend([
            format!("{flag}={value}"),
            format!("--out={}", log.display()),
        ]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        refused(&sesc(&arguments), &[flag]);
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing was written"
    );
}

/// A model file moves predictions, and belongs to its robot and support.
#[test]
fn model_files_are_read_checked_and_baked_in() {
    let folder = folder();
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    let inspect = sesc(&["inspect", &urdf, "--support", "foot", "--json"]);
    let json: Value = serde_json::from_str(&stdout(&inspect)).unwrap();
    let mut model = format!(
        "robot = \"two_link\"\nhash = {}\nsupport = \"foot\"\n",
        json["hash"]
    );
    for parameter in json["parameters"].as_array().unwrap() {
        let shift = if parameter["name"] == "foot.x" {
            0.5
        } else {
            0.0
        };
        let value = parameter["cad"].as_f64().unwrap() + shift;
        model += &format!(
            "[[parameters]]\nname = {}\nvalue = {value:?}\n",
            parameter["name"]
        );
    }
    let good = write(folder.path(), "model.toml", &model);
    let log = write(folder.path(), "q.csv", "pose,ankle,knee\n1,0,0\n");
    let com_x = |arguments: &[&str]| -> f64 {
        let text = stdout(&sesc(arguments));
        text.lines()
            .nth(1)
            .unwrap()
            .split(',')
            .nth(1)
            .unwrap()
            .parse()
            .unwrap()
    };
    let base = ["predict", &urdf, "--support", "foot", "--data", &log];
    let cad = com_x(&base);
    let identified = com_x(&[&base[..], &["--model", &good]].concat());
    assert!((identified - cad - 0.5).abs() < 1e-15);
    let out = folder.path().display().to_string();
    stdout(&sesc(&[
        "generate",
        &urdf,
        "--support",
        "foot",
        "--model",
        &good,
        "--name",
        "m",
        "--out",
        &out,
    ]));
    assert!(
        fs::read_to_string(folder.path().join("m.rs"))
            .unwrap()
            .contains("MODEL_PARAMS")
    );

    let other = write(
        folder.path(),
        "other.toml",
        model.replace("hash = \"", "hash = \"0"),
    );
    refused(
        &sesc(&[&base[..], &["--model", &other]].concat()),
        &["other.toml", "hash"],
    );
    let short = write(
        folder.path(),
        "short.toml",
        model.rsplit_once("[[").unwrap().0,
    );
    refused(
        &sesc(&[&base[..], &["--model", &short]].concat()),
        &["short.toml", "parameters"],
    );
    let odd = write(
        folder.path(),
        "odd.toml",
        format!("{model}[[effects]]\neffect = \"warp\"\n"),
    );
    refused(
        &sesc(&[&base[..], &["--model", &odd]].concat()),
        &["odd.toml", "warp"],
    );
}

#[test]
fn every_command_helps_with_an_example() {
    for command in [
        "inspect", "generate", "verify", "simulate", "predict", "demo",
    ] {
        let text = stdout(&sesc(&[command, "--help"]));
        assert!(
            text.contains(&format!("Example:\n  sesc {command}")),
            "{text}"
        );
    }
}

#[test]
fn the_demo_finds_what_the_paper_and_theory_say() {
    let folder = folder();
    let page = folder.path().join("demo.html").display().to_string();
    let text = stdout(&sesc(&["demo", "--out", &page]));
    let number = |line: &str| -> f64 {
        let line = text
            .lines()
            .find(|l| l.contains(line))
            .unwrap_or_else(|| panic!("{text}"));
        line.split_whitespace()
            .find_map(|word| word.parse().ok())
            .unwrap()
    };
    assert!(
        (3.9..=4.02).contains(&number("against noisy readings")),
        "{text}"
    );
    assert!(
        (0.6..=0.85).contains(&number("against the true CoP")),
        "{text}"
    );
    let html = fs::read_to_string(&page).unwrap();
    assert!(
        html.contains("<svg") && !html.contains("src=\"http"),
        "self-contained"
    );
}
