//! `sesc.toml` beside a URDF: options that need not be typed again.

use std::fs;
use std::path::Path;

use sesc_test_support::command::{folder, in_words, op2, refused, sesc, stdout, write};

/// The OP2 in a folder with this `sesc.toml`; the URDF's path.
fn robot(folder: &Path, defaults: &str) -> String {
    write(folder, "sesc.toml", defaults);
    write(folder, "op2.urdf", fs::read(op2()).unwrap())
}

#[test]
fn options_of_the_robot_need_not_be_typed() {
    let folder = folder();
    let urdf = robot(folder.path(), "support = \"r_sole\"\nno_snap = true\n");
    let typed = sesc(&["inspect", &op2(), "--support", "r_sole", "--no-snap"]);
    let short = sesc(&["inspect", &urdf]);
    // Steps to take next have the path that was typed.
    let found = |text: String| text.split("\nnext ").next().unwrap().to_string();
    assert_eq!(found(stdout(&short)), found(stdout(&typed)));
    let note = String::from_utf8_lossy(&short.stderr).into_owned();
    assert!(
        note.contains("sesc.toml gives --support=r_sole --no-snap"),
        "{note}"
    );

    // What is typed wins, and is not in the note.
    let left = sesc(&["inspect", &urdf, "--support", "l_sole"]);
    assert!(stdout(&left).starts_with("op2 on l_sole"));
    assert!(!String::from_utf8_lossy(&left.stderr).contains("r_sole"));
}

#[test]
fn a_log_that_names_its_support_link_wins() {
    let folder = folder();
    let urdf = robot(folder.path(), "support = \"r_sole\"\nprior = \"tight\"\n");
    let log = |support: &str| {
        let log = folder
            .path()
            .join(format!("{support}.csv"))
            .display()
            .to_string();
        let simulate = ["simulate", &urdf, "--support", support, "--poses", "30"];
        stdout(&sesc(
            &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
        ));
        log
    };
    assert!(stdout(&sesc(&["fit", &urdf, "--data", &log("l_sole")])).starts_with("op2 on l_sole"));

    let bare = log("r_sole");
    fs::remove_file(format!("{bare}.toml")).unwrap();
    let found = sesc(&["fit", &urdf, "--data", &bare]);
    assert!(stdout(&found).starts_with("op2 on r_sole"));
    let note = String::from_utf8_lossy(&found.stderr).into_owned();
    assert!(
        note.contains("gives --support=r_sole --prior=tight"),
        "{note}"
    );
}

#[test]
fn paths_are_relative_to_the_file() {
    let folder = folder();
    let urdf = robot(
        folder.path(),
        "support = \"r_sole\"\nlimits = \"limits.csv\"\n",
    );
    let out = folder.path().join("poses.csv").display().to_string();
    let plan = ["plan", &urdf, "--poses", "3", "--out", &out];
    refused(&sesc(&plan), &["limits.csv"]);
    write(
        folder.path(),
        "limits.csv",
        "joint,lower_rad,upper_rad\nhead_pan,-0.1,0.1\n",
    );
    stdout(&sesc(&plan));
}

#[test]
fn what_is_wrong_with_the_file_is_said_with_its_name() {
    let folder = folder();
    for (text, words) in [
        (
            "suport = \"r_sole\"\n",
            ["did you mean `support`?", "sesc.toml"],
        ),
        (
            "support = 3\n",
            ["`support`: give a text in quotes", "sesc.toml"],
        ),
        (
            "noise = \"small\"\n",
            ["`noise`: give a number", "sesc.toml"],
        ),
        (
            "degrees = 1\n",
            ["`degrees`: give true or false", "sesc.toml"],
        ),
        ("support = \n", ["line 1", "sesc.toml"]),
    ] {
        let urdf = robot(folder.path(), text);
        refused(&sesc(&["inspect", &urdf, "--json"]), &words);
    }
}

/// A value that the file gives is not blamed on an option that nobody typed.
#[test]
fn a_bad_value_is_blamed_on_the_file_and_its_line() {
    let folder = folder();
    let out = folder.path().join("poses.csv").display().to_string();
    for (text, command, words) in [
        (
            "support = \"r_sole\"\n\nnoise = 5\n",
            "plan",
            ["sesc.toml:3: `noise`", "0.005 for 5 mm"],
        ),
        (
            "support = \"r_sole\"\n motion = \"slow\"\n",
            "fit",
            ["sesc.toml:2: `motion`", "auto, off"],
        ),
        (
            "support = \"r_sole\"\nnoise = -0.001\n",
            "plan",
            ["sesc.toml:2: `noise`", "above zero"],
        ),
    ] {
        let urdf = robot(folder.path(), text);
        let plan = ["plan", &urdf, "--poses", "3", "--out", &out];
        let output = match command {
            "plan" => sesc(&plan),
            _ => sesc(&["fit", &urdf, "--data", "log.csv"]),
        };
        refused(&output, &words);
    }
    // What is typed is blamed on what is typed.
    let urdf = robot(folder.path(), "support = \"r_sole\"\nnoise = 0.001\n");
    let plan = ["plan", &urdf, "--poses", "3", "--out", &out];
    let output = sesc(&[&plan[..], &["--noise", "5"]].concat());
    refused(&output, &["--noise", "0.005 for 5 mm"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("sesc.toml:"));
}

/// An option that is typed wins over one of the file that it does not go with.
#[test]
fn options_of_the_file_give_way_to_those_that_contradict_them() {
    let folder = folder();
    let urdf = robot(folder.path(), "support = \"r_sole\"\ncop_box = 0.02\n");
    let out = folder.path().join("poses.csv").display().to_string();
    let plan = in_words("plan @ --poses 3 --candidates 50 --out @", &[&urdf, &out]);
    let sole = ["--sole", "0.03,0.02;-0.03,0.02;-0.03,-0.02;0.03,-0.02"];
    let said = stdout(&sesc(&[&plan[..], &sole].concat()));
    assert!(said.contains("a sole of 4 corners"), "{said}");
}
