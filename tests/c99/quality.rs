//! What the C is like to read, to compile and to trust: gcc, clang, C++, cppcheck
//! with its MISRA rules, and the text itself.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use sesc_codegen::emit::c::Scalar;
use sesc_model::ModelFile;

use crate::case::{Case, ROBOTS, ROOT, SCALARS};
use crate::compiled::{WARNINGS, folder, parallel, tool, write};
use crate::fixed::without_comments;

/// Sums end where names begin: no line grows with the robot.
const LONGEST_LINE: usize = 600;

/// Robots, with and without a model file; one has names that only C++ would tell apart.
fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = ROBOTS.iter().map(|(r, s)| Case::robot(r, s)).collect();
    cases.push(Case::robot("skew_humanoid", "right_sole"));
    cases.extend((0..4).map(|k| Case::random(740 + k, 3 + 4 * k as usize)));
    for (robot, support) in [
        ("op2", "l_sole"),
        ("lift_base", "base_link"),
        ("two_link", "foot"),
    ] {
        let mut case = Case::robot(robot, support);
        let file = ModelFile::from_values(&case.model, &case.model.cad_params(), None, "prior");
        case.model = case.model.with_file(file).unwrap();
        case.name += "_model";
        cases.push(case);
    }
    cases
}

/// Those that differ in kind.
fn few() -> Vec<Case> {
    let alike = ["humanoid_left", "plain", "quad", "arm", "op2_body"];
    let mut cases = cases();
    cases.retain(|case| !alike.iter().any(|name| case.name.contains(name)));
    cases
}

/// Every case in every scalar.
fn jobs(cases: &[Case]) -> Vec<(&Case, Scalar)> {
    let scalars = |case| SCALARS.map(|scalar| (case, scalar));
    cases.iter().flat_map(scalars).collect()
}

#[test]
fn gcc_and_clang_have_nothing_to_say() {
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
fn the_header_serves_cplusplus_and_stands_alone() {
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
        for entry in case.entries() {
            let inputs = match entry.given {
                None => "ticks",
                Some(sesc_model::Given::Positions) => "q",
                Some(_) => "q, q",
            };
            let r = if entry.takes_parameters() {
                format!(", {name}_cad_params")
            } else {
                String::new()
            };
            let _ = writeln!(calls, "    {name}_{}({inputs}{r}, out);", entry.name);
        }
        let text = format!(
            "{include}{include}#include <cstdint>\nint main()\n{{\n    \
             const {name}_real q[{dof}] = {{}};\n    const std::int32_t ticks[{name}_DOF] = {{}};\n    \
             static {name}_real out[3 * {name}_FULL_PARAMS + 3 * {name}_DOF];\n    \
             (void)q;\n    (void)ticks;\n{calls}    \
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

/// Identifiers of C text.
fn words(code: &str) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    let mut word = String::new();
    let mut quoted = false;
    let mut escaped = false;
    for c in code.chars() {
        if quoted {
            quoted = c != '"' || escaped;
            escaped = c == '\\' && !escaped;
            continue;
        }
        quoted = c == '"';
        let number = word.starts_with(digit);
        let exponent = number && c == '-' && word.ends_with('e');
        if c.is_ascii_alphanumeric() || c == '_' || (number && c == '.') || exponent {
            word.push(c);
        } else {
            words.insert(std::mem::take(&mut word));
        }
    }
    words.insert(word);
    words
}

fn digit(c: char) -> bool {
    c.is_ascii_digit()
}

#[test]
fn the_text_keeps_to_the_rules() {
    for (case, scalar) in jobs(&cases()) {
        let package = case.package(scalar);
        for (file, text) in [("h", &package.header), ("c", &package.source)] {
            let name = format!("{}.{file} {scalar:?}", case.name);
            assert!(text.is_ascii() && !text.contains(['\r', '\t']), "{name}");
            assert!(text.ends_with('\n') && !text.ends_with("\n\n"), "{name}");
            for line in text.lines() {
                assert!(
                    line.len() <= LONGEST_LINE,
                    "{name}: {} in {line}",
                    line.len()
                );
                assert_eq!(line, line.trim_end(), "{name}");
            }
            let code = without_comments(text);
            for bad in [
                "[static", "alloc", "goto", "union", "//", "volatile", "register", "inline",
            ] {
                assert!(!code.contains(bad), "{name}: {bad}");
            }
            for line in code.lines().filter(|line| !line.contains("for (")) {
                assert!(line.matches(';').count() <= 1, "{name}: {line}");
            }
        }
        let code = without_comments(&(package.header.clone() + &package.source));
        let macros: BTreeSet<&str> = code
            .lines()
            .filter_map(|line| line.strip_prefix("#define ")?.split_whitespace().next())
            .collect();
        let words = words(&code);
        distinct(&case.name, macros.iter().copied(), 63);
        let named = words.iter().map(String::as_str);
        let named = named.filter(|word| !word.starts_with(digit) && !macros.contains(word));
        distinct(&case.name, named, 63);
        if scalar == Scalar::F32 {
            for number in words
                .iter()
                .filter(|w| w.starts_with(digit) && !w.starts_with("0x"))
            {
                let float = number.contains(['.', 'e']);
                assert!(!float || number.ends_with('f'), "{}: {number}", case.name);
            }
            assert!(!words.contains("double"), "{}", case.name);
        }
        no_recursion(&case.name, &without_comments(&package.source));
    }
}

/// No two of `names` begin with the same `length` characters.
fn distinct<'a>(case: &str, names: impl Iterator<Item = &'a str>, length: usize) {
    let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
    for name in names {
        let start = &name[..name.len().min(length)];
        if let Some(other) = seen.insert(start, name) {
            assert_eq!(other, name, "{case}: one name in {length} characters");
        }
    }
}

/// A function calls only what stands above it.
fn no_recursion(case: &str, code: &str) {
    let defines = |line: &str| {
        let head = line.split_once('(')?.0;
        let starts = line.starts_with(|c: char| c.is_ascii_alphabetic());
        starts.then(|| {
            head.split_whitespace()
                .last()
                .unwrap_or_default()
                .to_string()
        })
    };
    let order: Vec<String> = code.lines().filter_map(defines).collect();
    assert!(order.len() > 3, "{case}: {order:?}");
    let mut above = 0;
    for line in code.lines() {
        if defines(line).is_some() {
            above += 1;
            continue;
        }
        for name in &order[above.max(1) - 1..] {
            let called = line.contains(&format!(" {name}(")) || line.contains(&format!("-{name}("));
            assert!(!called, "{case}: {line}");
        }
    }
}

/// Rules of MISRA C:2012 that the C departs from, from the list of reasons.
fn departures() -> BTreeSet<String> {
    let list = Path::new(ROOT).join("codegen/src/emit/c/misra.md");
    let text = fs::read_to_string(list).unwrap();
    let rule = |line: &str| {
        Some(
            line.strip_prefix("| ")?
                .split_whitespace()
                .next()?
                .to_string(),
        )
    };
    text.lines()
        .filter_map(rule)
        .filter(|rule| rule.starts_with(digit))
        .collect()
}

#[test]
fn cppcheck_finds_only_the_departures_that_are_listed() {
    let folder = folder("cppcheck");
    let mut cases = vec![
        Case::robot("two_link", "foot"),
        Case::robot("lift_base", "hand"),
    ];
    cases.push(Case::random(741, 7));
    let mut case = Case::robot("two_link", "foot");
    let file = ModelFile::from_values(&case.model, &case.model.cad_params(), None, "prior");
    case.model = case.model.with_file(file).unwrap();
    case.name += "_model";
    cases.push(case);
    let op2 = Case::robot("op2", "r_sole");
    let mut jobs = jobs(&cases);
    jobs.push((&op2, Scalar::Fixed32));
    let found: BTreeSet<String> = parallel(jobs, |(case, scalar)| {
        let folder = folder.join(format!("{}_{scalar:?}", case.name));
        fs::create_dir_all(&folder).unwrap();
        let source = write(&folder, &case.name, &case.package(scalar));
        let mut command = Command::new("cppcheck");
        command.args([
            "--enable=warning,style,performance,portability",
            "--addon=misra",
        ]);
        command.args([
            "--std=c99",
            "--quiet",
            "--template={id} {file}:{line} {message}",
        ]);
        let output = command.arg(&source).output().expect("install cppcheck");
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        let mut rules = BTreeSet::new();
        for line in text.lines() {
            let rule = line.strip_prefix("misra-c2012-");
            let rule = rule.unwrap_or_else(|| panic!("{} {scalar:?}: {line}", case.name));
            let rule = rule.split_whitespace().next().unwrap().to_string();
            assert!(
                departures().contains(&rule),
                "{} {scalar:?}: {line}",
                case.name
            );
            rules.insert(rule);
        }
        rules
    })
    .into_iter()
    .flatten()
    .collect();
    assert_eq!(
        found,
        departures(),
        "the list names what is departed from, and nothing else"
    );
}

/// The same text every time, and whatever the language of the machine.
#[test]
fn the_same_bytes_in_every_run_and_language() {
    let folder = folder("language");
    for (k, language) in ["C", "de_DE.UTF-8", "tr_TR.UTF-8"].into_iter().enumerate() {
        let out = folder.join(k.to_string());
        let mut command = Command::new(env!("CARGO_BIN_EXE_sesc"));
        command
            .current_dir(ROOT)
            .env("LC_ALL", language)
            .env("LANG", language);
        command.args([
            "generate",
            "robots/op2/op2.urdf",
            "--support",
            "r_sole",
            "--lang",
            "c",
        ]);
        command.args(["--scalar", "fixed32", "--name", "op2_r_sole_fixed", "--out"]);
        tool(command.arg(&out)).unwrap_or_else(|message| panic!("{message}"));
        for file in ["op2_r_sole_fixed.h", "op2_r_sole_fixed.c"] {
            let text = fs::read(out.join(file)).unwrap();
            assert!(text == fs::read(Path::new(ROOT).join("generated/c").join(file)).unwrap());
        }
    }
    let case = Case::random(741, 7);
    for scalar in SCALARS {
        assert_eq!(case.package(scalar), Case::random(741, 7).package(scalar));
    }
}
