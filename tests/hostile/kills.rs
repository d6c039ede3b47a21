//! Commands that are killed at any moment leave every file as it was or as it will be, whole,
//! and the next command sweeps what they left beside it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use sesc_test_support::command::{ROOT, folder, program};

/// Kills of each command.
const KILLS: u32 = 12;

fn run(folder: &Path, line: &str) -> Command {
    let mut command = Command::new(program());
    command.current_dir(folder).args(line.split(' '));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// All files of a folder and of those in it, by name; but for temporary ones.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
            continue;
        }
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.ends_with(".part") {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

fn temporary(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name());
    let ours = |name: &std::ffi::OsString| name.to_string_lossy().starts_with(".sesc-");
    names.filter(ours).count()
}

/// Commands in two versions, whose outputs differ.
const COMMANDS: [[&str; 2]; 6] = [
    [
        "simulate a.urdf --support foot --poses 400 --seed 1 --out out.csv",
        "simulate a.urdf --support foot --poses 400 --seed 2 --out out.csv",
    ],
    [
        "simulate a.urdf --support foot --poses 400 --seed 1 --out out.parquet",
        "simulate a.urdf --support foot --poses 400 --seed 2 --out out.parquet",
    ],
    [
        "fit a.urdf --data log.csv --out model.toml --report page.html --urdf b.urdf",
        "fit a.urdf --data log.csv --out model.toml --report page.html --urdf b.urdf --prior tight",
    ],
    [
        "diagnose a.urdf --data log.csv --out model.toml --report page.html",
        "diagnose a.urdf --data log.csv --out model.toml --report page.html --prior cad",
    ],
    [
        "plan a.urdf --support foot --poses 5 --cop-box 0.2 --candidates 50 --seed 1 --out plan.csv",
        "plan a.urdf --support foot --poses 5 --cop-box 0.2 --candidates 50 --seed 2 --out plan.csv",
    ],
    [
        "generate a.urdf --support foot --lang c --scalar f64 --name leg --layout cmake --out out",
        "generate a.urdf --support foot --lang c --scalar f32 --name leg --layout cmake --out out",
    ],
];

#[test]
#[cfg(unix)]
fn killed_commands_leave_old_files_or_new_ones() {
    let mut hit = 0;
    for command in COMMANDS {
        let folder = folder();
        let at = folder.path();
        let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
        fs::copy(urdf, at.join("a.urdf")).unwrap();
        let log = "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out log.csv";
        assert!(run(at, log).status().unwrap().success());
        // What each version writes, and how long it takes.
        let mut whole = Vec::new();
        let mut took = Duration::ZERO;
        for line in command {
            let begun = Instant::now();
            assert!(run(at, line).status().unwrap().success(), "{line}");
            took = begun.elapsed();
            whole.push(files(at));
        }
        for k in 0..KILLS {
            let mut child = run(at, command[(k % 2) as usize]).spawn().unwrap();
            // Evenly over the second half of its time, where it writes.
            std::thread::sleep(took * (KILLS + k) / (2 * KILLS));
            child.kill().unwrap();
            hit += u32::from(!child.wait().unwrap().success());
            let now = files(at);
            assert_eq!(now.len(), whole[0].len(), "{}", command[0]);
            for (name, bytes) in now {
                let is_whole = whole.iter().any(|files| files[&name] == bytes);
                assert!(is_whole, "{}: {name} is neither old nor new", command[0]);
            }
        }
        // A run that comes to its end leaves what it writes and nothing else.
        assert!(run(at, command[0]).status().unwrap().success());
        assert!(files(at) == whole[0]);
        assert_eq!(temporary(at), 0, "{}", command[0]);
    }
    assert!(hit >= KILLS, "only {hit} were killed before their end");
}
