//! gcc, clang and C++ compile it without a warning; objects hold constants and code alone.

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use super::{cases, few, jobs};
use crate::compiled::{WARNINGS, folder, parallel, tool, write};

#[test]
fn compiles_without_warnings() {
    let folder = folder("warnings");
    let cases = cases();
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &case.package(scalar));
        let libm = format!("-D{}_USE_LIBM", case.name);
        for compiler in ["gcc", "clang"] {
            for define in ["-DNOTHING", &libm] {
                let mut command = Command::new(compiler);
                command
                    .args(WARNINGS)
                    .args(["-fsyntax-only", "-Wundef", "-Wmissing-prototypes"]);
                tool(command.args(["-Wstrict-prototypes", define]).arg(&source))
                    .unwrap_or_else(|message| panic!("{message}"));
            }
        }
    });
}

#[test]
fn the_header_compiles_alone_and_as_cplusplus() {
    let folder = folder("cplusplus");
    let cases = few();
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let (name, dof) = (&case.name, case.model.dof());
        let source = write(&folder, name, &case.package(scalar));
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
    });
}

fn run(command: &mut Command) -> String {
    let output = tool(command).unwrap_or_else(|message| panic!("{message}"));
    String::from_utf8(output).unwrap()
}

/// Nothing to write to, no memory to ask for.
#[test]
fn objects_hold_constants_and_code_only() {
    let folder = folder("objects");
    let cases = few();
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &case.package(scalar));
        let object = folder.join("object.o");
        let mut command = Command::new("gcc");
        command
            .args(["-std=c99", "-O0", "-fno-pic", "-c"])
            .arg(source)
            .arg("-o")
            .arg(&object);
        run(&mut command);
        for line in run(Command::new("nm").arg(&object)).lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [kind, symbol] = words[words.len() - 2..] else {
                panic!("nm says {line}")
            };
            assert!(
                ["T", "t", "R", "r", "U"].contains(&kind),
                "{}: {line}",
                case.name
            );
            let allowed = ["memcpy", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"];
            assert!(
                kind != "U" || allowed.contains(&symbol),
                "{}: calls {symbol}",
                case.name
            );
            let prefix = format!("{}_", case.name);
            let local = kind == "r" || kind == "t";
            assert!(
                kind == "U" || local || symbol.starts_with(&prefix),
                "{}: {symbol}",
                case.name
            );
        }
    });
}
