//! Symbols of the C packages: no two alike.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::user::*;
use sesc_test_support::command::{Folder, ROOT, op2, write};

/// Headers of `generated/c`, by name.
fn shipped() -> Vec<String> {
    let stem = |path: PathBuf| path.file_stem().unwrap().to_str().unwrap().to_string();
    let entries = fs::read_dir(format!("{ROOT}/generated/c")).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let headers = paths.filter(|path| path.extension().is_some_and(|end| end == "h"));
    let mut names: Vec<String> = headers.map(stem).collect();
    names.sort();
    names
}

/// A controller with the robot in f32 and in fixed32 links both and calls both.
#[test]
fn shipped_c_packages_link_together() {
    let names = shipped();
    assert!(names.len() >= 2, "{names:?}");
    let folder = fresh("together");
    let mut main = String::new();
    for name in &names {
        main += &format!("#include \"{name}.h\"\n");
    }
    // Fixed point beside float, in the same posture of ticks.
    main += "#include <math.h>\n#include <stdio.h>\n\nint main(void)\n{\n    int failed = 0;\n";
    for name in &names {
        main += &format!("    failed |= {name}_selftest();\n");
    }
    main += "\
    int32_t ticks[op2_r_sole_DOF];
    static float rows[3 * op2_r_sole_FULL_PARAMS];
    static int32_t fixed_rows[3 * op2_r_sole_fixed_FULL_PARAMS];
    const double unit = 1.0 / (double)(1 << op2_r_sole_fixed_REGRESSOR_COP_FRACTION_BITS);
    for (int k = 0; k < op2_r_sole_DOF; k += 1) {
        ticks[k] = 2048 + 37 * k;
    }
    op2_r_sole_regressor_cop_ticks(ticks, rows);
    op2_r_sole_fixed_regressor_cop_ticks(ticks, fixed_rows);
    for (int k = 0; k < 2 * op2_r_sole_BASE_PARAMS; k += 1) {
        if (fabs((double)rows[k] - fixed_rows[k] * unit) > 1e-6) {
            printf(\"entry %d: %g %g\\n\", k, (double)rows[k], fixed_rows[k] * unit);
            failed = 1;
        }
    }
    return failed;
}
";
    let include = PathBuf::from(format!("{ROOT}/generated/c"));
    let main = write(&folder, "main.c", main);
    let object = folder.join("main.o");
    compile_c(Path::new(&main), &include, &object);
    let binary = folder.join("together");
    let sources = names.iter().map(|name| include.join(format!("{name}.c")));
    run(Command::new("cc")
        .args(["-std=c99", "-O1"])
        .arg(&object)
        .args(sources)
        .args(["-lm", "-o"])
        .arg(&binary));
    run(&mut Command::new(binary));
}

/// Prefixes are whole names of robot and support: two supports of a robot with a long name have
/// files and symbols of their own.
#[test]
fn two_supports_of_a_robot_with_a_long_name_link_together() {
    let folder = fresh("long_name");
    let robot = "unitree_g1_29dof_with_dex3_hands";
    let text = fs::read_to_string(op2()).unwrap();
    let name = format!("<robot name=\"{robot}\"");
    let renamed = text.replacen("<robot name=\"op2\"", &name, 1);
    assert_ne!(text, renamed);
    let urdf = write(&folder, "robot.urdf", renamed);
    let q: Vec<f64> = posture().into_iter().map(f64::from).collect();
    let values: Vec<String> = q.iter().map(|q| format!("{q:?}")).collect();
    let (mut includes, mut calls) = (String::new(), String::new());
    let (mut sources, mut expected) = (Vec::new(), Vec::new());
    for support in ["r_sole", "l_sole"] {
        let name = format!("{robot}_{support}");
        let files = generate(&folder, &urdf, support, &[]);
        let ends = ["h", "c"].map(|end| folder.join(format!("{name}.{end}")));
        assert_eq!(files, ends);
        let [_, source] = ends;
        sources.push(source);
        includes += &format!("#include \"{name}.h\"\n");
        calls += &format!(
            "    {name}_com(q, {name}_cad_params, com);\n    \
             printf(\"%.9g %.9g %.9g\\n\", com[0], com[1], com[2]);\n    \
             failed |= {name}_selftest();\n"
        );
        let robot = sesc_reference::Robot::from_file(&urdf).unwrap();
        let reference = sesc_reference::Reference::new(&robot, support).unwrap();
        expected.push(reference.com(&q).into());
    }
    let main = format!(
        "{includes}#include <stdio.h>\n\nint main(void)\n{{\n    \
         const double q[] = {{{}}};\n    double com[3];\n    int failed = 0;\n{calls}    \
         return failed;\n}}\n",
        values.join(", ")
    );
    let main = PathBuf::from(write(&folder, "main.c", main));
    let (object, binary) = (folder.join("main.o"), folder.join("both"));
    compile_c(&main, &folder, &object);
    run(Command::new("cc")
        .args(["-std=c99", "-O1"])
        .args(&sources)
        .arg(&object)
        .args(["-lm", "-o"])
        .arg(&binary));
    let printed = run(&mut Command::new(binary));
    assert_ne!(expected[0], expected[1]);
    assert_eq!(printed.lines().count(), 2);
    for (line, com) in printed.lines().zip(expected) {
        near(line, com, 1e-8);
    }
}

/// A name that is too long for a file is refused, in both languages: it is not cut.
#[test]
fn names_too_long_for_files_are_refused() {
    let folder = Folder::with("op2");
    let (most, robot) = ("n".repeat(100), "n".repeat(95));
    let renamed = format!("<robot name=\"{robot}\"");
    let text = folder.read("op2.urdf");
    let text = text.replacen("<robot name=\"op2\"", &renamed, 1);
    folder.write("op2.urdf", text);
    for lang in ["rust", "c"] {
        let usual = format!("generate op2.urdf --support r_sole --lang {lang} --out out");
        // Robot, `_` and support are 102 characters.
        let name = format!("{robot}_r_sole");
        folder.refuses(&usual, &[&name, "102 characters", "100", "give a name"]);
        let longer = format!("{usual} --name {most}n");
        folder.refuses(&longer, &["101 characters", &format!("`{most}`")]);
        assert!(!folder.join("out").exists(), "{lang}");
        folder.stdout(&format!("{usual} --name {most}"));
        fs::remove_dir_all(folder.join("out")).unwrap();
    }
}
