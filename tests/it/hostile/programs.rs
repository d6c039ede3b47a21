//! No program is started because of what stands in a file.
#![cfg(unix)]

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Output, Stdio};

use sesc_test_support::command::{Folder, ROOT, says, stdout};

/// A folder with two links in which programs would be found: `xacro` notes what it is called with and
/// prints a sound robot.
struct Watched(Folder);

impl Watched {
    fn new() -> Watched {
        let watched = Folder::with("two_link");
        let noted = watched.at("calls");
        let script = format!(
            "#!/bin/sh\necho \"$@\" >>'{noted}'\ncat '{ROOT}/robots/two_link/two_link.urdf'\n"
        );
        for name in ["xacro", "ros2", "python3", "python"] {
            let program = watched.write(&format!("bin/{name}"), &script);
            fs::set_permissions(program, fs::Permissions::from_mode(0o755)).unwrap();
        }
        Watched(watched)
    }

    /// A command with these programs in its way, and further words.
    fn run(&self, line: &str, words: &[&str], input: &str) -> Output {
        let path = std::env::var("PATH").unwrap_or_default();
        let path = format!("{}:{path}", self.0.at("bin"));
        let mut command = self.0.command(line);
        command.args(words).env("PATH", path);
        let pipes = command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = pipes.stderr(Stdio::piped()).spawn().unwrap();
        // It may not want it.
        let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
        child.wait_with_output().unwrap()
    }

    fn is_untouched(&self, what: &str) {
        let called = self.0.join("calls").exists();
        assert!(!called, "{what}: a program was called");
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
        for name in "r.urdf r.xml r.txt r.XACRO xacro r.xacro.urdf".split(' ') {
            let name = format!("{k}/{name}");
            watched.0.write(&name, text);
            paths.push(name);
        }
    }
    paths.extend(["missing.urdf", ".", "0", "/etc/passwd", "-x"].map(str::to_string));
    for path in &paths {
        watched.run("inspect --support foot --", &[path], "");
        watched.is_untouched(path);
    }
    for text in XACROS {
        for path in ["-", "/dev/stdin"] {
            watched.run("inspect --support foot", &[path], text);
            watched.is_untouched(path);
        }
    }
}

#[test]
fn no_command_starts_a_program_for_a_urdf() {
    let watched = Watched::new();
    let simulate = "simulate two_link.urdf --support foot --poses 40 --out log.csv";
    stdout(&watched.run(simulate, &[], ""));
    watched.0.write("evil.urdf", XACROS[0]);
    // Not by what a file beside it says either.
    watched
        .0
        .write("sesc.toml", "support = \"evil.urdf.xacro\"\n");
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
        assert_ne!(watched.run(line, &[], "").status.code(), Some(0), "{line}");
        watched.is_untouched(line);
    }
    // A typed `.xacro`, and the option, are what does.
    watched.0.write("evil.urdf.xacro", XACROS[0]);
    for urdf in ["evil.urdf.xacro", "evil.urdf --xacro"] {
        stdout(&watched.run(&format!("inspect {urdf} --support foot"), &[], ""));
    }
    assert_eq!(watched.0.read("calls"), "./evil.urdf.xacro\n./evil.urdf\n");
}

#[test]
fn no_folder_or_manifest_of_a_fleet_starts_a_program() {
    let watched = Watched::new();
    let logs = [1, 2].map(|robot| format!("logs/robot={robot}/day=1/log.csv"));
    for log in &logs {
        fs::create_dir_all(watched.0.join(log).parent().unwrap()).unwrap();
        let simulate = "simulate two_link.urdf --support foot --poses 40 --out";
        stdout(&watched.run(simulate, &[log], ""));
    }
    watched.0.write("logs/robot=1/day=1/robot.urdf", XACROS[0]);
    let broken = "<robot name='r'><link name='foot'></robot>";
    watched.0.write("logs/robot=2/robot.urdf", broken);
    watched.0.write("evil.urdf.xacro", XACROS[0]);
    let manifest = format!("path,robot,day,urdf\n{},1,1,evil.urdf.xacro\n", logs[0]);
    watched.0.write("manifest.csv", manifest);
    for data in ["logs", "logs/**/*", "manifest.csv"] {
        let fleet = "fleet two_link.urdf --support foot --json --out f.csv --data";
        let output = watched.run(fleet, &[data], "");
        says(String::from_utf8_lossy(&output.stdout), &["\"failed\""]);
        watched.is_untouched(data);
    }
}
