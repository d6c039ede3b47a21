//! Logs that change while a command reads them are noticed: what was read is neither what
//! the file was nor what it is.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use sesc_identify::logs::{LogSource, Options, PostureReader};
use sesc_identify::robot::Robot;
use sesc_test_support::command::{ROOT, folder, program, sesc, stdout};

/// More rows than a command reads before it prints the first, and more than a pipe holds.
const ROWS: &str = "30000";

fn urdf() -> String {
    format!("{ROOT}/robots/two_link/two_link.urdf")
}

fn log(at: &Path, poses: &str) {
    let (urdf, out) = (urdf(), at.display().to_string());
    let robot = ["simulate", &urdf, "--support", "foot"];
    let what = ["--poses", poses, "--out", &out];
    stdout(&sesc(&[&robot[..], &what].concat()));
}

/// `sesc predict`, which waits in the middle of the log until somebody takes what it prints.
fn waiting(log: &Path) -> Child {
    let mut child = Command::new(program())
        .args(["predict", &urdf(), "--support", "foot", "--data"])
        .arg(log)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0];
    child
        .stdout
        .as_mut()
        .unwrap()
        .read_exact(&mut first)
        .unwrap();
    child
}

#[test]
fn a_log_that_changes_while_it_is_read_is_an_error() {
    let folder = folder();
    let path = folder.path().join("log.csv");
    log(&path, ROWS);
    let whole = fs::read(&path).unwrap();
    let appended = |path: &Path| {
        let mut file = File::options().append(true).open(path).unwrap();
        file.write_all(b"40000,0,0,0,0\n").unwrap();
    };
    let cut = |path: &Path| {
        let file = File::options().write(true).open(path).unwrap();
        file.set_len(whole.len() as u64 * 3 / 4).unwrap();
    };
    // As many bytes as before.
    let overwritten = |path: &Path| fs::write(path, &whole).unwrap();
    let changes: [&dyn Fn(&Path); 3] = [&appended, &cut, &overwritten];
    for change in changes {
        let child = waiting(&path);
        change(&path);
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        for word in ["log.csv", "it changed while it was read", "read a copy"] {
            assert!(said.contains(word), "{said}");
        }
        fs::write(&path, &whole).unwrap();
    }
}

/// Who puts a new file in the place of the old one harms nobody who reads the old one.
#[cfg(unix)]
#[test]
fn a_log_that_is_replaced_is_read_to_its_end() {
    let folder = folder();
    let path = folder.path().join("log.csv");
    log(&path, ROWS);
    let other = folder.path().join("other.csv");
    log(&other, "10");
    let child = waiting(&path);
    fs::rename(&other, &path).unwrap();
    let output = child.wait_with_output().unwrap();
    // A row each, the header, and the byte that was taken.
    let rows = String::from_utf8(output.stdout).unwrap().lines().count();
    assert!(output.status.success());
    assert_eq!(rows, 30_001);
}

/// A fit reads its log twice: to look at the rows, and to fit them.
#[test]
fn a_log_that_is_another_the_second_time_is_an_error() {
    let folder = folder();
    let path = folder.path().join("log.csv");
    log(&path, "50");
    let robot = Robot::read(Path::new(&urdf())).unwrap();
    let dofs = robot.description.dofs();
    let source = LogSource::from(&path).unchanged().unwrap();
    let read = |source: &LogSource| -> Result<usize, sesc_identify::Error> {
        let mut reader = PostureReader::open(source, &dofs, &Options::default())?;
        let mut rows = 0;
        loop {
            let block = reader.block(16)?;
            if block.is_empty() {
                return Ok(rows);
            }
            rows += block.len();
        }
    };
    assert_eq!(read(&source).unwrap(), 50);
    assert_eq!(read(&source).unwrap(), 50);
    log(&path, "60");
    let said = read(&source).unwrap_err();
    assert!(format!("{said:?}").contains("changed while it was read"));
    // Who asks again gets the new one.
    assert_eq!(read(&LogSource::from(&path)).unwrap(), 60);
}
