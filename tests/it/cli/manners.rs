//! What people expect of a command line beside its results: likely mistakes are named, next
//! steps are said, shells and `man` know it.

use std::fs;

use sesc_test_support::command::{folder, in_words, op2, program, refused, sesc, stdout};

#[test]
fn other_units_are_refused_with_what_was_meant() {
    let folder = folder();
    let out = folder.path().join("log.csv").display().to_string();
    let urdf = op2();
    let simulate = "simulate @ --support r_sole --poses 40 --out @";
    let plan = "plan @ --support r_sole --poses 3 --out @";
    let said =
        |line: &str, more: &[&str]| sesc(&[&in_words(line, &[&urdf, &out])[..], more].concat());
    for (line, option, value, meant) in [
        (simulate, "--noise", "5", "0.005 for 5 mm"),
        (simulate, "--noise", "0.5", "0.0005 for 0.5 mm"),
        (simulate, "--range", "3000", "171.8873 for 3000 mrad"),
        (
            simulate,
            "--rate",
            "1000000",
            "1000 for a row every 1000000 ns",
        ),
        (simulate, "--motion", "off", "--rate HZ"),
        (plan, "--cop-box", "23", "0.023 for 23 mm"),
        (plan, "--cop-box", "9", "0.009 for 9 mm"),
        (plan, "--margin", "2", "0.002 for 2 mm"),
    ] {
        refused(&said(line, &[option, value]), &[option, meant]);
        assert!(!folder.path().join("log.csv").exists());
    }
    stdout(&said(simulate, &["--noise", "0.0005"]));
    let corrected = folder.path().join("c.urdf").display().to_string();
    for (line, option) in [
        ("fit @ --data @", "--noise"),
        ("diagnose @ --data @", "--noise"),
        ("diagnose @ --data @", "--floor"),
    ] {
        refused(&said(line, &[option, "2"]), &[option, "0.002 for 2 mm"]);
        let heavy = ["--urdf", &corrected, "--total-mass", "2930"];
        refused(&said(line, &heavy), &["--total-mass", "2.93 for 2930 g"]);
    }
}

#[test]
fn names_of_links_effects_and_targets_are_guessed() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (urdf, log) = (op2(), at("log.csv"));
    let simulate = in_words(
        "simulate @ --support r_sole --poses 40 --out @",
        &[&urdf, &log],
    );
    let hidden = |what: &str| sesc(&[&simulate[..], &["--hide", what]].concat());
    refused(
        &hidden("joint_ofset:r_knee=1deg"),
        &["did you mean `joint_offset`?"],
    );
    refused(
        &hidden("joint_offset:r_knee=3mm"),
        &["units deg", "offset_rad"],
    );
    refused(
        &hidden("joint_offset:r_kne=1deg"),
        &["did you mean `r_knee`?"],
    );
    // 1.5 rad are 86°; whoever means them says so.
    refused(
        &hidden("joint_offset:r_knee=1.5"),
        &["1.5 rad (86°)", "1.5deg, or 1.5rad"],
    );
    refused(
        &hidden("sensor_offset=3,0"),
        &["3 m (3000 mm)", "3mm, or 3m"],
    );
    // 150 kg are fifty robots.
    refused(
        &hidden("payload:body_link=150,0,0,0"),
        &["150 kg (the robot weighs 2.925 kg)", "150g, or 150kg"],
    );
    stdout(&hidden("payload:body_link=0.15,0,0,0"));
    stdout(&hidden("joint_offset:r_knee=1.5rad"));
    stdout(&hidden("joint_offset:r_knee=0.02"));
    stdout(&sesc(&simulate));
    let fit = |more: &[&str]| sesc(&[&["fit", &urdf, "--data", &log][..], more].concat());
    let prior = at("prior.toml");
    fs::write(&prior, "[links.body_lnik]\nmass = 0.1\n").unwrap();
    refused(&fit(&["--prior", &prior]), &["did you mean `body_link`?"]);
    refused(
        &fit(&["--other-foot", "l_soel"]),
        &["did you mean `l_sole`?"],
    );
    let servos = at("servos.toml");
    fs::write(&servos, "[joints.l_kne]\nzero = 2050\n").unwrap();
    let diagnose = ["diagnose", &urdf, "--data", &log, "--servos", &servos];
    refused(&sesc(&diagnose), &["did you mean `l_knee`?"]);
    // A misspelt key of the sidecar is not lost behind what is missing without it.
    fs::write(format!("{log}.toml"), "suport = \"r_sole\"\n").unwrap();
    for command in ["fit", "diagnose", "predict"] {
        let output = sesc(&[command, &urdf, "--data", &log]);
        refused(&output, &["no support link", "did you mean `support`?"]);
    }
}

/// An option that is not there is no file behind `--`.
#[test]
fn unknown_options_have_no_remedy_that_is_none() {
    let output = sesc(&["compare", "a.toml", "b.toml", "--jsn"]);
    refused(&output, &["'--jsn'", "--json"]);
    let output = sesc(&["simulate", &op2(), "--fast"]);
    refused(&output, &["'--fast'"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("-- --fast"));
}

#[test]
fn posture_logs_have_known_endings() {
    let folder = folder();
    let out = folder.path().join("log.txt").display().to_string();
    let urdf = op2();
    let output = sesc(&in_words(
        "simulate @ --support r_sole --poses 3 --out @",
        &[&urdf, &out],
    ));
    refused(&output, &["log.txt", ".csv, .csv.gz or .parquet"]);
}

#[test]
fn a_fit_that_misses_something_points_to_diagnose() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let urdf = op2();
    let mut said = Vec::new();
    for (name, hidden) in [
        ("plain.csv", None),
        ("bent.csv", Some("joint_offset:r_knee=5deg")),
    ] {
        let log = path(name);
        let mut simulate = vec!["simulate", &urdf, "--support", "r_sole", "--poses", "60"];
        simulate.extend(["--noise", "0.0005", "--out", &log]);
        simulate.extend(hidden.iter().flat_map(|hidden| ["--hide", hidden]));
        stdout(&sesc(&simulate));
        said.push(stdout(&sesc(&["fit", &urdf, "--data", &log])));
    }
    assert!(!said[0].contains("sesc diagnose"), "{}", said[0]);
    assert!(
        said[1].contains("next             Diagnose the log: ")
            && said[1].contains(&format!(
                "sesc diagnose {urdf} --data {}\n",
                path("bent.csv")
            )),
        "{}",
        said[1]
    );
}

#[test]
fn a_log_is_no_experiment_of_its_own() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (urdf, log, copy) = (op2(), path("log.csv"), path("copy.csv"));
    let simulate = ["simulate", &urdf, "--support", "r_sole", "--poses", "40"];
    stdout(&sesc(
        &[&simulate[..], &["--noise", "0.0005", "--out", &log]].concat(),
    ));
    fs::copy(&log, &copy).unwrap();
    fs::copy(format!("{log}.toml"), format!("{copy}.toml")).unwrap();
    let output = sesc(&["diagnose", &urdf, "--data", &log, "--then", &copy]);
    refused(&output, &["copy.csv", "same rows", "would count twice"]);
    // The same rows with their columns in another order.
    let turned = path("turned.csv");
    let text = fs::read_to_string(&log).unwrap();
    let turn = |line: &str| line.rsplit(',').collect::<Vec<_>>().join(",") + "\n";
    fs::write(&turned, text.lines().map(turn).collect::<String>()).unwrap();
    fs::copy(format!("{log}.toml"), format!("{turned}.toml")).unwrap();
    let output = sesc(&["diagnose", &urdf, "--data", &log, "--then", &turned]);
    refused(&output, &["turned.csv", "same rows", "would count twice"]);
}

#[test]
fn other_formats_are_named_with_the_way_out() {
    let folder = folder();
    for (name, text, words) in [
        (
            "robot.xml",
            "<mujoco model='x'><worldbody/></mujoco>",
            "mjcf-urdf-simple-converter",
        ),
        (
            "robot.sdf",
            "<sdf version='1.6'><model name='x'/></sdf>",
            "SDF",
        ),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let path = path.display().to_string();
        refused(
            &sesc(&["inspect", &path, "--support", "x"]),
            &[name, words, "URDF"],
        );
    }
}

/// A stand-in for `xacro` that prints a robot shows that its output is what is read.
#[cfg(unix)]
#[test]
fn xacro_files_are_expanded_where_xacro_is_installed_and_the_user_asks() {
    for (name, asks) in [
        ("robot.urdf.xacro", false),
        ("robot.urdf", true),
        ("-x.xacro", false),
    ] {
        expanded(name, asks);
    }
}

#[cfg(unix)]
fn expanded(name: &str, asks: bool) {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = folder();
    let text =
        "<robot xmlns:xacro='http://ros.org/wiki/xacro' name='${n}'><link name='${n}'/></robot>";
    fs::write(folder.path().join(name), text).unwrap();
    let xacro = folder.path().join("xacro");
    let run = |path: &str| {
        let mut command = std::process::Command::new(program());
        command.env("PATH", path).current_dir(folder.path());
        command.args(["inspect", "--support", "r_sole"]);
        command.args(asks.then_some("--xacro"));
        command.args(["--", name]).output().unwrap()
    };
    match asks {
        true => refused(&run("/nowhere"), &[name, "`xacro` is not installed"]),
        false => refused(&run("/nowhere"), &[name, "unexpanded xacro"]),
    }
    let folders = format!("{}:/usr/bin:/bin", folder.path().display());
    let script = |text: String| {
        fs::write(&xacro, text).unwrap();
        fs::set_permissions(&xacro, fs::Permissions::from_mode(0o755)).unwrap();
    };
    let is_file = "[ $# = 1 ] && [ -f \"$1\" ] && [ \"${1#-}\" = \"$1\" ] || exit 3";
    script(format!("#!/bin/sh\n{is_file}\ncat '{}'\n", op2()));
    let output = run(&folders);
    assert!(stdout(&output).contains("op2"));
    let said = String::from_utf8_lossy(&output.stderr);
    let note = format!("note: {name} was expanded by xacro, which ran code of that file");
    assert!(said.contains(&note), "{said}");
    script("#!/bin/sh\necho 'XacroException: no such macro' >&2\nexit 2\n".into());
    refused(&run(&folders), &[name, "XacroException: no such macro"]);
}

#[test]
fn shells_and_man_know_every_command() {
    let page = stdout(&sesc(&["man"]));
    assert!(page.contains(".TH"), "{page}");
    let script = stdout(&sesc(&["completions", "bash"]));
    for command in [
        "inspect", "generate", "fit", "diagnose", "compare", "fleet", "demo",
    ] {
        assert!(page.contains(&format!("sesc\\-{command}")), "{page}");
        assert!(script.contains(command));
    }
    let fit = stdout(&sesc(&["man", "fit"]));
    assert!(
        fit.contains("sesc\\-fit") && fit.contains("\\-\\-data"),
        "{fit}"
    );
    refused(&sesc(&["man", "fot"]), &["`fot`", "fit"]);
}

#[test]
fn verdicts_and_warnings_stand_out_where_asked_and_programs_read_plain_text() {
    let urdf = op2();
    let inspect = ["inspect", &urdf, "--support", "r_sole"];
    let plain = stdout(&sesc(&inspect));
    assert!(!plain.contains('\x1b'));
    let painted = stdout(&sesc(&[&inspect[..], &["--color", "always"]].concat()));
    assert!(painted.starts_with("\x1b[1mop2 on r_sole: "));
    assert_eq!(painted.replace("\x1b[1m", "").replace("\x1b[0m", ""), plain);
    for (option, from) in [("--json", "{"), ("--color=never", "op2")] {
        let words = [&inspect[..], &["--color", "auto", option]].concat();
        let words = if option == "--json" {
            words
        } else {
            [&inspect[..], &[option]].concat()
        };
        let text = stdout(&sesc(&words));
        assert!(text.starts_with(from) && !text.contains('\x1b'));
    }
    let wrong = sesc(&in_words(
        "inspect @ --support nowhere --color always",
        &[&urdf],
    ));
    assert!(String::from_utf8_lossy(&wrong.stderr).starts_with("\x1b[1;31merror:\x1b[0m "));
}

#[test]
fn quiet_commands_say_warnings_and_errors_alone() {
    let folder = folder();
    let out = folder.path().join("log.csv").display().to_string();
    let urdf = op2();
    let simulate = in_words(
        "simulate @ --support r_sole --poses 3 --out @",
        &[&urdf, &out],
    );
    assert!(!sesc(&simulate).stderr.is_empty());
    let quiet = sesc(&[&simulate[..], &["--quiet"]].concat());
    assert!(quiet.status.success() && quiet.stderr.is_empty());
    let wrong = sesc(&["inspect", &urdf, "--support", "nowhere", "--quiet"]);
    refused(&wrong, &["nowhere"]);
}

#[test]
fn tables_of_a_robot_fit_a_wide_terminal_and_long_ones_are_asked_for() {
    let inspect = ["inspect", &op2(), "--support", "r_sole"];
    let widest = |text: &str| {
        let tables = text.lines().filter(|line| {
            !line.contains(" moves to its parent ") && !line.contains(" sesc plan ")
        });
        tables.map(|line| line.chars().count()).max().unwrap()
    };
    let text = stdout(&sesc(&inspect));
    assert!(widest(&text) <= 120, "{}", widest(&text));
    assert!(text.contains("Ry(-r_knee)"));
    // Twenty joints hide the same.
    assert_eq!(text.matches("moves to its parent").count(), 0);
    assert!(text.contains("along the axis of each of 20 joints") && text.contains("l_knee"));
    let long = stdout(&sesc(&[&inspect[..], &["--long"]].concat()));
    assert_eq!(long.matches("moves to its parent").count(), 20);
    // One rounding, up, as in the headers of generated files.
    let folder = folder();
    let out = folder.path().display().to_string();
    let generate = "generate @ --support r_sole --lang c --name op2 --out @";
    stdout(&sesc(&in_words(generate, &[&op2(), &out])));
    let header = std::fs::read_to_string(folder.path().join("op2.h")).unwrap();
    let snap = |text: &str| {
        let (_, rest) = text.split_once("by at most ").unwrap();
        rest.split(' ').next().unwrap().to_string()
    };
    assert_eq!(snap(&text), snap(&header));
    assert!(long.contains("Rx(-r_ank_roll) Ry(r_ank_pitch) Ry(-r_knee)"));
}
