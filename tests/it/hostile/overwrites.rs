//! No output takes the place of an input, however the two are spelled.

use std::fs;

use sesc_test_support::command::{Folder, refused, sesc, stderr};
use sesc_test_support::kills;

/// A folder with everything that a command may read.
fn inputs() -> Folder {
    let inputs = kills::inputs();
    // The older name of a sidecar, which `fit` reads as long as there is no other.
    fs::rename(inputs.join("log.csv.toml"), inputs.join("log.toml")).unwrap();
    inputs.stdout("fit a.urdf --data log.csv --partial a.part");
    for (from, to) in [("model.toml", "other.toml"), ("log.csv", "other.csv")] {
        fs::copy(inputs.join(from), inputs.join(to)).unwrap();
    }
    for (name, text) in [
        ("prior.toml", "[default]\nmass = 0.1\ncom = 0.005\n"),
        ("servos.toml", "[default]\nzero = 2048\n"),
        ("limits.csv", "joint,lower_deg,upper_deg\nknee,-40,40\n"),
        ("sole.csv", "0.1,0.1\n-0.1,0.1\n-0.1,-0.1\n0.1,-0.1\n"),
    ] {
        inputs.write(name, text);
    }
    inputs
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
        "--out --urdf --report --next",
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
    let inputs = inputs();
    #[cfg(unix)]
    for name in inputs.names() {
        std::os::unix::fs::symlink(&name, inputs.join(&format!("link_to_{name}"))).unwrap();
    }
    let before = inputs.files();
    let mut tried = 0;
    for (command, read, outputs) in COMMANDS {
        for output in outputs.split(' ') {
            for input in read.split(' ') {
                // A plan needs a file to write.
                let other = match output {
                    "--report" if command.starts_with("plan") => "--out free.csv",
                    _ => "",
                };
                // Logs tell their format by their end, so that only `.csv` gets so far.
                let spelled = ["", "./", "link_to_"].map(|before| format!("{before}{input}"));
                for spelled in &spelled[..if cfg!(unix) { 3 } else { 2 }] {
                    let line = format!("{command} {output} {spelled} {other}");
                    inputs.refuses(&line, &["is read here"]);
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 100, "{tried}");
    assert!(inputs.files() == before, "a file changed, or came");
}

/// Refuses each command of a table, and no file changes or comes.
fn refuses_each(inputs: &Folder, table: &str) {
    let before = inputs.files();
    inputs.refuses_each(table);
    assert!(inputs.files() == before, "a file changed, or came");
}

/// What a factor file was made from is not read with it, and no output all the same; the next
/// command reads model files and sidecars.
#[test]
fn what_is_read_by_another_command_is_no_output() {
    let inputs = inputs();
    refuses_each(
        &inputs,
        "fit a.part --urdf a.urdf   | a.urdf is read here as the robot of a factor file
         fit a.part --urdf ./a.urdf | a.urdf is read here as the robot of a factor file
         diagnose a.urdf --data log.csv --out x.csv.toml --next x.csv | two outputs
         fit a.urdf --data log.csv --out log.csv.toml                 | sidecar",
    );
    inputs.stdout("fit a.part --urdf b.urdf");
    // A robot whose file has the name of a sidecar.
    fs::rename(inputs.join("model.toml"), inputs.join("log2.csv.toml")).unwrap();
    let simulate = "simulate a.urdf --support foot --poses 3 --model log2.csv.toml --out log2.csv";
    refuses_each(&inputs, &format!("{simulate} | is read here"));
}

#[test]
fn generated_files_take_no_input_away() {
    let inputs = inputs();
    fs::rename(inputs.join("servos.toml"), inputs.join("leg.c")).unwrap();
    fs::rename(inputs.join("a.urdf"), inputs.join("leg.h")).unwrap();
    let before = inputs.files();
    refuses_each(
        &inputs,
        "generate leg.h --support foot --lang c --name leg --out . --servos leg.c | is read here
         generate leg.h --support foot --lang c --name leg --out . --scalar f32   | is read here",
    );
    let builder = sesc_codegen::Builder::new(inputs.join("leg.h")).support("foot");
    let builder = builder.name("leg").emit_rerun_if_changed(false);
    let builder = builder.out_dir(inputs.join("out")).c99(inputs.path());
    let refused = builder.emit().unwrap_err();
    assert!(format!("{refused:?}").contains("is read here"));
    assert!(inputs.files() == before);
}

/// The options beside a URDF, whether they are there or would be read by the next command.
#[test]
fn options_of_a_robot_are_no_output() {
    let inputs = inputs();
    for there in [false, true] {
        if there {
            inputs.write("sesc.toml", "support = \"foot\"\n");
        }
        refuses_each(
            &inputs,
            "fit a.urdf --data log.csv --out sesc.toml | sesc.toml is read here as the options
             fit a.urdf --data log.csv --urdf sesc.toml | sesc.toml is read here as the options
             diagnose a.urdf --data log.csv --report sesc.toml | is read here as the options
             simulate a.urdf --support foot --poses 3 --out sesc | is read here as the options",
        );
    }
}

#[test]
fn lists_of_a_fleet_are_no_output() {
    let inputs = inputs();
    inputs.write("list.txt", "log.csv\n");
    inputs.write("manifest.csv", "path,robot,day\nlog.csv,1,1\n");
    // The page of the robot `log`, in the folder of the fleet's.
    inputs.write("f/log.html", "mine");
    refuses_each(
        &inputs,
        "fleet a.urdf --data manifest.csv --out manifest.csv               | is read here
         fleet a.urdf --data list.txt --out f.csv --report list.txt        | is read here
         fleet a.urdf --data list.txt --out f.csv --prior-out list.txt     | is read here
         fleet a.urdf --data log.csv --out log.csv                         | is read here
         fleet a.urdf --data log.csv --out f.csv --report f.html | f/log.html is there already",
    );
}

/// Files that a command did not read, and which are not what it writes.
#[test]
fn outputs_take_the_place_of_their_like_alone() {
    let inputs = inputs();
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
        inputs.write(name, text);
    }
    fs::copy(inputs.join("log.csv"), inputs.join("precious.csv")).unwrap();
    inputs.stdout("fit a.urdf --data log.csv --urdf b.urdf --out b.toml");
    let plan = "plan a.urdf --support foot --poses 3 --cop-box 0.2 --candidates 50 --out";
    inputs.stdout(&format!("{plan} poses.csv"));
    // `r.csv.toml` is the sidecar of a recording.
    refuses_each(
        &inputs,
        "fit a.urdf --data log.csv --out notes.toml             | is there already and is not
         fit a.urdf --data log.csv --out prior.toml             | is there already and is not
         fit a.urdf --data log.csv --report thesis.html         | is there already and is not
         fit a.urdf --data log.csv --urdf page.urdf             | is there already and is not
         fit a.urdf --data log.csv --partial mine.part          | is there already and is not
         diagnose a.urdf --data log.csv --next precious.csv     | is there already and is not
         plan a.urdf --support foot --poses 3 --cop-box 0.2 --out precious.csv | is there already
         plan a.urdf --support foot --poses 3 --cop-box 0.2 --out free.csv --report thesis.html
            | is there already and is not
         simulate a.urdf --support foot --poses 3 --out poses.csv | is there already and is not
         simulate a.urdf --support foot --poses 3 --out table.csv | is there already and is not
         simulate a.urdf --support foot --poses 3 --out r.csv     | is there already and is not
         simulate a.urdf --support foot --poses 3 --out notes     | is there already and is not
         generate a.urdf --support foot --name main --out .       | is there already and is not
         fleet a.urdf --data log.csv --out table.csv              | is there already and is not
         fleet a.urdf --data log.csv --out f.csv --prior-out model.toml
            | is there already and is not
         demo --out thesis.html                                   | is there already and is not",
    );
    // Empty files are nobody's, and what a command wrote it writes again.
    inputs.write("empty.html", "");
    for line in [
        "fit a.urdf --data log.csv --out b.toml --urdf b.urdf --report empty.html",
        "fit a.urdf --data log.csv --out b.toml --urdf b.urdf --report empty.html",
        &format!("{plan} poses.csv --report empty.html"),
        "simulate a.urdf --support foot --poses 3 --out precious.csv",
    ] {
        inputs.stdout(line);
    }
}

/// A shell that appends to a file hands it to the command as `/dev/stdout`; standard input may be a
/// file by a name.
#[cfg(target_os = "linux")]
#[test]
fn files_of_the_shell_are_no_file_to_replace() {
    let inputs = inputs();
    inputs.write("everything.txt", "so far\n");
    let before = inputs.files();
    for output in ["--out", "--urdf", "--report"] {
        let line = format!("fit a.urdf --data log.csv {output} /dev/stdout");
        let everything = fs::File::options()
            .append(true)
            .open(inputs.join("everything.txt"));
        let output = inputs.command(&line).stdout(everything.unwrap()).output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("/dev/stdout"));
    }
    refused(&sesc(&["demo", "--out", "/dev/stdout"]), &["/dev/stdout"]);
    let mut command = inputs.command("simulate - --support foot --poses 3 --out a.urdf");
    command.stdin(fs::File::open(inputs.join("a.urdf")).unwrap());
    refused(&command.output().unwrap(), &["is read here"]);
    assert!(inputs.files() == before);
}

/// Devices that never end are no settings; a prior may hold the covariance of a fleet.
#[cfg(target_os = "linux")]
#[test]
fn files_without_end_are_refused() {
    inputs().refuses_each(
        "fit a.urdf --data log.csv --prior /dev/zero | /dev/zero | longer than 16 MiB
         diagnose a.urdf --data log.csv --servos /dev/zero | /dev/zero | longer than 4 MiB
         generate a.urdf --support foot --lang c --out g --servos /dev/zero | longer than 4 MiB
         plan a.urdf --support foot --poses 3 --out p.csv --limits /dev/zero | longer than 4 MiB
         plan a.urdf --support foot --poses 3 --out p.csv --sole /dev/zero | longer than 4 MiB",
    );
}
