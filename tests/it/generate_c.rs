//! `sesc generate --lang c` as its users meet it: files for every scalar, and
//! faults that exit with 2, name the remedy and leave nothing behind.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use sesc_model::Function;
use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc, stdout, write};

/// `sesc generate` of the OP2 in C with more arguments.
fn generate(out: &Path, more: &[&str]) -> Output {
    let (urdf, out) = (op2(), out.display().to_string());
    let usual = in_words(
        "generate @ --support r_sole --lang c --out @",
        &[&urdf, &out],
    );
    sesc(&[&usual[..], more].concat())
}

fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn every_scalar_becomes_a_header_and_a_source() {
    let folder = folder();
    let out = folder.path().join("new/fw");
    for (scalar, real, ticks) in [
        ("f64", "double", false),
        ("f32", "float", true),
        ("fixed32", "int32_t", true),
    ] {
        let output = generate(&out, &["--scalar", scalar, "--name", scalar]);
        let printed = stdout(&output);
        assert_eq!(printed.lines().count(), 2, "{printed}");
        let header = fs::read_to_string(out.join(format!("{scalar}.h"))).unwrap();
        let source = fs::read_to_string(out.join(format!("{scalar}.c"))).unwrap();
        assert!(header.contains(&format!("typedef {real} {scalar}_real;")));
        assert!(source.contains(&format!("\nint {scalar}_selftest(void)")));
        assert_eq!(
            header.contains(&format!("{scalar}_com_ticks(")),
            ticks,
            "{scalar}"
        );
    }
    assert_eq!(files(&out).len(), 6, "nothing but headers and sources");
    // The name of robot and support, and ticks only where they are wanted.
    stdout(&generate(&out, &["--scalar", "f32", "--ticks", "false"]));
    let header = fs::read_to_string(out.join("op2_r_sole.h")).unwrap();
    assert!(!header.contains("_ticks"));
    stdout(&generate(&out, &["--scalar", "f64", "--ticks", "true"]));
    let header = fs::read_to_string(out.join("op2_r_sole.h")).unwrap();
    assert!(header.contains("op2_r_sole_com_ticks("));
    // A second run finds nothing to do.
    let again = generate(&out, &["--scalar", "f64", "--ticks", "true"]);
    assert!(String::from_utf8_lossy(&again.stderr).contains("op2_r_sole.h is up to date"));
}

/// Only what is asked for, and `com`: every such package compiles without a warning and passes
/// its self-test.
#[test]
fn functions_that_are_not_asked_for_are_left_out() {
    let folder = folder();
    let out = folder.path().join("fw");
    for function in Function::ALL {
        let name = function.name();
        // Blanks beside commas belong to no name.
        let names = format!("{name}, {name} ");
        stdout(&generate(
            &out,
            &["--functions", &names, "--name", name, "--lanes", "4"],
        ));
        let header = fs::read_to_string(out.join(format!("{name}.h"))).unwrap();
        for other in Function::ALL {
            let declared = header.contains(&format!("{name}_{}(", other.name()));
            let many = header.contains(&format!("{name}_{}_batch(", other.name()));
            let asked = other == function || other == Function::Com;
            assert_eq!([declared, many], [asked; 2], "{} of {name}", other.name());
        }
        let (main, program) = (out.join("main.c"), out.join("program"));
        let call =
            format!("#include \"{name}.h\"\nint main(void) {{ return {name}_selftest(); }}\n");
        fs::write(&main, call).unwrap();
        let mut gcc = Command::new("cc");
        gcc.args(["-Wall", "-Wextra", "-Werror", "-Wno-psabi", "-O0"]);
        gcc.arg(&main).arg(out.join(format!("{name}.c")));
        let built = gcc.arg("-o").arg(&program).output();
        stdout(&built.expect("a C compiler as cc"));
        stdout(&Command::new(&program).output().unwrap());
    }
    let refused = |more: &[&str], words: &[&str]| {
        let nowhere = folder.path().join("nowhere");
        refused(&generate(&nowhere, more), words);
        assert!(!nowhere.exists());
    };
    let known = [
        "there is no function `zpm`",
        "com_jacobian",
        "zmp",
        "correct_cop",
    ];
    refused(&["--functions", "com,zpm"], &known);
    let rows = ["the estimator calls regressor_cop", "name it"];
    refused(&["--functions", "com", "--estimator"], &rows);
}

#[test]
fn bad_usage_is_refused_and_nothing_is_written() {
    let folder = folder();
    let out = folder.path().join("out");
    refused(&generate(&out, &["--scalar", "f16"]), &["f16", "fixed32"]);
    // A name that is no prefix of C names: the one offered serves.
    for (bad, good) in [
        ("2fast", "robot_2fast"),
        ("my-robot", "my_robot"),
        ("a__b", "a_b"),
        ("_x", "x"),
        ("bein\u{e9}", "beinue9"),
    ] {
        refused(
            &generate(&out, &["--name", bad]),
            &[bad, &format!("`{good}`")],
        );
        assert!(!out.exists(), "{bad}");
        let elsewhere = folder.path().join("good");
        stdout(&generate(&elsewhere, &["--name", good]));
        assert_eq!(
            files(&elsewhere),
            [format!("{good}.c"), format!("{good}.h")]
        );
        fs::remove_dir_all(elsewhere).unwrap();
    }
    let urdf = op2();
    let directory = out.display().to_string();
    let rust = in_words(
        "generate @ --support r_sole --scalar fixed32 --out @",
        &[&urdf, &directory],
    );
    refused(&sesc(&rust), &["--lang c"]);
    let both = ["--ticks", "false", "--servos", "servos.toml"];
    refused(&generate(&out, &both), &["--servos", "--ticks false"]);
    assert!(!out.exists());
}

#[test]
fn folders_that_cannot_be_written_are_named() {
    let folder = folder();
    let file = write(folder.path(), "file", "not a folder");
    refused(
        &generate(&Path::new(&file).join("fw"), &[]),
        &["cannot write", "file/fw/op2_r_sole.h"],
    );
    // Where the source cannot be written, no stray part of it stays.
    let out = folder.path().join("out");
    fs::create_dir_all(out.join("op2_r_sole.c")).unwrap();
    refused(&generate(&out, &[]), &["cannot write", "op2_r_sole.c"]);
    assert_eq!(files(&out), ["op2_r_sole.c"]);
}

/// A follower that goes ten million times as far as its master.
#[test]
fn ranges_that_32_bits_do_not_hold_are_named_with_the_robots_size() {
    let folder = folder();
    let robot = |kind: &str, factor: &str| {
        let joint = |name: &str, parent: &str, child: &str, mimic: &str| {
            format!(
                "<link name='{child}'><inertial><origin xyz='0.1 0.2 0.3'/><mass value='1'/>\
                 </inertial></link><joint name='{name}' type='{kind}'><parent link='{parent}'/>\
                 <child link='{child}'/><axis xyz='1 0 0'/><limit lower='-900' upper='900'/>\
                 {mimic}</joint>"
            )
        };
        let follower = format!("<mimic joint='rail' multiplier='{factor}'/>");
        let joints = joint("rail", "base", "arm", "") + &joint("far", "arm", "hand", &follower);
        format!("<robot name='long'><link name='base'/>{joints}</robot>")
    };
    let out = folder.path().join("out");
    let run = |urdf: &str, scalar: &str| {
        let out = out.display().to_string();
        sesc(&in_words(
            "generate @ --support base --lang c --scalar @ --out @",
            &[urdf, scalar, &out],
        ))
    };
    let prismatic = write(folder.path(), "prismatic.urdf", robot("prismatic", "1e7"));
    refused(
        &run(&prismatic, "fixed32"),
        &["fixed32", "of com", "4.500e9", "the robot reaches", "f32"],
    );
    let revolute = write(folder.path(), "revolute.urdf", robot("revolute", "50"));
    refused(
        &run(&revolute, "fixed32"),
        &["far", "4.500e4", "16 bits", "the robot reaches"],
    );
    // Sines are computed for angles up to 1024 rad in f32.
    refused(&run(&revolute, "f32"), &["com", "1024 rad", "joint limits"]);
    assert!(!out.exists());
    stdout(&run(&revolute, "f64"));
}

#[test]
fn servo_files_with_faults_are_refused() {
    let folder = folder();
    let out = folder.path().join("out");
    let cases: [(&str, &str, &[&str]); 10] = [
        (
            "unknown_joint",
            "[joints.r_kne]\nzero = 1\n",
            &["`r_kne`", "r_knee"],
        ),
        (
            "no_sign",
            "[joints.r_knee]\nsign = 0\n",
            &["r_knee", "sign is 0", "1 or -1"],
        ),
        (
            "sign_two",
            "[default]\nsign = 2\n",
            &["sign is 2", "1 or -1"],
        ),
        (
            "no_resolution",
            "[default]\nresolution = 0\n",
            &["resolution is 0", "ticks a turn"],
        ),
        (
            "nan",
            "[default]\nresolution = nan\n",
            &["resolution is NaN", "ticks a turn"],
        ),
        (
            "endless",
            "[default]\nresolution = inf\n",
            &["resolution is inf"],
        ),
        (
            "unknown_key",
            "[default]\nzeros = 1\n",
            &["unknown_key.toml", "zeros", "zero"],
        ),
        (
            "unknown_table",
            "[joint.r_knee]\nzero = 1\n",
            &["unknown_table.toml", "joint", "joints"],
        ),
        (
            "huge_zero",
            "[default]\nzero = 99999999\n",
            &["zero is 99999999"],
        ),
        ("no_toml", "zero: 1\n", &["no_toml.toml"]),
    ];
    for scalar in ["f32", "fixed32"] {
        for (name, text, words) in cases {
            let file = write(folder.path(), &format!("{name}.toml"), text);
            refused(
                &generate(&out, &["--scalar", scalar, "--servos", &file]),
                words,
            );
        }
        refused(
            &generate(&out, &["--scalar", scalar, "--servos", "gone.toml"]),
            &["gone.toml"],
        );
    }
    assert!(!out.exists(), "nothing was written");
    // Prismatic joints: metres a tick, above zero; without, a note and no functions of ticks.
    let urdf = format!("{ROOT}/robots/lift_base/lift_base.urdf");
    let lift = |servos: &[&str]| {
        let out = out.display().to_string();
        let usual = in_words(
            "generate @ --support base_link --lang c --scalar f32",
            &[&urdf],
        );
        sesc(&[&usual[..], &["--name", "lift", "--out", &out], servos].concat())
    };
    let zero = write(
        folder.path(),
        "zero.toml",
        "[default]\nmetres_per_tick = 0.0\n",
    );
    refused(
        &lift(&["--servos", &zero]),
        &["metres_per_tick is 0", "above zero"],
    );
    let output = lift(&[]);
    stdout(&output);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("metres_per_tick") && message.contains("servo file"),
        "{message}"
    );
    assert!(
        !fs::read_to_string(out.join("lift.h"))
            .unwrap()
            .contains("_ticks")
    );
    let good = write(
        folder.path(),
        "good.toml",
        "[default]\nmetres_per_tick = 1e-5\n",
    );
    stdout(&lift(&["--servos", &good]));
    assert!(
        fs::read_to_string(out.join("lift.h"))
            .unwrap()
            .contains("lift_com_ticks(")
    );
}

#[test]
fn lanes_are_for_c_in_floats_and_4_8_or_16() {
    let folder = folder();
    let out = folder.path().join("fw");
    refused(
        &generate(&out, &["--lanes", "5"]),
        &["--lanes", "4, 8 or 16"],
    );
    let fixed = generate(&out, &["--lanes", "8", "--scalar", "fixed32"]);
    refused(&fixed, &["--lanes is for f64 and f32"]);
    let (urdf, to) = (op2(), out.display().to_string());
    let rust = in_words(
        "generate @ --support r_sole --lanes 8 --out @",
        &[&urdf, &to],
    );
    refused(&sesc(&rust), &["--lanes is for C; add --lang c"]);
    assert!(!out.exists());
    stdout(&generate(&out, &["--lanes", "8", "--name", "op2"]));
    let header = fs::read_to_string(out.join("op2.h")).unwrap();
    let one_line = header.split_whitespace().collect::<Vec<_>>().join(" ");
    let declared =
        "void op2_com_batch(size_t n, const op2_real q[], const op2_real r[], op2_real com[]);";
    assert!(one_line.contains(declared), "{header}");
    for function in Function::ALL.map(Function::name) {
        assert!(
            one_line.contains(&format!("void op2_{function}_batch( size_t n, "))
                || one_line.contains(&format!("void op2_{function}_batch(size_t n, ")),
            "{function}"
        );
        assert!(
            header.contains(&format!("\n * {function}_batch ")),
            "{function}"
        );
    }
    assert!(one_line.contains("joint j of posture i") && one_line.contains("no alignment"));
}
