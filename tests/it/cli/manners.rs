//! What people expect of a command line beside its results: likely mistakes are named, next
//! steps are said, shells and `man` know it.

use std::fs;

use sesc_test_support::command::{Folder, op2, refused, rows, says, sesc, stderr, stdout};

#[test]
fn other_units_are_refused_with_what_was_meant() {
    let folder = Folder::with_log("--poses 40 --noise 0.0005");
    let before = folder.files();
    folder.refuses_each(
        "simulate op2.urdf --support r_sole --poses 40 --out l.csv --noise 5
           | --noise | 0.005 for 5 mm
         simulate op2.urdf --support r_sole --poses 40 --out l.csv --noise 0.5 | 0.0005 for 0.5 mm
         simulate op2.urdf --support r_sole --poses 40 --out l.csv --range 3000
           | --range | 171.8873 for 3000 mrad
         simulate op2.urdf --support r_sole --poses 4 --out l.csv --rate 1000000
           | --rate | 1000 for a row every 1000000 ns
         simulate op2.urdf --support r_sole --poses 40 --out l.csv --motion off
           | --motion | --rate HZ
         plan op2.urdf --support r_sole --poses 3 --out l.csv --cop-box 23
           | --cop-box | 0.023 for 23 mm
         plan op2.urdf --support r_sole --poses 3 --out l.csv --cop-box 9
           | --cop-box | 0.009 for 9 mm
         plan op2.urdf --support r_sole --poses 3 --out l.csv --margin 2 | --margin | 0.002 for 2 mm
         fit op2.urdf --data log.csv --noise 2 | --noise | 0.002 for 2 mm
         diagnose op2.urdf --data log.csv --noise 2 | --noise | 0.002 for 2 mm
         diagnose op2.urdf --data log.csv --floor 2 | --floor | 0.002 for 2 mm
         fit op2.urdf --data log.csv --urdf c.urdf --total-mass 2930
           | --total-mass | 2.93 for 2930 g
         diagnose op2.urdf --data log.csv --urdf c.urdf --total-mass 2930 | 2.93 for 2930 g",
    );
    assert!(folder.files() == before);
}

#[test]
fn names_of_links_effects_and_targets_are_guessed() {
    let folder = Folder::with_log("--poses 40");
    let simulate = "simulate op2.urdf --support r_sole --poses 40 --out log.csv --hide";
    // 1.5 rad are 86° and 150 kg are fifty robots; whoever means them says so.
    for row in rows(
        "joint_ofset:r_knee=1deg | did you mean | `joint_offset`?
         joint_offset:r_knee=3mm | units deg | offset_rad
         joint_offset:r_kne=1deg | did you mean | `r_knee`?
         joint_offset:r_knee=1.5 | 1.5 rad (86°) | 1.5deg, or 1.5rad
         sensor_offset=3,0 | 3 m (3000 mm) | 3mm, or 3m
         payload:body_link=150,0,0,0 | 150 kg (the robot weighs 2.925 kg) | 150g, or 150kg",
    ) {
        folder.refuses_each(&format!("{simulate} {}", row.join(" | ")));
    }
    let meant = "payload:body_link=0.15,0,0,0 joint_offset:r_knee=1.5rad joint_offset:r_knee=0.02";
    for hidden in meant.split(' ') {
        folder.stdout(&format!("{simulate} {hidden}"));
    }
    folder.write("prior.toml", "[links.body_lnik]\nmass = 0.1\n");
    folder.write("servos.toml", "[joints.l_kne]\nzero = 2050\n");
    folder.refuses_each(
        "fit op2.urdf --data log.csv --prior prior.toml | did you mean `body_link`?
         fit op2.urdf --data log.csv --other-foot l_soel | did you mean `l_sole`?
         diagnose op2.urdf --data log.csv --servos servos.toml | did you mean `l_knee`?",
    );
    // A misspelt key of the sidecar is not lost behind what is missing without it.
    folder.write("log.csv.toml", "suport = \"r_sole\"\n");
    folder.refuses_each(
        "fit op2.urdf --data log.csv | no support link | did you mean `support`?
         diagnose op2.urdf --data log.csv | no support link | did you mean `support`?
         predict op2.urdf --data log.csv | no support link | did you mean `support`?",
    );
}

/// An option that is not there is no file behind `--`; a log's name tells its format.
#[test]
fn unknown_options_and_endings_have_no_remedy_that_is_none() {
    let folder = Folder::with("op2");
    folder.refuses_each(
        "compare a.toml b.toml --jsn | '--jsn' | --json
         simulate op2.urdf --fast | '--fast'
         simulate op2.urdf --support r_sole --poses 3 --out log.txt
           | log.txt | .csv, .csv.gz or .parquet",
    );
    let said = stderr(&folder.run("simulate op2.urdf --fast"));
    assert!(!said.contains("-- --fast"));
}

#[test]
fn a_fit_that_misses_something_points_to_diagnose() {
    let folder = Folder::with_log("--poses 60 --noise 0.0005");
    let plain = folder.stdout("fit op2.urdf --data log.csv");
    assert!(!plain.contains("sesc diagnose"), "{plain}");
    folder.simulate("--poses 60 --noise 0.0005 --hide joint_offset:r_knee=5deg --out log.csv");
    let bent = folder.stdout("fit op2.urdf --data log.csv");
    let command = "sesc diagnose op2.urdf --data log.csv\n";
    says(bent, &["next             Diagnose the log: ", command]);
}

#[test]
fn a_log_is_no_experiment_of_its_own() {
    let folder = Folder::with_log("--poses 40 --noise 0.0005");
    // The same rows, and with their columns in another order.
    let text = folder.read("log.csv");
    let turn = |line: &str| line.rsplit(',').collect::<Vec<_>>().join(",") + "\n";
    let turned = text.lines().map(turn).collect::<String>();
    for text in [text.clone(), turned] {
        folder.write("copy.csv", text);
        folder.write("copy.csv.toml", folder.read("log.csv.toml"));
        let line = "diagnose op2.urdf --data log.csv --then copy.csv";
        folder.refuses(line, &["copy.csv", "same rows", "would count twice"]);
    }
}

#[test]
fn other_formats_are_named_with_the_way_out() {
    let folder = Folder::empty();
    folder.write("robot.xml", "<mujoco model='x'><worldbody/></mujoco>");
    folder.write("robot.sdf", "<sdf version='1.6'><model name='x'/></sdf>");
    folder.refuses_each(
        "inspect robot.xml --support x | robot.xml | mjcf-urdf-simple-converter | URDF
         inspect robot.sdf --support x | robot.sdf | SDF | URDF",
    );
}

/// A stand-in for `xacro` that prints a robot shows that its output is what is read.
#[cfg(unix)]
#[test]
fn xacro_files_are_expanded_where_xacro_is_installed_and_the_user_asks() {
    use std::os::unix::fs::PermissionsExt as _;

    for (name, asks) in [
        ("robot.urdf.xacro", false),
        ("robot.urdf", true),
        ("-x.xacro", false),
    ] {
        let folder = Folder::empty();
        folder.write(
            name,
            "<robot xmlns:xacro='http://ros.org/wiki/xacro' name='${n}'><link name='${n}'/></robot>",
        );
        let run = |path: &str| {
            let mut command = folder.command("inspect --support r_sole");
            command.env("PATH", path).args(asks.then_some("--xacro"));
            command.args(["--", name]).output().unwrap()
        };
        let missing = match asks {
            true => "`xacro` is not installed",
            false => "unexpanded xacro",
        };
        refused(&run("/nowhere"), &[name, missing]);
        let folders = format!("{}:/usr/bin:/bin", folder.path().display());
        let script = |text: String| {
            let xacro = folder.write("xacro", text);
            fs::set_permissions(xacro, fs::Permissions::from_mode(0o755)).unwrap();
        };
        let is_file = "[ $# = 1 ] && [ -f \"$1\" ] && [ \"${1#-}\" = \"$1\" ] || exit 3";
        script(format!("#!/bin/sh\n{is_file}\ncat '{}'\n", op2()));
        let output = run(&folders);
        assert!(stdout(&output).contains("op2"));
        let note = format!("note: {name} was expanded by xacro, which ran code of that file");
        says(stderr(&output), &[&note]);
        script("#!/bin/sh\necho 'XacroException: no such macro' >&2\nexit 2\n".into());
        refused(&run(&folders), &[name, "XacroException: no such macro"]);
    }
}

#[test]
fn shells_and_man_know_every_command() {
    let page = stdout(&sesc(&["man"]));
    let script = stdout(&sesc(&["completions", "bash"]));
    for command in "inspect generate fit diagnose compare fleet demo".split(' ') {
        says(&page, &[".TH", &format!("sesc\\-{command}")]);
        says(&script, &[command]);
    }
    says(
        stdout(&sesc(&["man", "fit"])),
        &["sesc\\-fit", "\\-\\-data"],
    );
    refused(&sesc(&["man", "fot"]), &["`fot`", "fit"]);
}

#[test]
fn verdicts_stand_out_where_asked_programs_read_plain_text_and_quiet_ones_say_faults_alone() {
    let folder = Folder::with("op2");
    let inspect = |more: &str| folder.run(&format!("inspect op2.urdf {more}"));
    let plain = stdout(&inspect("--support r_sole"));
    assert!(!plain.contains('\x1b'));
    let painted = stdout(&inspect("--support r_sole --color always"));
    assert!(painted.starts_with("\x1b[1mop2 on r_sole: "));
    assert_eq!(painted.replace("\x1b[1m", "").replace("\x1b[0m", ""), plain);
    for (option, from) in [("--color auto --json", "{"), ("--color=never", "op2")] {
        let text = stdout(&inspect(&format!("--support r_sole {option}")));
        assert!(text.starts_with(from) && !text.contains('\x1b'));
    }
    let wrong = stderr(&inspect("--support nowhere --color always"));
    assert!(wrong.starts_with("\x1b[1;31merror:\x1b[0m "));
    // Quiet commands say warnings and errors alone.
    let simulate = "simulate op2.urdf --support r_sole --poses 3 --out log.csv";
    assert!(!folder.run(simulate).stderr.is_empty());
    let quiet = folder.run(&format!("{simulate} --quiet"));
    assert!(quiet.status.success() && quiet.stderr.is_empty());
    refused(&inspect("--support nowhere --quiet"), &["nowhere"]);
}

#[test]
fn tables_of_a_robot_fit_a_wide_terminal_and_long_ones_are_asked_for() {
    let folder = Folder::with("op2");
    let text = folder.stdout("inspect op2.urdf --support r_sole");
    for line in text.lines().filter(|line| !line.contains(" sesc plan ")) {
        assert!(line.chars().count() <= 120, "{line}");
    }
    // Twenty joints hide the same.
    assert_eq!(text.matches("moves to its parent").count(), 0);
    says(
        &text,
        &["along the axis of each of 20 joints", "Ry(-r_knee)"],
    );
    let long = folder.stdout("inspect op2.urdf --support r_sole --long");
    assert_eq!(long.matches("moves to its parent").count(), 20);
    says(long, &["Rx(-r_ank_roll) Ry(r_ank_pitch) Ry(-r_knee)"]);
    // One rounding, up, as in the headers of generated files.
    folder.stdout("generate op2.urdf --support r_sole --lang c --name op2 --out .");
    let snap = |text: &str| {
        let (_, rest) = text.split_once("by at most ").unwrap();
        rest.split(' ').next().unwrap().to_string()
    };
    assert_eq!(snap(&text), snap(&folder.read("op2.h")));
}
