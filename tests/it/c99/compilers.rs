//! C compilers take it without a warning; objects hold constants and code alone.

use std::fs;
use std::process::Command;

use sesc_codegen::emit::c::Scalar;

use super::case::{cases, few, jobs};
use super::compiled::{WARNINGS, folder, parallel, printed, write};
use crate::COMPILERS;
use sesc_test_support::command::says;

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

/// A compiler that cannot compile the source, or whose numbers are not those that bounds are
/// proven for, is refused by the preprocessor in one sentence.
#[test]
fn what_cannot_hold_the_promise_is_refused_in_a_sentence() {
    let folder = folder("refused");
    let case = super::case::Case::robot("two_link", "foot");
    let said = |scalar: Scalar, compiler: &str, flags: &[&str]| {
        let source = write(&folder, &case.name, &case.package(scalar));
        let mut command = Command::new(compiler);
        let language = if compiler == "c++" { "c++" } else { "c" };
        command.args(["-x", language, "-fsyntax-only"]);
        let output = command.args(flags).arg(&source).output().unwrap();
        assert!(!output.status.success(), "{scalar:?} {compiler} {flags:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    // <float.h> as targets have it whose double is a float, or whose floats are not binary.
    let limits = |name: &str, radix: u32| {
        let text = format!(
            "#define FLT_RADIX {radix}\n#define DBL_MANT_DIG 24\n#define DBL_MAX_EXP 128\n\
             #define FLT_MANT_DIG 24\n#define FLT_MAX_EXP 128\n#define FLT_EVAL_METHOD 0\n"
        );
        fs::create_dir_all(folder.join(name)).unwrap();
        fs::write(folder.join(name).join("float.h"), text).unwrap();
        format!("-I{}", folder.join(name).display())
    };
    let (small, odd) = (limits("avr", 2), limits("odd", 16));
    let (small, odd) = (["-std=c99", &small], ["-std=c99", &odd]);
    let (f64, f32, fixed) = (Scalar::F64, Scalar::F32, Scalar::Fixed32);
    let in_cpp = "is C99: compile it as C; two_link_foot.h is for C and C++";
    let msvc = ["-D_MSC_VER=1940", "-std=c11"];
    let rows: [(Scalar, &str, &[&str], &str); 6] = [
        (f64, "c++", &[], in_cpp),
        (fixed, "c++", &[], "is C99: compile it as C"),
        (f32, "cc", &["-std=c90"], "is C99: add -std=c99"),
        (f32, "cc", &msvc, "compile it with clang-cl"),
        (f64, "cc", &small, "double has no 64 bits here"),
        (f32, "cc", &odd, "float is not of IEEE's 32 bits here"),
    ];
    for (scalar, compiler, flags, sentence) in rows {
        says(said(scalar, compiler, flags), &["#error", sentence]);
    }
}
