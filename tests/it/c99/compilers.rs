//! C compilers take it without a warning; objects hold constants and code alone.

use std::fs;
use std::process::Command;

use super::case::{cases, few, jobs};
use super::compiled::{WARNINGS, folder, parallel, printed, write};
use crate::COMPILERS;

/// With and without the library's sines; there is nothing to write to, no memory to ask for.
#[test]
fn compiles_without_warnings_to_constants_and_code_only() {
    let folder = folder("warnings");
    let cases = if COMPILERS.len() == 1 { few() } else { cases() };
    parallel(jobs(&cases), |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &case.package(scalar));
        let object = folder.join("object.o");
        let libm = format!("-D{}_USE_LIBM", case.name);
        for compiler in COMPILERS {
            for define in ["-DNOTHING", &libm] {
                let mut command = Command::new(compiler);
                command.args(WARNINGS).args(["-Wundef", define]);
                command.args(["-Wmissing-prototypes", "-Wstrict-prototypes"]);
                match (compiler, define) == (COMPILERS[0], "-DNOTHING") {
                    true => command.args(["-O0", "-fno-pic", "-c", "-o"]).arg(&object),
                    false => command.arg("-fsyntax-only"),
                };
                printed(command.arg(&source));
            }
        }
        let symbols = printed(Command::new("nm").arg(&object));
        for line in symbols.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [kind, symbol] = words[words.len() - 2..] else {
                panic!("nm says {line}")
            };
            let called = ["memcpy", "_GLOBAL_OFFSET_TABLE_", "__stack_chk_fail"];
            let allowed = match kind {
                "U" => called.contains(&symbol),
                "T" | "R" => symbol.starts_with(&format!("{}_", case.name)),
                _ => ["t", "r"].contains(&kind),
            };
            assert!(allowed, "{}: {line}", case.name);
        }
    });
}
