//! Model files: whose parameters they are, and what they spare the user to say.

use std::fs;

use serde_json::Value;

use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc, stdout, write};

fn urdf() -> String {
    format!("{ROOT}/robots/two_link/two_link.urdf")
}

/// Two links on `foot`, all of it moved 0.5 m along x.
fn shifted() -> String {
    let inspect = sesc(&["inspect", &urdf(), "--support", "foot", "--json"]);
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
    model
}

/// A model file moves predictions, and belongs to its robot and support.
#[test]
fn model_files_are_read_checked_and_baked_in() {
    let folder = folder();
    let (urdf, model) = (urdf(), shifted());
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
    stdout(&sesc(&in_words(
        "generate @ --support foot --model @ --name m --out @",
        &[&urdf, &good, &out],
    )));
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
    let wrong = write(
        folder.path(),
        "wrong.toml",
        format!("{model}[information]\nfactor = [[1.0]]\n"),
    );
    refused(
        &sesc(&[&base[..], &["--model", &wrong]].concat()),
        &["wrong.toml", "information.factor needs", "fit again"],
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

/// The support comes from the flag, then from the log, then from the model file.
#[test]
fn a_model_file_says_what_stands_on_the_ground() {
    let folder = folder();
    let model = write(folder.path(), "model.toml", shifted());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (urdf, log, poses) = (urdf(), at("log.csv"), at("poses.csv"));
    let commands: [&[&str]; 4] = [
        &["generate", "--name", "m", "--out", &at("src")],
        &["simulate", "--poses", "5", "--out", &log],
        &[
            "plan",
            "--poses",
            "2",
            "--cop-box",
            "1",
            "--sigmas",
            "0",
            "--out",
            &poses,
        ],
        &[
            "predict",
            "--data",
            &write(folder.path(), "bare.csv", "pose,ankle,knee\n1,0,0\n"),
        ],
    ];
    for command in commands {
        let (name, rest) = command.split_first().unwrap();
        let given = |more: &[&str]| sesc(&[&[*name, &urdf][..], rest, more].concat());
        stdout(&given(&["--model", &model]));
        refused(&given(&[]), &["no support link", "--support"]);
        let other = given(&["--model", &model, "--support", "shank"]);
        refused(&other, &["model.toml", "`foot`", "`shank`"]);
    }
    for (file, text) in [
        ("src/m.rs", "support frame  foot"),
        ("log.csv.toml", "\"foot\""),
        ("poses.csv.toml", "\"foot\""),
    ] {
        assert!(
            fs::read_to_string(at(file)).unwrap().contains(text),
            "{file}"
        );
    }
    // What the log says counts more than the model file: they must agree.
    write(folder.path(), "bare.toml", "support = \"shank\"\n");
    let bare = at("bare.csv");
    refused(
        &sesc(&["predict", &urdf, "--model", &model, "--data", &bare]),
        &["model.toml", "`foot`", "`shank`"],
    );
    refused(
        &sesc(&in_words(
            "simulate @ --poses 5 --model @ --out @",
            &[&op2(), &model, &log],
        )),
        &["model.toml", "hash"],
    );
}
