//! Commands that do not come to their end leave nothing, and speak of the
//! files that the user named.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
    entries
        .map(|entry| name(entry).to_string_lossy().into_owned())
        .collect()
}

/// What was said, but for the name of the test's own folder.
fn message(output: &Output, folder: &Path) -> String {
    let said = String::from_utf8_lossy(&output.stderr);
    said.replace(&folder.display().to_string(), "")
}

/// More postures than anybody waits for.
fn long(out: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sesc"));
    command
        .args(["simulate", &op2(), "--support", "r_sole"])
        .args(["--poses", "10000000", "--out"])
        .arg(out)
        .stderr(Stdio::null());
    command
}

#[test]
#[cfg(unix)]
fn an_interrupted_command_leaves_no_file() {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        for log in ["log.csv", "log.csv.gz", "log.parquet"] {
            let folder = folder();
            let mut child = long(&folder.path().join(log)).spawn().unwrap();
            let begun = Instant::now();
            while names(folder.path()).is_empty() {
                assert!(
                    begun.elapsed() < Duration::from_secs(60),
                    "{log}: nothing begun"
                );
                std::thread::sleep(Duration::from_millis(5));
            }
            let kill = format!("kill -{signal} {}", child.id());
            assert!(
                Command::new("sh")
                    .args(["-c", &kill])
                    .status()
                    .unwrap()
                    .success()
            );
            assert_eq!(child.wait().unwrap().code(), Some(code), "{signal} {log}");
            assert!(
                names(folder.path()).is_empty(),
                "{signal}: {:?}",
                names(folder.path())
            );
        }
    }
}

/// Neither the name of a temporary file nor the place behind a link.
#[test]
fn a_file_that_cannot_be_written_is_the_one_named() {
    let folder = folder();
    let out = folder.path().join("gone/log.csv");
    let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
    let simulate = in_words("simulate @ --support foot --poses 5 --out", &[&urdf]);
    let output = sesc(&[&simulate[..], &[out.to_str().unwrap()]].concat());
    refused(&output, &["cannot write", "gone/log.csv", "No such file"]);
    assert!(!message(&output, folder.path()).contains(".tmp"));
}

/// A log that is replaced, which it would not be by one of another kind.
const OLD: &str = "pose,hip,cop_x,cop_y\n1,0,0,0\n";

/// A file that may not grow stands for a disk that is full.
#[test]
#[cfg(unix)]
fn a_disk_that_fills_up_leaves_no_file() {
    for log in ["log.csv", "log.csv.gz", "log.parquet"] {
        let folder = folder();
        fs::write(folder.path().join("real.csv"), OLD).unwrap();
        std::os::unix::fs::symlink("real.csv", folder.path().join(log)).unwrap();
        let simulate = long(&folder.path().join(log));
        let output = Command::new("sh")
            // Blocks of 512 or 1024 bytes; the signal would kill where writing should fail.
            .args(["-c", "ulimit -f 2000; trap '' XFSZ; exec \"$0\" \"$@\""])
            .arg(simulate.get_program())
            .args(simulate.get_args())
            .output()
            .unwrap();
        refused(&output, &["cannot write", &format!("/{log}"), "too large"]);
        let message = message(&output, folder.path());
        assert!(
            !message.contains(".tmp") && !message.contains("real.csv"),
            "{message}"
        );
        let mut left = names(folder.path());
        left.sort();
        assert_eq!(left, [log, "real.csv"]);
        assert_eq!(
            fs::read_to_string(folder.path().join("real.csv")).unwrap(),
            OLD
        );
    }
}
