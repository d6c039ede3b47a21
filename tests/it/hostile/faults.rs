//! Full disks, folders that take no file, and two writers at once: an error or nothing, and every
//! file as it was or as it will be, whole.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use sesc_test_support::command::{Folder, folder, printed, program, stderr};
use sesc_test_support::kills::{inputs, writers};

/// All commands that write, but for the demo, which takes seconds.
fn lines() -> impl Iterator<Item = String> {
    let lasting = writers().filter(|writer| writer.name != "demo");
    lasting.map(|writer| writer.line(0))
}

/// Exit code 2 and an error, and the folder has these files.
fn refused(output: &Output, line: &str, folder: &Folder, before: &BTreeMap<PathBuf, Vec<u8>>) {
    let said = stderr(output) + &String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    let is_error = said.starts_with("error: ") || said.contains("\nerror: ");
    assert!(is_error && !said.contains("panicked"), "{line}: {said}");
    assert!(folder.files() == *before, "{line}");
}

/// A file system of 64 kB of which the outputs take more; where nobody may mount one, a limit on
/// the size of files stands for it, which a write meets in the same way.
#[cfg(target_os = "linux")]
#[test]
fn on_a_full_disk_the_old_files_stay() {
    let inputs = inputs();
    let before = inputs.files();
    for line in lines() {
        // The limit is in blocks of 512 bytes; without the trap the signal would end it.
        let program = program().display().to_string();
        let limited = format!("trap '' XFSZ; ulimit -f 0; exec {program} {line} 2>&1");
        let mut shell = Command::new("sh");
        shell.current_dir(inputs.path()).args(["-c", &limited]);
        // A pipe is no file, and has no limit.
        let output = shell.stdout(Stdio::piped()).output().unwrap();
        refused(&output, &line, &inputs, &before);
    }
    let log = "pose,ankle,knee,cop_x,cop_y\n1,0,0,0,0\n";
    fs::create_dir(inputs.join("disk")).unwrap();
    let mut mount = Command::new("mount");
    mount.args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"]);
    let mount = mount.arg(inputs.join("disk")).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        println!("no file system of our own here");
        return;
    }
    inputs.write("disk/log.csv", log);
    let before = inputs.files();
    let line = "simulate a.urdf --support foot --poses 20000 --out disk/log.csv";
    let output = inputs.run(line);
    let now = inputs.files();
    printed(Command::new("umount").arg(inputs.join("disk")));
    assert!(now == before);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("error: ") && said.contains("disk/log.csv"),
        "{said}"
    );
}

/// Whoever may write everywhere is somebody else here.
#[cfg(target_os = "linux")]
#[test]
fn in_a_read_only_folder_nothing_is_written() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;

    let inputs = inputs();
    let allow = |mode| fs::set_permissions(inputs.path(), fs::Permissions::from_mode(mode));
    allow(0o555).unwrap();
    let before = inputs.files();
    // Where that one may not run the program, it runs a copy.
    let copy = folder();
    fs::set_permissions(copy.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let own = copy.path().join("sesc");
    // By another process: a file that is open for writing here while a test on another thread
    // starts a program cannot be run.
    printed(Command::new("cp").arg(program()).arg(&own));
    let is_root = fs::metadata(copy.path()).unwrap().uid() == 0;
    for line in lines() {
        let mut command = Command::new(&own);
        command
            .current_dir(inputs.path())
            .args(line.split_whitespace());
        if is_root {
            command.uid(65_534).gid(65_534);
        }
        refused(&command.output().unwrap(), &line, &inputs, &before);
    }
    allow(0o755).unwrap();
}

/// Four commands write the same files at the same time, again and again: in the end all are of
/// one of them, and nothing is left beside them.
#[test]
fn of_four_writers_at_once_one_has_all_files() {
    let inputs = inputs();
    let pair = ["simulate, CSV", "fit", "generate, C"];
    for writer in writers().filter(|writer| pair.contains(&&*writer.name)) {
        let whole = [0, 1].map(|version| {
            inputs.stdout(&writer.line(version));
            inputs.files()
        });
        for _ in 0..8 {
            let four = [0, 1, 0, 1].map(|version| {
                let mut command = inputs.command(&writer.line(version));
                command.stdout(Stdio::null()).stderr(Stdio::null());
                command.spawn().unwrap()
            });
            for mut child in four {
                assert!(child.wait().unwrap().success(), "{}", writer.name);
            }
            let now = inputs.files();
            assert!(whole.contains(&now), "{}: files of two runs", writer.name);
        }
    }
}
