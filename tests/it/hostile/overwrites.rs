//! No output takes the place of an input, however the two are spelled.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use sesc_test_support::command::{ROOT, folder, program, refused, sesc, stdout};

/// A folder with everything that a command may read.
struct Inputs(tempfile::TempDir);

impl Inputs {
    fn new() -> Inputs {
        let inputs = Inputs(folder());
        let urdf = format!("{ROOT}/robots/two_link/two_link.urdf");
        fs::copy(urdf, inputs.path("a.urdf")).unwrap();
        let simulate = "simulate a.urdf --support foot --poses 40 --noise 0.0005 --out log.csv";
        stdout(&inputs.run(simulate));
        // The older name of a sidecar, which `fit` reads as long as there is no other.
        fs::rename(inputs.path("log.csv.toml"), inputs.path("log.toml")).unwrap();
        stdout(&inputs.run("fit a.urdf --data log.csv --out model.toml"));
        stdout(&inputs.run("fit a.urdf --data log.csv --partial a.part"));
        for (from, to) in [("model.toml", "other.toml"), ("log.csv", "other.csv")] {
            fs::copy(inputs.path(from), inputs.path(to)).unwrap();
        }
        for (name, text) in [
            ("prior.toml", "[default]\nmass = 0.1\ncom = 0.005\n"),
            ("servos.toml", "[default]\nzero = 2048\n"),
            ("limits.csv", "joint,lower_deg,upper_deg\nknee,-40,40\n"),
            ("sole.csv", "0.1,0.1\n-0.1,0.1\n-0.1,-0.1\n0.1,-0.1\n"),
        ] {
            fs::write(inputs.path(name), text).unwrap();
        }
        inputs
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, line: &str) -> std::process::Output {
        let mut command = Command::new(program());
        command.current_dir(self.0.path()).args(line.split(' '));
        command.output().unwrap()
    }

    fn all(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        let files = paths.filter(|path| path.is_file());
        files
            .map(|path| (path.clone(), fs::read(path).unwrap()))
            .collect()
    }
}

/// What a command reads, and its options that name an output.
const COMMANDS: [(&str, &str, &str); 8] = [
    (
        "fit a.urdf --data log.csv --prior prior.toml",
        "a.urdf log.csv log.toml prior.toml",
        "--out --urdf --report",
    ),
    (
        "fit a.part --prior prior.toml",
        "a.part prior.toml",
        "--out --urdf --report",
    ),
    (
        "diagnose a.urdf --data log.csv --prior prior.toml --servos servos.toml",
        "a.urdf log.csv log.toml prior.toml servos.toml",
        "--out --urdf --report --next --mcap",
    ),
    (
        "plan a.urdf --support foot --poses 3 --limits limits.csv --sole sole.csv --model \
         model.toml --prior prior.toml",
        "a.urdf limits.csv sole.csv model.toml prior.toml",
        "--out --report",
    ),
    (
        "simulate a.urdf --support foot --poses 3 --model model.toml",
        "a.urdf model.toml",
        "--out",
    ),
    (
        "predict a.urdf --data log.csv --model model.toml",
        "a.urdf log.csv log.toml model.toml",
        "--out",
    ),
    (
        "compare model.toml other.toml",
        "model.toml other.toml",
        "--report",
    ),
    (
        "compare log.csv other.csv --urdf a.urdf",
        "a.urdf log.csv log.toml other.csv",
        "--report",
    ),
];

#[test]
fn every_output_that_names_an_input_is_refused_and_the_input_stays() {
    let inputs = Inputs::new();
    #[cfg(unix)]
    for name in inputs.all().keys() {
        let name = name.file_name().unwrap().to_str().unwrap();
        std::os::unix::fs::symlink(name, inputs.path(&format!("link_to_{name}"))).unwrap();
    }
    let before = inputs.all();
    let mut tried = 0;
    for (command, read, outputs) in COMMANDS {
        for output in outputs.split(' ') {
            for input in read.split(' ') {
                // Logs tell their format by their end, so that only `.csv` gets so far.
                for spelled in [
                    input.to_string(),
                    format!("./{input}"),
                    format!("link_to_{input}"),
                ] {
                    if cfg!(not(unix)) && spelled.starts_with("link") {
                        continue;
                    }
                    let other = match output {
                        // A plan needs a file to write.
                        "--report" if command.starts_with("plan") => " --out free.csv",
                        _ => "",
                    };
                    let line = format!("{command} {output} {spelled}{other}");
                    refused(&inputs.run(&line), &["is read here"]);
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 100, "{tried}");
    assert!(inputs.all() == before, "a file changed, or came");
}

/// What a factor file was made from is not read with it, and no output all the same.
#[test]
fn the_robot_of_a_factor_file_stays() {
    let inputs = Inputs::new();
    let before = inputs.all();
    for spelled in ["a.urdf", "./a.urdf"] {
        let line = format!("fit a.part --urdf {spelled}");
        refused(
            &inputs.run(&line),
            &["a.urdf is read here as the robot of a factor file"],
        );
    }
    assert!(inputs.all() == before);
    stdout(&inputs.run("fit a.part --urdf b.urdf"));
}

#[test]
fn sidecars_are_outputs_too() {
    let inputs = Inputs::new();
    let before = inputs.all();
    // The sidecar of the new postures, and a model file.
    let diagnose = "diagnose a.urdf --data log.csv --out x.csv.toml --next x.csv";
    refused(&inputs.run(diagnose), &["two outputs"]);
    // A robot whose file has the name of a sidecar.
    fs::rename(inputs.path("model.toml"), inputs.path("log2.csv.toml")).unwrap();
    let simulate = "simulate a.urdf --support foot --poses 3 --model log2.csv.toml --out log2.csv";
    refused(&inputs.run(simulate), &["is read here"]);
    fs::rename(inputs.path("log2.csv.toml"), inputs.path("model.toml")).unwrap();
    // A model file where the next run would look for the log's sidecar.
    let fit = "fit a.urdf --data log.csv --out log.csv.toml";
    refused(&inputs.run(fit), &["sidecar"]);
    assert!(inputs.all() == before);
}

#[test]
fn generated_files_take_no_input_away() {
    let inputs = Inputs::new();
    fs::rename(inputs.path("servos.toml"), inputs.path("leg.c")).unwrap();
    fs::rename(inputs.path("a.urdf"), inputs.path("leg.h")).unwrap();
    let before = inputs.all();
    for read in ["--servos leg.c", "--scalar f32"] {
        let line = format!("generate leg.h --support foot --lang c --name leg --out . {read}");
        refused(&inputs.run(&line), &["is read here"]);
    }
    assert!(inputs.all() == before);
    let builder = sesc_codegen::Builder::new(inputs.path("leg.h")).support("foot");
    let builder = builder.name("leg").emit_rerun_if_changed(false);
    let built = builder
        .out_dir(inputs.path("out"))
        .c99(inputs.path(""))
        .emit();
    assert!(format!("{:?}", built.unwrap_err()).contains("is read here"));
    assert!(inputs.all() == before);
}

/// The options beside a URDF, whether they are there or would be read by the next command.
#[test]
fn options_of_a_robot_are_no_output() {
    let inputs = Inputs::new();
    for text in ["", "support = \"foot\"\n"] {
        let options = inputs.path("sesc.toml");
        match text {
            "" => drop(fs::remove_file(&options)),
            _ => fs::write(&options, text).unwrap(),
        }
        let before = inputs.all();
        for line in [
            "fit a.urdf --data log.csv --out sesc.toml",
            "fit a.urdf --data log.csv --urdf sesc.toml",
            "diagnose a.urdf --data log.csv --report sesc.toml",
            "simulate a.urdf --support foot --poses 3 --out sesc",
        ] {
            refused(
                &inputs.run(line),
                &["sesc.toml is read here as the options"],
            );
        }
        assert!(inputs.all() == before);
    }
}

#[test]
fn lists_of_a_fleet_are_no_output() {
    let inputs = Inputs::new();
    fs::write(inputs.path("list.txt"), "log.csv\n").unwrap();
    fs::write(inputs.path("manifest.csv"), "path,robot,day\nlog.csv,1,1\n").unwrap();
    let before = inputs.all();
    for line in [
        "fleet a.urdf --data manifest.csv --out manifest.csv",
        "fleet a.urdf --data list.txt --out f.csv --report list.txt",
        "fleet a.urdf --data list.txt --out f.csv --prior-out list.txt",
        "fleet a.urdf --data log.csv --out log.csv",
    ] {
        refused(&inputs.run(line), &["is read here"]);
    }
    assert!(inputs.all() == before);
    // The page of the robot `log`, in the folder of the fleet's.
    fs::create_dir(inputs.path("f")).unwrap();
    fs::write(inputs.path("f/log.html"), "mine").unwrap();
    let line = "fleet a.urdf --data log.csv --out f.csv --report f.html";
    refused(&inputs.run(line), &["f/log.html is there already"]);
    assert_eq!(
        fs::read_to_string(inputs.path("f/log.html")).unwrap(),
        "mine"
    );
    assert!(!inputs.path("f.csv").exists());
}

/// Files that a command did not read, and which are not what it writes.
#[test]
fn outputs_take_the_place_of_their_like_alone() {
    let inputs = Inputs::new();
    for (name, text) in [
        ("notes.toml", "remember = \"the milk\"\n"),
        (
            "thesis.html",
            "<!DOCTYPE html><html><body>my thesis</body></html>\n",
        ),
        ("page.urdf", "<html><body>robot</body></html>\n"),
        ("main.rs", "fn main() {}\n"),
        ("foot.stl", "solid foot\nendsolid foot\n"),
        ("table.csv", "a,b\n1,2\n"),
        ("mine.part", "a novel\n"),
        (
            "r.csv.toml",
            "support = \"foot\"\nreadings_per_pose = 100\n",
        ),
    ] {
        fs::write(inputs.path(name), text).unwrap();
    }
    fs::copy(inputs.path("log.csv"), inputs.path("precious.csv")).unwrap();
    // The header of a recording that ROS made.
    let recorded = b"\x89MCAP0\r\n\x01\x13\0\0\0\0\0\0\0\x04\0\0\0ros2\x07\0\0\0libmcap";
    fs::write(inputs.path("robot.mcap"), recorded).unwrap();
    stdout(&inputs.run("fit a.urdf --data log.csv --urdf b.urdf --out b.toml"));
    let plan = "plan a.urdf --support foot --poses 3 --cop-box 0.2 --candidates 50 --out";
    stdout(&inputs.run(&format!("{plan} poses.csv")));
    let before = inputs.all();
    let is_there = "is there already and is not";
    for (line, said) in [
        ("fit a.urdf --data log.csv --out notes.toml", is_there),
        ("fit a.urdf --data log.csv --out prior.toml", is_there),
        ("fit a.urdf --data log.csv --report thesis.html", is_there),
        ("fit a.urdf --data log.csv --urdf page.urdf", is_there),
        ("fit a.urdf --data log.csv --partial mine.part", is_there),
        (
            "diagnose a.urdf --data log.csv --next precious.csv",
            is_there,
        ),
        ("diagnose a.urdf --data log.csv --mcap robot.mcap", is_there),
        (&format!("{plan} precious.csv"), is_there),
        (&format!("{plan} free.csv --report thesis.html"), is_there),
        (
            "simulate a.urdf --support foot --poses 3 --out poses.csv",
            is_there,
        ),
        (
            "simulate a.urdf --support foot --poses 3 --out table.csv",
            is_there,
        ),
        // The sidecar of a recording.
        (
            "simulate a.urdf --support foot --poses 3 --out r.csv",
            is_there,
        ),
        (
            "simulate a.urdf --support foot --poses 3 --out notes",
            is_there,
        ),
        (
            "generate a.urdf --support foot --name main --out .",
            is_there,
        ),
        ("fleet a.urdf --data log.csv --out table.csv", is_there),
        (
            "fleet a.urdf --data log.csv --out f.csv --prior-out model.toml",
            is_there,
        ),
        ("demo --out thesis.html", is_there),
    ] {
        refused(&inputs.run(line), &[said]);
    }
    assert!(inputs.all() == before);
    // Empty files are nobody's, and what a command wrote it writes again.
    fs::write(inputs.path("empty.html"), "").unwrap();
    fs::write(inputs.path("empty.mcap"), "").unwrap();
    for line in [
        "fit a.urdf --data log.csv --out b.toml --urdf b.urdf --report empty.html",
        "fit a.urdf --data log.csv --out b.toml --urdf b.urdf --report empty.html",
        &format!("{plan} poses.csv --report empty.html"),
        "simulate a.urdf --support foot --poses 3 --out precious.csv",
    ] {
        stdout(&inputs.run(line));
    }
    #[cfg(feature = "mcap")]
    for _ in 0..2 {
        stdout(&inputs.run("diagnose a.urdf --data log.csv --mcap empty.mcap"));
        assert!(fs::read(inputs.path("empty.mcap")).unwrap().len() > 100);
    }
}

/// A shell that appends to a file hands it to the command as `/dev/stdout`.
#[cfg(target_os = "linux")]
#[test]
fn what_a_shell_redirects_to_is_no_file_to_replace() {
    let inputs = Inputs::new();
    let log = inputs.path("everything.txt");
    fs::write(&log, "so far\n").unwrap();
    for output in ["--out", "--urdf", "--report"] {
        let mut command = Command::new(program());
        command.current_dir(inputs.0.path());
        command.args(["fit", "a.urdf", "--data", "log.csv", output, "/dev/stdout"]);
        command.stdout(fs::File::options().append(true).open(&log).unwrap());
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains("/dev/stdout"));
    }
    assert_eq!(fs::read_to_string(&log).unwrap(), "so far\n");
    let demo = sesc(&["demo", "--out", "/dev/stdout"]);
    refused(&demo, &["/dev/stdout"]);
}

/// Standard input may be a file by a name.
#[cfg(target_os = "linux")]
#[test]
fn standard_input_is_read_here_too() {
    let inputs = Inputs::new();
    let urdf = inputs.path("a.urdf");
    let before = fs::read(&urdf).unwrap();
    let mut command = Command::new(program());
    command.args([
        "simulate",
        "-",
        "--support",
        "foot",
        "--poses",
        "3",
        "--out",
    ]);
    command.arg(&urdf).stdin(fs::File::open(&urdf).unwrap());
    refused(&command.output().unwrap(), &["is read here"]);
    assert_eq!(fs::read(Path::new(&urdf)).unwrap(), before);
}

/// Devices that never end are no settings.
#[cfg(target_os = "linux")]
#[test]
fn files_without_end_are_refused() {
    let inputs = Inputs::new();
    for line in [
        "fit a.urdf --data log.csv --prior /dev/zero",
        "diagnose a.urdf --data log.csv --servos /dev/zero",
        "generate a.urdf --support foot --lang c --out g --servos /dev/zero",
        "plan a.urdf --support foot --poses 3 --out p.csv --limits /dev/zero",
        "plan a.urdf --support foot --poses 3 --out p.csv --sole /dev/zero",
    ] {
        // A prior may hold the covariance of a fleet.
        let most = match line.contains("--prior") {
            true => "longer than 16 MiB",
            false => "longer than 4 MiB",
        };
        refused(&inputs.run(line), &["/dev/zero", most]);
    }
}
