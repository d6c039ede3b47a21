//! Files of a format that this version does not know, and TOML that is none: one sentence each,
//! however long the file's lines are.

use std::fs;
use std::process::Output;

use sesc_test_support::command::{ROOT, folder, refused, sesc, stdout, write};

/// A folder with the two-link robot and a log of it.
struct Stage {
    folder: tempfile::TempDir,
    urdf: String,
    log: String,
}

impl Stage {
    fn new() -> Stage {
        let folder = folder();
        let urdf = fs::read_to_string(format!("{ROOT}/robots/two_link/two_link.urdf")).unwrap();
        let urdf = write(folder.path(), "robot.urdf", urdf);
        let log = folder.path().join("log.csv").display().to_string();
        let stage = Stage { folder, urdf, log };
        let log = &stage.log;
        let simulate = ["--poses", "20", "--noise", "0.0005", "--out", log];
        stdout(&stage.run("simulate", &simulate));
        stage
    }

    fn run(&self, command: &str, rest: &[&str]) -> Output {
        let robot = [command, &self.urdf, "--support", "foot"];
        sesc(&[&robot[..], rest].concat())
    }

    /// What the reader of each kind of TOML says of `text`, and the file's name.
    fn answers(&self, text: &str) -> Vec<(&'static str, Output)> {
        let folder = self.folder.path();
        let mut answers = Vec::new();
        let sidecar = write(folder, "log.csv.toml", text);
        answers.push(("log.csv.toml", self.run("fit", &["--data", &self.log])));
        fs::remove_file(sidecar).unwrap();
        let prior = write(folder, "prior.toml", text);
        let fit = ["--data", &self.log, "--prior", &prior];
        answers.push(("prior.toml", self.run("fit", &fit)));
        let out = folder.join("out").display().to_string();
        let servos = write(folder, "servos.toml", text);
        let generate = ["--lang", "c", "--out", &out, "--servos", &servos];
        answers.push(("servos.toml", self.run("generate", &generate)));
        let model = write(folder, "model.toml", text);
        let generate = ["--out", &out, "--model", &model];
        answers.push(("model.toml", self.run("generate", &generate)));
        let settings = write(folder, "sesc.toml", text);
        answers.push(("sesc.toml", self.run("fit", &["--data", &self.log])));
        fs::remove_file(settings).unwrap();
        answers
    }
}

#[test]
fn files_of_a_newer_format_are_refused_with_a_sentence() {
    for (file, output) in Stage::new().answers("format = 9\nwhat = 'nobody knows yet'\n") {
        refused(
            &output,
            &[
                file,
                "format 9",
                "reads formats up to 1",
                "take the version",
            ],
        );
    }
}

/// The first format may be said, although no file needs to.
#[test]
fn files_that_say_the_first_format_are_read() {
    let stage = Stage::new();
    for (file, output) in stage.answers("format = 1\n") {
        if file != "model.toml" {
            stdout(&output);
        }
    }
}

/// Messages do not repeat the file.
#[test]
fn long_lines_are_not_repeated() {
    let stage = Stage::new();
    let long = [
        format!("x = [{}", "1,".repeat(400_000)),
        format!("support = {}", "\u{1b}".repeat(400_000)),
        format!("[links]\n{} = 'heavy'", "k".repeat(400_000)),
        format!("[joints.{}]\nzero = 1e300", "k".repeat(400_000)),
        format!("{} = 1", "k".repeat(400_000)),
    ];
    for text in long {
        for (file, output) in stage.answers(&text) {
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(said.len() < 4000, "{file}: {} bytes", said.len());
            assert!(!said.contains('\u{1b}'), "{file}");
        }
    }
}

/// A number is written with as many digits as tell it.
#[test]
fn huge_numbers_are_short_in_messages() {
    let stage = Stage::new();
    let servos = write(
        stage.folder.path(),
        "servos.toml",
        "[default]\nresolution = 1e300\n",
    );
    let out = stage.folder.path().join("out").display().to_string();
    let output = stage.run(
        "generate",
        &["--lang", "c", "--out", &out, "--servos", &servos],
    );
    refused(&output, &["resolution is 1e300"]);
    assert!(output.stderr.len() < 300);
}
