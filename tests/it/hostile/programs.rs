//! No program is started because of what stands in a file.
#![cfg(unix)]

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use sesc_test_support::command::{ROOT, folder, program, stdout};

/// A folder in which programs would be found: `xacro` notes what it is called with and prints a
/// sound robot.
struct Watched(tempfile::TempDir);

impl Watched {
    fn new() -> Watched {
        let watched = Watched(folder());
        let noted = watched.at("calls");
        let script = format!(
            "#!/bin/sh\necho \"$@\" >>'{}'\ncat '{ROOT}/robots/two_link/two_link.urdf'\n",
            noted.display()
        );
        for name in ["xacro", "ros2", "python3", "python"] {
            fs::create_dir_all(watched.at("bin")).unwrap();
            fs::write(watched.at("bin").join(name), &script).unwrap();
            let all = fs::Permissions::from_mode(0o755);
            fs::set_permissions(watched.at("bin").join(name), all).unwrap();
        }
        watched
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::create_dir_all(self.at(name).parent().unwrap()).unwrap();
        fs::write(self.at(name), text).unwrap();
    }

    fn run(&self, words: &[&str], input: &str) -> Output {
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", self.at("bin").display());
        let mut child = Command::new(program())
            .args(words)
            .current_dir(self.0.path())
            .env("PATH", path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // It may not want it.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        child.wait_with_output().unwrap()
    }

    fn is_untouched(&self, what: &str) {
        let calls = fs::read_to_string(self.at("calls")).unwrap_or_default();
        assert!(calls.is_empty(), "{what}: a program was called: {calls}");
    }
}

/// Python in an expression, a call of a macro, and a value that xacro would compute.
const XACROS: [&str; 3] = [
    "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>\
     <xacro:property name='n' value=\"${(lambda: 1)()}\"/><link name='foot'/>${n}</robot>",
    "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:leg side='l'/></robot>",
    "<robot name='r'><link name='${n}'/></robot>",
];

#[test]
fn no_urdf_starts_a_program() {
    let watched = Watched::new();
    let bad = fs::read_dir(format!("{ROOT}/tests/bad_urdf")).unwrap();
    let bad = bad.map(|entry| entry.unwrap().path().display().to_string());
    let mut paths: Vec<String> = bad.collect();
    assert!(paths.len() > 50);
    let texts = XACROS.into_iter().chain(["hello", ""]);
    for (k, text) in texts.enumerate() {
        for name in [
            "r.urdf",
            "r.xml",
            "r.txt",
            "r.XACRO",
            "xacro",
            "r.xacro.urdf",
        ] {
            let name = format!("{k}/{name}");
            watched.write(&name, text);
            paths.push(name);
        }
    }
    paths.extend(["missing.urdf", ".", "0", "/etc/passwd", "-x"].map(str::to_string));
    for path in &paths {
        watched.run(&["inspect", "--support", "foot", "--", path], "");
        watched.is_untouched(path);
    }
    for text in XACROS {
        for path in ["-", "/dev/stdin"] {
            watched.run(&["inspect", path, "--support", "foot"], text);
            watched.is_untouched(path);
        }
    }
}

#[test]
fn no_command_starts_a_program_for_a_urdf() {
    let watched = Watched::new();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    let simulate = ["--support", "foot", "--poses", "40", "--out", "log.csv"];
    stdout(&watched.run(&[&["simulate", &two_link][..], &simulate].concat(), ""));
    watched.write("evil.urdf", XACROS[0]);
    // Not by what a file beside it says either.
    watched.write("sesc.toml", "support = \"evil.urdf.xacro\"\n");
    for line in [
        "verify evil.urdf --support foot",
        "generate evil.urdf --support foot --lang c --out out",
        "plan evil.urdf --support foot --poses 3 --out p.csv",
        "simulate evil.urdf --support foot --poses 3 --out l.csv",
        "predict evil.urdf --data log.csv",
        "fit evil.urdf --data log.csv",
        "diagnose evil.urdf --data log.csv",
        "compare log.csv log.csv --urdf evil.urdf",
        "fleet evil.urdf --data log.csv --out f.csv",
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        assert_ne!(watched.run(&words, "").status.code(), Some(0), "{line}");
        watched.is_untouched(line);
    }
    // A typed `.xacro`, and the option, are what does.
    watched.write("evil.urdf.xacro", XACROS[0]);
    for words in [
        &["inspect", "evil.urdf.xacro", "--support", "foot"][..],
        &["inspect", "evil.urdf", "--xacro", "--support", "foot"],
    ] {
        stdout(&watched.run(words, ""));
    }
    let calls = fs::read_to_string(watched.at("calls")).unwrap();
    assert_eq!(calls, "./evil.urdf.xacro\n./evil.urdf\n");
}

#[test]
fn no_folder_or_manifest_of_a_fleet_starts_a_program() {
    let watched = Watched::new();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    for robot in ["1", "2"] {
        let log = format!("logs/robot={robot}/day=1/log.csv");
        fs::create_dir_all(watched.at(&log).parent().unwrap()).unwrap();
        let words = ["simulate", &two_link, "--support", "foot", "--poses", "40"];
        stdout(&watched.run(&[&words[..], &["--out", &log]].concat(), ""));
    }
    watched.write("logs/robot=1/day=1/robot.urdf", XACROS[0]);
    watched.write(
        "logs/robot=2/robot.urdf",
        "<robot name='r'><link name='foot'></robot>",
    );
    watched.write("evil.urdf.xacro", XACROS[0]);
    watched.write(
        "manifest.csv",
        "path,robot,day,urdf\nlogs/robot=1/day=1/log.csv,1,1,evil.urdf.xacro\n",
    );
    for data in ["logs", "logs/**/*", "manifest.csv"] {
        let fleet = ["fleet", &two_link, "--data", data, "--support", "foot"];
        let output = watched.run(&[&fleet[..], &["--json", "--out", "f.csv"]].concat(), "");
        let answer = String::from_utf8_lossy(&output.stdout);
        assert!(answer.contains("\"failed\""), "{answer}");
        watched.is_untouched(data);
    }
}
