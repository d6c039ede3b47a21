//! `sesc.toml` beside a URDF: options that need not be typed again.

use std::fs;

use sesc_test_support::command::{Folder, op2, rows, says, sesc, stderr, stdout};

/// The OP2 in a folder with this `sesc.toml`.
fn robot(defaults: &str) -> Folder {
    let folder = Folder::with("op2");
    folder.write("sesc.toml", defaults);
    folder
}

#[test]
fn options_of_the_robot_need_not_be_typed() {
    let folder = robot("support = \"r_sole\"\nno_snap = true\n");
    let typed = sesc(&["inspect", &op2(), "--support", "r_sole", "--no-snap"]);
    let short = folder.run("inspect op2.urdf");
    // Steps to take next have the path that was typed.
    let found = |text: String| text.split("\nnext ").next().unwrap().to_string();
    assert_eq!(found(stdout(&short)), found(stdout(&typed)));
    says(
        stderr(&short),
        &["sesc.toml gives --support=r_sole --no-snap"],
    );

    // A number has no more digits than it was written with.
    folder.write("sesc.toml", "support = \"r_sole\"\nnoise = 1e-300\n");
    let note = stderr(&folder.run("diagnose op2.urdf --data log.csv"));
    says(note, &["--noise=1e-300"]);

    // What is typed wins, and is not in the note.
    let left = folder.run("inspect op2.urdf --support l_sole");
    assert!(stdout(&left).starts_with("op2 on l_sole"));
    assert!(!stderr(&left).contains("r_sole"));
}

#[test]
fn a_log_that_names_its_support_link_wins() {
    let folder = robot("support = \"r_sole\"\nprior = \"tight\"\n");
    let options = "--poses 30 --noise 0.0005 --out log.csv";
    folder.stdout(&format!("simulate op2.urdf --support l_sole {options}"));
    let found = folder.stdout("fit op2.urdf --data log.csv");
    assert!(found.starts_with("op2 on l_sole"));

    folder.simulate(options);
    fs::remove_file(folder.join("log.csv.toml")).unwrap();
    let found = folder.run("fit op2.urdf --data log.csv");
    assert!(stdout(&found).starts_with("op2 on r_sole"));
    says(stderr(&found), &["gives --support=r_sole --prior=tight"]);
}

#[test]
fn paths_are_relative_to_the_file() {
    let folder = Folder::empty();
    folder.write("robot/op2.urdf", fs::read(op2()).unwrap());
    let defaults = "support = \"r_sole\"\nlimits = \"limits.csv\"\n";
    folder.write("robot/sesc.toml", defaults);
    let plan = "plan robot/op2.urdf --poses 3 --out poses.csv";
    folder.refuses(plan, &["limits.csv"]);
    let limits = "joint,lower_rad,upper_rad\nhead_pan,-0.1,0.1\n";
    folder.write("robot/limits.csv", limits);
    folder.stdout(plan);
}

/// A value that the file gives is not blamed on an option that nobody typed, and what is typed is.
#[test]
fn what_is_wrong_with_the_file_is_said_with_its_name_and_line() {
    let plan = "plan op2.urdf --poses 3 --out poses.csv";
    let faults = rows(
        "suport = 'r_sole'               | inspect op2.urdf --json | did you mean `support`?
         support = 3                     | inspect op2.urdf --json | `support`: give a text in quotes
         noise = 'small'                 | inspect op2.urdf | `noise`: give a number
         degrees = 1                     | inspect op2.urdf | `degrees`: give true or false
         support =                       | inspect op2.urdf | line 1
         support = 'r_sole'//noise = 5   | plan op2.urdf --poses 3 --out poses.csv
             | sesc.toml:3: `noise` | 0.005 for 5 mm
         support = 'r_sole'/noise = -0.001 | plan op2.urdf --poses 3 --out poses.csv
             | sesc.toml:2: `noise` | above zero
         / motion = 'slow'               | fit op2.urdf --data l.csv
             | sesc.toml:2: `motion` | auto, off",
    );
    for row in faults {
        let cells: Vec<&str> = row.iter().map(String::as_str).collect();
        let [text, line, words @ ..] = &cells[..] else {
            panic!("{row:?}")
        };
        // A stroke ends a line.
        let folder = robot(&(text.replace('/', "\n") + "\n"));
        folder.refuses(line, &[&["sesc.toml"], words].concat());
    }
    let folder = robot("support = \"r_sole\"\nnoise = 0.001\n");
    let typed = format!("{plan} --noise 5");
    folder.refuses(&typed, &["--noise", "0.005 for 5 mm"]);
    assert!(!stderr(&folder.run(&typed)).contains("sesc.toml:"));
}

/// An option that is typed wins over one of the file that it does not go with.
#[test]
fn options_of_the_file_give_way_to_those_that_contradict_them() {
    let folder = robot("support = \"r_sole\"\ncop_box = 0.02\n");
    let sole = "--sole 0.03,0.02;-0.03,0.02;-0.03,-0.02;0.03,-0.02";
    let plan = "plan op2.urdf --poses 3 --candidates 50 --out poses.csv";
    let said = folder.stdout(&format!("{plan} {sole}"));
    says(said, &["a sole of 4 corners"]);
}
