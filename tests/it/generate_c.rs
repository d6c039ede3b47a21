//! `sesc generate --lang c` as its users meet it: files for every scalar, and
//! faults that exit with 2, name the remedy and leave nothing behind.

use std::fs;
use std::process::{Command, Output};

use sesc_model::Function;
use sesc_test_support::command::{Folder, printed, refused, rows, says, stderr, stdout};
use sesc_test_support::trees::Urdf;

/// `sesc generate` of the OP2 in C, into `fw`, with more arguments.
fn generate(folder: &Folder, more: &str) -> Output {
    folder.run(&format!(
        "generate op2.urdf --support r_sole --lang c --out fw {more}"
    ))
}

/// Refuses each row of a table of arguments and words, and nothing is written.
fn refuses_each(folder: &Folder, table: &str) {
    for row in rows(table) {
        let cells: Vec<&str> = row.iter().map(String::as_str).collect();
        refused(&generate(folder, cells[0]), &cells[1..]);
        assert!(!folder.join("fw").exists(), "{row:?}");
    }
}

/// Names of what was written.
fn written(folder: &Folder) -> Vec<String> {
    let entries = fs::read_dir(folder.join("fw")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn every_scalar_becomes_a_header_and_a_source() {
    let folder = Folder::with("op2");
    for (scalar, real, ticks) in [
        ("f64", "double", false),
        ("f32", "float", true),
        ("fixed32", "int32_t", true),
    ] {
        let output = generate(&folder, &format!("--scalar {scalar} --name {scalar}"));
        assert_eq!(stdout(&output).lines().count(), 2);
        let header = folder.read(&format!("fw/{scalar}.h"));
        let source = folder.read(&format!("fw/{scalar}.c"));
        assert!(header.contains(&format!("typedef {real} {scalar}_real;")));
        assert!(source.contains(&format!("\nint {scalar}_selftest(void)")));
        let declared = header.contains(&format!("{scalar}_com_ticks("));
        assert_eq!(declared, ticks, "{scalar}");
    }
    assert_eq!(written(&folder).len(), 6, "nothing but headers and sources");
    // The name of robot and support, and ticks only where they are wanted.
    stdout(&generate(&folder, "--scalar f32 --ticks false"));
    assert!(!folder.read("fw/op2_r_sole.h").contains("_ticks"));
    stdout(&generate(&folder, "--scalar f64 --ticks true"));
    let header = folder.read("fw/op2_r_sole.h");
    assert!(header.contains("op2_r_sole_com_ticks("));
    // A second run finds nothing to do.
    let again = stderr(&generate(&folder, "--scalar f64 --ticks true"));
    assert!(again.contains("op2_r_sole.h is up to date"), "{again}");
}

/// Only what is asked for, and `com`: every such package compiles without a warning and passes
/// its self-test.
#[test]
fn functions_that_are_not_asked_for_are_left_out() {
    let folder = Folder::with("op2");
    refuses_each(
        &folder,
        "--functions com,zpm | there is no function `zpm` | com_jacobian | zmp | correct_cop
         --functions com --estimator | the estimator calls regressor_cop | name it",
    );
    for function in Function::ALL {
        let name = function.name();
        // Blanks beside commas belong to no name.
        let mut command = folder.command("generate op2.urdf --support r_sole --lang c --out fw");
        command.args(["--functions", &format!("{name}, {name} ")]);
        printed(command.args(["--name", name, "--lanes", "4"]));
        let header = folder.read(&format!("fw/{name}.h"));
        for other in Function::ALL {
            let declared = header.contains(&format!("{name}_{}(", other.name()));
            let many = header.contains(&format!("{name}_{}_batch(", other.name()));
            let asked = other == function || other == Function::Com;
            assert_eq!([declared, many], [asked; 2], "{} of {name}", other.name());
        }
        let main =
            format!("#include \"{name}.h\"\nint main(void) {{ return {name}_selftest(); }}\n");
        folder.write("fw/main.c", main);
        let mut cc = Command::new("cc");
        let flags = "-Wall -Wextra -Werror -Wno-psabi -O0 fw/main.c";
        cc.args(flags.split(' '));
        cc.args([&format!("fw/{name}.c"), "-o", "program"]);
        printed(cc.current_dir(folder.path()));
        printed(&mut Command::new(folder.join("program")));
    }
}

#[test]
fn bad_usage_is_refused_and_nothing_is_written() {
    let folder = Folder::with("op2");
    refuses_each(
        &folder,
        "--scalar f16 | f16 | fixed32
         --ticks false --servos servos.toml | --servos | --ticks false
         --lanes 5 | --lanes | 4, 8 or 16
         --lanes 8 --scalar fixed32 | --lanes is for f64 and f32",
    );
    folder.refuses_each(
        "generate op2.urdf --support r_sole --scalar fixed32 --out fw | --lang c
         generate op2.urdf --support r_sole --lanes 8 --out fw | --lanes is for C; add --lang c",
    );
    // A name that is no prefix of C names: the one offered serves.
    for (bad, good) in [
        ("2fast", "robot_2fast"),
        ("my-robot", "my_robot"),
        ("a__b", "a_b"),
        ("_x", "x"),
        ("bein\u{e9}", "beinue9"),
    ] {
        refuses_each(&folder, &format!("--name {bad} | {bad} | `{good}`"));
        stdout(&generate(&folder, &format!("--name {good}")));
        assert_eq!(written(&folder), [format!("{good}.c"), format!("{good}.h")]);
        fs::remove_dir_all(folder.join("fw")).unwrap();
    }
}

#[test]
fn folders_that_cannot_be_written_are_named() {
    let folder = Folder::with("op2");
    // Where the source cannot be written, no stray part of it stays.
    fs::create_dir_all(folder.join("fw/op2_r_sole.c")).unwrap();
    refused(&generate(&folder, ""), &["cannot write", "op2_r_sole.c"]);
    assert_eq!(written(&folder), ["op2_r_sole.c"]);
    fs::remove_dir_all(folder.join("fw")).unwrap();
    folder.write("fw", "not a folder");
    refused(&generate(&folder, ""), &["cannot write", "fw/op2_r_sole.h"]);
}

/// A follower that goes ten million times as far as its master.
#[test]
fn ranges_that_32_bits_do_not_hold_are_named_with_the_robots_size() {
    let folder = Folder::empty();
    for (kind, factor) in [("prismatic", "1e7"), ("revolute", "50")] {
        let more = "<axis xyz='1 0 0'/><limit lower='-900' upper='900'/>";
        let follower = format!("{more}<mimic joint='rail' multiplier='{factor}'/>");
        let robot = Urdf::new("long").raw("<link name='base'/>");
        let robot =
            robot
                .link("arm", 1.0, "0.1 0.2 0.3")
                .joint("rail", kind, ["base", "arm"], more);
        let robot = robot.link("hand", 1.0, "0.1 0.2 0.3");
        let robot = robot.joint("far", kind, ["arm", "hand"], &follower).text();
        folder.write(&format!("{kind}.urdf"), robot);
    }
    // Sines are computed for angles up to 1024 rad in f32.
    folder.refuses_each(
        "generate prismatic.urdf --support base --lang c --scalar fixed32 --out out
            | fixed32 | of com | 4.500e9 | the robot reaches | f32
         generate revolute.urdf --support base --lang c --scalar fixed32 --out out
            | far | 4.500e4 | 16 bits | the robot reaches
         generate revolute.urdf --support base --lang c --scalar f32 --out out
            | com | 1024 rad | joint limits",
    );
    assert!(!folder.join("out").exists());
    folder.stdout("generate revolute.urdf --support base --lang c --scalar f64 --out out");
}

#[test]
fn servo_files_with_faults_are_refused() {
    let folder = Folder::with("op2");
    let faults = "[joints.r_kne]/zero = 1 | `r_kne` | r_knee
        [joints.r_knee]/sign = 0 | r_knee | sign is 0 | 1 or -1
        [default]/sign = 2 | sign is 2 | 1 or -1
        [default]/resolution = 0 | resolution is 0 | ticks a turn
        [default]/resolution = nan | resolution is NaN | ticks a turn
        [default]/resolution = inf | resolution is inf
        [default]/zeros = 1 | servos.toml | zeros | zero
        [joint.r_knee]/zero = 1 | servos.toml | joint | joints
        [default]/zero = 99999999 | zero is 99999999
        zero: 1 | servos.toml";
    for row in rows(faults) {
        folder.write("servos.toml", row[0].replace('/', "\n"));
        for scalar in ["f32", "fixed32"] {
            let words = row[1..].join(" | ");
            let row = format!("--scalar {scalar} --servos servos.toml | {words}");
            refuses_each(&folder, &row);
        }
    }
    refuses_each(&folder, "--servos gone.toml | gone.toml");
    // Prismatic joints: metres a tick, above zero; without, a note and no functions of ticks.
    let folder = Folder::with("lift_base");
    let lift =
        "generate lift_base.urdf --support base_link --lang c --scalar f32 --name lift --out .";
    folder.write("servos.toml", "[default]\nmetres_per_tick = 0.0\n");
    let servos = format!("{lift} --servos servos.toml");
    folder.refuses(&servos, &["metres_per_tick is 0", "above zero"]);
    says(folder.said(lift), &["metres_per_tick", "servo file"]);
    assert!(!folder.read("lift.h").contains("_ticks"));
    folder.write("servos.toml", "[default]\nmetres_per_tick = 1e-5\n");
    folder.stdout(&servos);
    assert!(folder.read("lift.h").contains("lift_com_ticks("));
}

#[test]
fn lanes_declare_every_function_of_many_postures() {
    let folder = Folder::with("op2");
    stdout(&generate(&folder, "--lanes 8 --name op2"));
    let header = folder.read("fw/op2.h");
    let one_line = header.split_whitespace().collect::<Vec<_>>().join(" ");
    let declared =
        "void op2_com_batch(size_t n, const op2_real q[], const op2_real r[], op2_real com[]);";
    assert!(one_line.contains(declared), "{header}");
    let declarations = one_line.replace("( ", "(");
    for function in Function::ALL.map(Function::name) {
        let declared = format!("void op2_{function}_batch(size_t n, ");
        assert!(declarations.contains(&declared), "{function}");
        let row = format!("\n * {function}_batch ");
        assert!(header.contains(&row), "{function}");
    }
    assert!(one_line.contains("joint j of posture i") && one_line.contains("no alignment"));
}
