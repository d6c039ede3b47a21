//! C compilers take it without a warning; objects hold constants and code alone.

use std::fs;
use std::process::Command;

use super::case::{cases, few, jobs};
use super::compiled::{WARNINGS, folder, parallel, tool, write};
use crate::COMPILERS;

#[test]
fn compiles_without_warnings() {
    let folder = folder("warnings");
    let cases = if COMPILERS.len() == 1 { few() } else { cases() };
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let libm = format!("-D{}_USE_LIBM", case.name);
        {
            for compiler in COMPILERS {
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
        let package = case.package(scalar);
        let source = write(&folder, &case.name, &package);
        let object = folder.join("object.o");
        let mut command = Command::new(COMPILERS[0]);
        command.args(["-std=c99", "-O0", "-fno-pic", "-c"]);
        run(command.arg(source).arg("-o").arg(&object));
        let symbols = run(Command::new("nm").arg(&object));
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
