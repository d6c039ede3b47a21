//! Logs that change while a command reads them are noticed: what was read is neither what
//! the file was nor what it is.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Stdio};

use sesc_identify::logs::{LogSource, Options, PostureReader};
use sesc_identify::robot::Robot;
use sesc_test_support::command::{Folder, refused};

/// More rows than a command reads before it prints the first, and more than a pipe holds.
const ROWS: u32 = 30_000;

/// Two links in a folder with a log of so many rows.
fn logged(rows: u32) -> Folder {
    let folder = Folder::with("two_link");
    log(&folder, "log.csv", rows);
    folder
}

fn log(folder: &Folder, name: &str, rows: u32) {
    let options = format!("--support foot --poses {rows} --out {name}");
    folder.stdout(&format!("simulate two_link.urdf {options}"));
}

/// `sesc predict`, which waits in the middle of the log until somebody takes what it prints.
fn waiting(folder: &Folder) -> Child {
    let mut command = folder.command("predict two_link.urdf --support foot --data log.csv");
    let pipes = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = pipes.spawn().unwrap();
    let mut first = [0];
    let stdout = child.stdout.as_mut().unwrap();
    stdout.read_exact(&mut first).unwrap();
    child
}

#[test]
fn a_log_that_changes_while_it_is_read_is_an_error() {
    let folder = logged(ROWS);
    let path = folder.join("log.csv");
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
        let child = waiting(&folder);
        change(&path);
        let mut output = child.wait_with_output().unwrap();
        // What was printed before.
        output.stdout.clear();
        refused(
            &output,
            &["log.csv", "it changed while it was read", "read a copy"],
        );
        fs::write(&path, &whole).unwrap();
    }
}

/// Who puts a new file in the place of the old one harms nobody who reads the old one.
#[cfg(unix)]
#[test]
fn a_log_that_is_replaced_is_read_to_its_end() {
    let folder = logged(ROWS);
    log(&folder, "other.csv", 10);
    let child = waiting(&folder);
    fs::rename(folder.join("other.csv"), folder.join("log.csv")).unwrap();
    let output = child.wait_with_output().unwrap();
    // A row each, the header, and the byte that was taken.
    let rows = String::from_utf8(output.stdout).unwrap().lines().count();
    assert!(output.status.success());
    assert_eq!(rows, 30_001);
}

/// A fit reads its log twice: to look at the rows, and to fit them.
#[test]
fn a_log_that_is_another_the_second_time_is_an_error() {
    let folder = logged(50);
    let path = folder.join("log.csv");
    let robot = Robot::read(&folder.join("two_link.urdf")).unwrap();
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
    log(&folder, "log.csv", 60);
    let said = read(&source).unwrap_err();
    assert!(format!("{said:?}").contains("changed while it was read"));
    // Who asks again gets the new one.
    assert_eq!(read(&LogSource::from(&path)).unwrap(), 60);
}
