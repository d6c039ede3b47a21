//! Full disks, folders that take no file, pipes that close, and two writers at once: an error
//! or nothing, and every file as it was or as it will be, whole.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use sesc_test_support::command::{ROOT, folder, program};
use sesc_test_support::kills::WRITERS;

/// A folder with what commands read.
struct Inputs(tempfile::TempDir);

impl Inputs {
    fn new() -> Inputs {
        let inputs = Inputs(folder());
        fs::copy(
            format!("{ROOT}/robots/two_link/two_link.urdf"),
            inputs.path("a.urdf"),
        )
        .unwrap();
        for line in [
            "simulate a.urdf --support foot --poses 60 --noise 0.0005 --out log.csv",
            "fit a.urdf --data log.csv --out model.toml",
        ] {
            assert!(inputs.run(line).status.success());
        }
        fs::create_dir_all(inputs.path("logs/robot=1/day=1")).unwrap();
        for name in ["log.csv", "log.csv.toml"] {
            let day = inputs.path("logs/robot=1/day=1").join(name);
            fs::copy(inputs.path(name), day).unwrap();
        }
        inputs
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(program());
        command.current_dir(self.0.path()).args(line.split(' '));
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }
}

fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => drop(found.insert(path.clone(), fs::read(&path).unwrap())),
        }
    }
    found
}

/// All commands that write, but for the demo, which takes seconds.
fn lines() -> impl Iterator<Item = &'static str> {
    let writers = WRITERS.iter().filter(|writer| writer.name != "demo");
    writers.map(|writer| writer.versions[0])
}

fn refused(output: &Output, line: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {said}");
    assert!(
        said.starts_with("error: ") || said.contains("\nerror: "),
        "{line}: {said}"
    );
    assert!(!said.contains("panicked"), "{line}: {said}");
}

/// A file system of 64 kB of which the outputs take more; where nobody may mount one, a limit on
/// the size of files stands for it, which a write meets in the same way.
#[cfg(target_os = "linux")]
#[test]
fn on_a_full_disk_the_old_files_stay() {
    let inputs = Inputs::new();
    let before = files(inputs.0.path());
    for line in lines() {
        // The limit is in blocks of 512 bytes; without the trap the signal would end it.
        let limited = format!(
            "trap '' XFSZ; ulimit -f 0; exec {} {line} 2>&1",
            program().display()
        );
        let mut shell = Command::new("sh");
        shell.current_dir(inputs.0.path()).args(["-c", &limited]);
        // A pipe is no file, and has no limit.
        let output = shell.stdout(Stdio::piped()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains("error: "), "{line}: {said}");
        assert!(files(inputs.0.path()) == before, "{line}");
    }
    let disk = inputs.path("disk");
    fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
        .arg(&disk)
        .output();
    if !mount.is_ok_and(|output| output.status.success()) {
        println!("no file system of our own here");
        return;
    }
    let old = disk.join("log.csv");
    let log = "pose,ankle,knee,cop_x,cop_y\n1,0,0,0,0\n";
    fs::write(&old, log).unwrap();
    let line = "simulate a.urdf --support foot --poses 20000 --out disk/log.csv";
    let output = inputs.run(line);
    let now = files(&disk);
    let unmounted = Command::new("umount").arg(&disk).status().unwrap();
    assert!(unmounted.success());
    refused(&output, line);
    assert!(String::from_utf8_lossy(&output.stderr).contains("disk/log.csv"));
    assert_eq!(now, BTreeMap::from([(old, log.as_bytes().to_vec())]));
}

/// Whoever may write everywhere is somebody else here.
#[cfg(target_os = "linux")]
#[test]
fn in_a_read_only_folder_nothing_is_written() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    use std::os::unix::process::CommandExt as _;

    let inputs = Inputs::new();
    let allow = |mode| fs::set_permissions(inputs.0.path(), fs::Permissions::from_mode(mode));
    allow(0o555).unwrap();
    let before = files(inputs.0.path());
    // Where that one may not run the program, it runs a copy.
    let copy = folder();
    fs::set_permissions(copy.path(), fs::Permissions::from_mode(0o755)).unwrap();
    let own = copy.path().join("sesc");
    // By another process: a file that is open for writing here while a test on another thread
    // starts a program cannot be run.
    let copied = Command::new("cp").arg(program()).arg(&own).status();
    assert!(copied.unwrap().success());
    let is_root = fs::metadata(copy.path()).unwrap().uid() == 0;
    for line in lines() {
        let mut command = Command::new(&own);
        command.current_dir(inputs.0.path()).args(line.split(' '));
        if is_root {
            command.uid(65_534).gid(65_534);
        }
        refused(&command.output().unwrap(), line);
        assert!(files(inputs.0.path()) == before, "{line}");
    }
    allow(0o755).unwrap();
}

/// Whoever closes a pipe has read enough: files are written all the same.
#[cfg(unix)]
#[test]
fn a_pipe_that_closes_ends_the_words_and_not_the_files() {
    let inputs = Inputs::new();
    for (line, out) in [
        ("fit a.urdf --data log.csv --out fitted.toml", "fitted.toml"),
        (
            "diagnose a.urdf --data log.csv --report page.html",
            "page.html",
        ),
        (
            "fleet a.urdf --data logs --out table.csv --only parameters",
            "table.csv",
        ),
        (
            "generate a.urdf --support foot --name leg --out .",
            "leg.rs",
        ),
    ] {
        let mut command = inputs.command(line);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("panicked"), "{line}: {said}");
        assert_eq!(output.status.code(), Some(0), "{line}: {said}");
        assert!(inputs.path(out).exists(), "{line}");
    }
}

/// Four commands write the same files at the same time, again and again: in the end all are of
/// one of them, and nothing is left beside them.
#[test]
fn of_four_writers_at_once_one_has_all_files() {
    let inputs = Inputs::new();
    for writer in WRITERS {
        let pair = ["simulate, CSV", "fit", "generate, C"];
        if !pair.contains(&writer.name) {
            continue;
        }
        let whole = writer.versions.map(|line| {
            let output = inputs.run(line);
            assert!(output.status.success(), "{line}");
            files(inputs.0.path())
        });
        for _ in 0..8 {
            let [one, other] = writer.versions;
            let four = [one, other, one, other].map(|line| {
                let mut command = inputs.command(line);
                command.stdout(Stdio::null()).stderr(Stdio::null());
                command.spawn().unwrap()
            });
            for mut child in four {
                assert!(child.wait().unwrap().success(), "{}", writer.name);
            }
            let now = files(inputs.0.path());
            assert!(whole.contains(&now), "{}: files of two runs", writer.name);
        }
    }
}
