//! gcc, clang and C++ compile it without a warning; objects hold constants and code alone.

use std::fmt::Write as _;
use std::fs;
use std::process::Command;

use super::super::compiled::{WARNINGS, folder, parallel, tool, write};
use super::{cases, few, jobs};
use sesc_test_support::memo;

/// The flags that compilers are asked with.
const TESTS: &str = concat!(include_str!("compilers.rs"), include_str!("../compiled.rs"));

#[test]
fn compiles_without_warnings() {
    let folder = folder("warnings");
    let cases = cases();
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let libm = format!("-D{}_USE_LIBM", case.name);
        let texts = [TESTS, &package.header, &package.source];
        memo::said(&folder, &["gcc", "clang"], &texts, &[], || {
            for compiler in ["gcc", "clang"] {
                for define in ["-DNOTHING", &libm] {
                    let mut command = Command::new(compiler);
                    command.args(WARNINGS).args([
                        "-fsyntax-only",
                        "-Wundef",
                        "-Wmissing-prototypes",
                    ]);
                    run(command.args(["-Wstrict-prototypes", define]).arg(&source));
                }
            }
            String::new()
        });
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
        fs::write(&main, &text).unwrap();
        fs::write(
            folder.join("alone.c"),
            format!("{include}typedef {name}_real it;\n"),
        )
        .unwrap();
        let tools = ["gcc", "clang", "g++", "clang++"];
        let texts = [TESTS, &package.header, &package.source, &text];
        let object = folder.join("object.o");
        memo::said(&folder, &tools, &texts, &[], || {
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
            String::new()
        });
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
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let object = folder.join("object.o");
        let texts = [TESTS, &package.header, &package.source];
        let symbols = memo::said(&folder, &["gcc", "nm"], &texts, &[], || {
            let mut command = Command::new("gcc");
            command.args(["-std=c99", "-O0", "-fno-pic", "-c"]);
            run(command.arg(source).arg("-o").arg(&object));
            run(Command::new("nm").arg(&object))
        });
        for line in symbols.lines() {
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
