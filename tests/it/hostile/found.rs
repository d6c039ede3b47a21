//! Files that nobody typed: sidecars, `sesc.toml` and what it names.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;

use sesc_test_support::command::{Folder, printed, stderr};

const FIT: &str = "fit op2.urdf --support r_sole --data log.csv";

/// Opening a pipe would wait for ever.
#[test]
fn pipes_and_folders_in_their_places_are_refused() {
    let folder = Folder::with_log("--poses 60 --noise 0.0005");
    fs::remove_file(folder.join("log.csv.toml")).unwrap();
    let pipe = |name: &str| drop(printed(Command::new("mkfifo").arg(folder.join(name))));
    for (name, line) in [
        ("sesc.toml", "inspect op2.urdf --support r_sole"),
        ("sesc.toml", FIT),
        ("log.csv.toml", FIT),
        ("log.toml", FIT),
        (
            "log.csv.toml",
            "predict op2.urdf --support r_sole --data log.csv",
        ),
    ] {
        pipe(name);
        folder.refuses(line, &[name, "it is a pipe or a device"]);
        fs::remove_file(folder.join(name)).unwrap();
        fs::create_dir(folder.join(name)).unwrap();
        folder.refuses(line, &[name, "it is a folder"]);
        fs::remove_dir(folder.join(name)).unwrap();
    }
    pipe("tolerances.toml");
    folder.write("sesc.toml", "\nprior = \"tolerances.toml\"\n");
    folder.refuses(FIT, &["sesc.toml:2: `prior`: it is a pipe or a device"]);
}

/// Whoever unpacks a robot does not show other files to those who read a report.
#[test]
fn sesc_toml_names_files_of_its_folder_alone() {
    let folder = Folder::with("op2");
    folder.write("secret", "root:x:0:0\n");
    fs::create_dir(folder.join("robot")).unwrap();
    fs::rename(folder.join("op2.urdf"), folder.join("robot/op2.urdf")).unwrap();
    symlink("../secret", folder.join("robot/link")).unwrap();
    let secret = folder.at("secret");
    for key in ["prior", "limits", "sole", "servos"] {
        for value in [&secret, "../secret", "./../secret", "link", "/dev/stdin"] {
            folder.write("robot/sesc.toml", format!("\n{key} = {value:?}\n"));
            let output = folder.run("inspect robot/op2.urdf --support r_sole");
            let said = stderr(&output);
            let wanted = format!("sesc.toml:2: `{key}`: it is outside the folder");
            assert!(
                output.status.code() == Some(2) && said.contains(&wanted),
                "{said}"
            );
            assert!(!said.contains("root:"), "{said}");
        }
    }
    // A file below the folder is read.
    folder.write(
        "robot/more/limits.csv",
        "joint,lower_rad,upper_rad\nhead_pan,-0.1,0.1\n",
    );
    folder.write("robot/sesc.toml", "limits = \"more/limits.csv\"\n");
    let said =
        stderr(&folder.run("plan robot/op2.urdf --support r_sole --poses 3 --out poses.csv"));
    assert!(
        said.contains("--limits=") && !said.contains("error"),
        "{said}"
    );
}
