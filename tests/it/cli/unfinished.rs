//! Commands that do not come to their end leave nothing, and speak of the
//! files that the user named.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use sesc_test_support::command::{Folder, op2, printed, refused, stderr};

/// More postures than anybody waits for.
fn long(folder: &Folder, out: &str) -> Command {
    let options = "--support r_sole --poses 10000000 --out";
    folder.command(&format!("simulate {} {options} {out}", op2()))
}

#[test]
#[cfg(unix)]
fn an_interrupted_command_leaves_no_file() {
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        for log in ["log.csv", "log.csv.gz", "log.parquet"] {
            let folder = Folder::empty();
            let mut command = long(&folder, log);
            let mut child = command.stderr(Stdio::null()).spawn().unwrap();
            let begun = Instant::now();
            while folder.names().is_empty() {
                let waited = begun.elapsed();
                assert!(waited < Duration::from_secs(60), "{log}: nothing begun");
                sleep(Duration::from_millis(5));
            }
            let kill = format!("kill -{signal} {}", child.id());
            printed(Command::new("sh").args(["-c", &kill]));
            assert_eq!(child.wait().unwrap().code(), Some(code), "{signal} {log}");
            assert_eq!(folder.names(), [""; 0], "{signal}");
        }
    }
}

/// Neither the name of a temporary file nor the place behind a link is said, and where the disk
/// fills up the old file stays: one that may not grow stands for it.
#[test]
#[cfg(unix)]
fn a_file_that_cannot_be_written_is_the_one_named() {
    let old = "pose,hip,cop_x,cop_y\n1,0,0,0\n";
    for log in ["log.csv", "log.csv.gz", "log.parquet"] {
        let folder = Folder::empty();
        let gone = long(&folder, &format!("gone/{log}")).output().unwrap();
        let name = format!("gone/{log}");
        refused(&gone, &["cannot write", &name, "No such file"]);
        folder.write("real.csv", old);
        std::os::unix::fs::symlink("real.csv", folder.join(log)).unwrap();
        let simulate = long(&folder, &folder.at(log));
        let mut shell = Command::new("sh");
        // Blocks of 512 or 1024 bytes; the signal would kill where writing should fail.
        shell.args(["-c", "ulimit -f 2000; trap '' XFSZ; exec \"$0\" \"$@\""]);
        shell.arg(simulate.get_program()).args(simulate.get_args());
        let full = shell.output().unwrap();
        refused(&full, &["cannot write", &format!("/{log}"), "too large"]);
        for output in [gone, full] {
            let said = stderr(&output).replace(&folder.at(""), "");
            assert!(
                !said.contains(".tmp") && !said.contains("real.csv"),
                "{said}"
            );
        }
        assert_eq!(folder.names(), [log, "real.csv"]);
        assert!(fs::symlink_metadata(folder.join(log)).unwrap().is_symlink());
        assert_eq!(folder.read("real.csv"), old);
    }
}
