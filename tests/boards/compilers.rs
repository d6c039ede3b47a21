//! Generated C by compilers that not everybody has: C++, clang's registers, sanitizers, NEON, ARM.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use sesc_codegen::emit::c::Scalar;
use sesc_reference::{Reference, Robot};

use crate::c99::case::{Case, ROOT, few, jobs};
use crate::c99::compiled::{WARNINGS, folder, parallel, printed as run, tool, write};
use crate::c99::fixed::without_comments;
use crate::c99::lanes::{cases, sum};

#[test]
fn the_header_compiles_alone_and_as_cplusplus() {
    let folder = folder("cplusplus");
    let cases = few();
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let (name, dof) = (&case.name, case.model.dof());
        let package = case.package(scalar);
        let source = write(&folder, name, &package);
        // The header first and alone, then twice.
        let include = format!("#include \"{name}.h\"\n");
        let mut calls = String::new();
        for entry in case.entries(scalar) {
            let arguments = entry.arguments();
            let _ = writeln!(calls, "    {name}_{}({arguments}, out);", entry.name);
        }
        let text = format!(
            "{include}{include}#include <cstdint>\nint main()\n{{\n    \
             const {name}_real q[{dof}] = {{}};\n    const std::int32_t ticks[{name}_DOF] = {{}};\n    \
             const {name}_real *const sines = q, *const cosines = q, *const qd = q;\n    \
             const {name}_real *const slow = q, *const qdd = q;\n    \
             const {name}_real *const r = {name}_cad_params;\n    \
             static {name}_real out[3 * {name}_FULL_PARAMS + 3 * {name}_DOF];\n    \
             (void)sines;\n    (void)cosines;\n    (void)qd;\n    (void)slow;\n    (void)qdd;\n    (void)r;\n    (void)ticks;\n{calls}    \
             return {name}_joint_names[0][0] == 0 ? 1 : {name}_selftest();\n}}\n"
        );
        let main = folder.join("main.cpp");
        fs::write(&main, text).unwrap();
        fs::write(
            folder.join("alone.c"),
            format!("{include}typedef {name}_real it;\n"),
        )
        .unwrap();
        let object = folder.join("object.o");
        {
            run(Command::new("gcc")
                .args(["-std=c99", "-O0", "-c"])
                .arg(source)
                .arg("-o")
                .arg(&object));
            for (c, cpp) in [("gcc", "g++"), ("clang", "clang++")] {
                let alone = folder.join("alone.c");
                run(Command::new(c)
                    .args(WARNINGS)
                    .arg("-fsyntax-only")
                    .arg(alone));
                let program = folder.join(cpp);
                let mut command = Command::new(cpp);
                command.args([
                    "-std=c++17",
                    "-O0",
                    "-Wall",
                    "-Wextra",
                    "-Wpedantic",
                    "-Werror",
                ]);
                run(command.arg(&main).arg(&object).arg("-o").arg(&program));
                run(&mut Command::new(&program));
            }
        }
    });
}

/// clang saves registers where they lie in two lines of the cache unless the stack is aligned.
#[cfg(target_arch = "x86_64")]
#[test]
fn clang_saves_registers_in_lines_of_the_cache() {
    let folder = folder("lanes_stack");
    let case = Case::robot("quadruped", "lf_foot").of_many(16);
    for scalar in [Scalar::F64, Scalar::F32] {
        let source = write(&folder, &case.name, &case.package(scalar));
        let command = ["clang", "-O3", "-mavx512f", "-mavx512dq", "-S", "-o", "-"];
        let saved = {
            let text = tool(Command::new(command[0]).args(&command[1..]).arg(&source));
            let text = String::from_utf8(text.unwrap()).unwrap();
            let (mut of_many, mut saved) = (false, String::new());
            for line in text.lines() {
                // Labels of functions begin with the prefix, other lines do not.
                if let Some((label, _)) = line.split_once(':')
                    && label.starts_with(&case.name)
                {
                    of_many = label.ends_with("_batch") || label.ends_with("_block");
                }
                if of_many && line.contains("64-byte Spill") {
                    let _ = writeln!(saved, "{line}");
                }
            }
            saved
        };
        assert!(saved.lines().count() > 10, "nothing is saved: {saved}");
        let aligned = |line: &&str| line.contains("vmova") || line.contains("vmovdqa");
        let astray: Vec<&str> = saved.lines().filter(|line| !aligned(line)).collect();
        assert_eq!(astray, [""; 0], "{scalar:?}");
    }
}

#[test]
fn sanitizers_find_nothing() {
    let folder = folder("lanes_sanitized");
    let checked = ["gcc", "-O1", "-g", "-fsanitize=address,undefined"];
    let checked = [&checked[..], &["-fno-sanitize-recover=all", "-DEXACT"]].concat();
    let mut cases = cases();
    cases.retain(|case| case.model.dof() < 6);
    parallel(cases.iter().collect(), |case| {
        for scalar in [Scalar::F64, Scalar::F32] {
            sum(&folder, case, scalar, &checked, &[]);
        }
    });
}

#[test]
fn neon_gives_the_same_bits() {
    let folder = folder("lanes_neon");
    let cases = cases();
    let cross = ["aarch64-linux-gnu-gcc", "-O2", "-static"];
    parallel(cases.iter().take(5).collect(), |case| {
        for scalar in [Scalar::F64, Scalar::F32] {
            let here = sum(&folder, case, scalar, &["gcc", "-O2"], &[]);
            let there = sum(&folder, case, scalar, &cross, &["qemu-aarch64"]);
            assert_eq!(here, there, "{} {scalar:?}", case.name);
        }
    });
}

/// C++ calls what the header declares.
#[test]
fn a_batch_is_within_its_bound_of_the_reference() {
    const POSTURES: usize = 27;
    let folder = folder("lanes_reference");
    for (robot, support) in [("quadruped", "lf_foot"), ("two_link", "foot")] {
        let case = Case::robot(robot, support).of_many(8);
        let (name, dof) = (&case.name, case.model.dof());
        let package = case.package(Scalar::F64);
        let source = write(&folder, name, &package);
        let posture = |i: usize| -> Vec<f64> {
            let dofs = case.model.tree.dofs.iter().enumerate();
            dofs.map(|(j, dof)| {
                let share = 0.5 + 0.5 * (0.7 * i as f64 + 1.9 * j as f64).sin();
                dof.lower + share * (dof.upper - dof.lower)
            })
            .collect()
        };
        let postures: Vec<Vec<f64>> = (0..POSTURES).map(posture).collect();
        let values: Vec<String> = (0..dof)
            .flat_map(|j| postures.iter().map(move |q| format!("{:?}", q[j])))
            .collect();
        let main = folder.join(format!("{name}.cpp"));
        let text = format!(
            "#include \"{name}.h\"\n#include <cstdio>\nint main()\n{{\n    \
             static const double q[] = {{ {} }};\n    static double com[3 * {POSTURES}];\n    \
             {name}_com_batch({POSTURES}, q, {name}_cad_params, com);\n    \
             for (double x : com) std::printf(\"%.17g\\n\", x);\n}}\n",
            values.join(", ")
        );
        fs::write(&main, text).unwrap();
        let [object, program] = ["o", "out"].map(|end| folder.join(format!("{name}.{end}")));
        run(Command::new("gcc")
            .args(["-O1", "-c"])
            .arg(source)
            .arg("-o")
            .arg(&object));
        let mut link = Command::new("g++");
        link.args(["-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]);
        run(link.arg(&main).arg(&object).arg("-o").arg(&program));
        let printed = run(&mut Command::new(&program));
        let com: Vec<f64> = printed.lines().map(|line| line.parse().unwrap()).collect();
        assert_eq!(com.len(), 3 * POSTURES);
        let urdf = Path::new(ROOT).join(format!("robots/{robot}/{robot}.urdf"));
        let reference = Robot::from_urdf(&fs::read_to_string(urdf).unwrap()).unwrap();
        let reference = Reference::new(&reference, support).unwrap();
        let row = package
            .header
            .lines()
            .find(|line| line.contains(" com_batch "));
        let bound: f64 = row
            .unwrap()
            .split_whitespace()
            .nth(7)
            .unwrap()
            .parse()
            .unwrap();
        assert!(bound > 1e-17 && bound < 1e-13, "{bound}");
        for (i, q) in postures.iter().enumerate() {
            let expected = reference.com(q);
            for k in 0..3 {
                // Summing body by body rounds as well, no more than the chain.
                let apart = (com[k * POSTURES + i] - expected[k]).abs();
                assert!(apart <= 2.0 * bound, "{name}: {apart:e} of {bound:e}");
            }
        }
    }
}

/// A Cortex-M3 divides 64 bits and adds floats by calls of hundreds of cycles.
#[test]
fn fixed_point_on_arm_needs_no_help_from_the_compilers_library() {
    let folder = folder("arm");
    let prismatic = Case::robot("lift_base", "base_link");
    for case in [Case::robot("op2", "r_sole"), prismatic] {
        let package = case.package(Scalar::Fixed32);
        let source = write(&folder, &case.name, &package);
        for word in ["float", "double", " / ", " % "] {
            let code = without_comments(&package.source);
            assert!(!code.contains(word), "{}: `{word}`", case.name);
        }
        let object = folder.join("object.o");
        let mut command = Command::new("arm-none-eabi-gcc");
        command.args([
            "-mcpu=cortex-m3",
            "-mthumb",
            "-std=c99",
            "-O1",
            "-ffreestanding",
            "-c",
        ]);
        tool(command.arg(&source).arg("-o").arg(&object)).unwrap_or_else(|m| panic!("{m}"));
        let mut command = Command::new("arm-none-eabi-nm");
        let undefined = tool(command.arg("-u").arg(&object)).unwrap();
        assert_eq!(String::from_utf8_lossy(&undefined), "", "{}", case.name);
    }
}
