//! Names composed at random of pieces that break out of something go through code, pages, tables
//! and the terminal as what they are.

use std::fmt::Write as _;
use std::fs;
use std::process::Output;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_test_support::command::{folder, in_words, sesc, stdout, write};

use super::names::{check, robot, run};

/// What a name is composed of: ends of strings and comments of every language, trigraphs, lines
/// that go on, documents, paths, keywords, and characters that are not seen as what they are.
const PIECES: [&str; 50] = [
    "*/",
    "/*",
    "//",
    "??/",
    "??'",
    "\\",
    "\\\\",
    "\"",
    "'",
    "`",
    "#",
    "\"#",
    "%:",
    "]]",
    "]]>",
    "{{",
    "}}",
    "{%",
    "%s",
    "%n",
    "\\n",
    "\\u{41}",
    "\\x",
    "</script>",
    "<script>",
    "<b id=hostile>",
    "<!--",
    "-->",
    "&amp;",
    "&lt;",
    "../..",
    "/etc/passwd",
    "C:",
    "~",
    "--",
    ";",
    ",",
    "=cmd|",
    "@",
    "fn",
    "int",
    "self",
    "static",
    "0",
    "1e5",
    " ",
    "\u{200d}",
    "\u{200b}",
    "膝",
    "مفصل",
];
fn composed(draw: &mut ChaCha8Rng) -> String {
    let mut name = String::new();
    for _ in 0..draw.random_range(1..7) {
        name += PIECES[draw.random_range(0..PIECES.len())];
    }
    // A name of blanks, and one that xacro would expand, are others' tests.
    if name.trim().is_empty() {
        name += "x";
    }
    name
}

/// So many names that may be one, each its own.
fn names(seed: u64, count: usize, carried: impl Fn(&str) -> bool) -> Vec<String> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    let mut names: Vec<String> = Vec::new();
    while names.len() < count {
        let name = composed(&mut draw);
        if carried(&name) && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// What reaches the terminal has no character that it obeys.
fn quiet(output: &Output) {
    for stream in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(stream);
        let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
        assert!(!text.contains(obeyed), "{text:?}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn code_of_composed_names_compiles() {
    let folder = folder();
    let mut draw = ChaCha8Rng::seed_from_u64(21);
    let mut library = String::from("#![deny(warnings)]\n");
    fs::create_dir(folder.path().join("src")).unwrap();
    for k in 0..45 {
        let name = composed(&mut draw);
        let joints = names(1000 + k, 3, |own| own != name);
        let urdf = write(folder.path(), "r.urdf", robot(&name, &joints));
        let support = format!("--support={name}");
        let module = format!("robot_{k}");
        let at = |name: &str| folder.path().join(name).display().to_string();
        let c = at(&format!("c{k}"));
        let generate = ["generate", &urdf, "--name", &module, "--out"];
        let scalar = ["f64", "f32", "fixed32"][k as usize % 3];
        let options = ["--lang", "c", "--scalar", scalar, &support];
        let output = sesc(&[&generate[..], &[&c], &options].concat());
        quiet(&output);
        stdout(&output);
        let file = format!("c{k}/{module}.c");
        let flags = [
            "-std=c99",
            "-trigraphs",
            "-Wall",
            "-Werror",
            "-O0",
            "-c",
            &file,
        ];
        run(
            "cc",
            &[&flags[..], &["-o", "out.o"]].concat(),
            folder.path(),
        );
        // Rust of some: the compiler of the library looks at all of them at once.
        if k < 8 {
            stdout(&sesc(&[&generate[..], &[&at("src"), &support]].concat()));
            let _ = writeln!(library, "pub mod {module};");
        }
    }
    check(folder.path(), "composed-names", library);
}

/// A page whose names are its text: nothing of them is an element of it.
fn page_is_whole(path: &str, scripts: &mut Option<usize>) {
    let text = fs::read_to_string(path).unwrap();
    assert!(!text.contains("<b id=hostile"), "{path}");
    assert!(
        !text.contains('\u{1b}') && !text.contains('\u{7}'),
        "{path}"
    );
    assert!(text.trim_end().ends_with("</html>"), "{path}");
    let ends = text.matches("</script").count();
    assert_eq!(text.matches("<script").count(), ends, "{path}");
    assert_eq!(*scripts.get_or_insert(ends), ends, "{path}");
}

/// Every page of a robot of composed names has the elements that it has for a plain one.
#[test]
#[cfg(unix)]
fn pages_of_composed_names_stay_pages() {
    let carried = |name: &str| {
        let quoted = name.len() > 1 && name.starts_with('"') && name.ends_with('"');
        name.trim() == name && !quoted
    };
    let hostile = names(7, 7, carried);
    let plain: Vec<String> = (0..7).map(|k| format!("part {k}")).collect();
    let mut scripts = [None; 4];
    for names in [plain, hostile] {
        let folder = folder();
        let at = |name: &str| folder.path().join(name).display().to_string();
        let (foot, joints) = names.split_first().unwrap();
        let (support, joints) = (format!("--support={foot}"), &joints[..4]);
        let urdf = write(folder.path(), "r.urdf", robot(foot, joints));
        let log = at("log.csv");
        let simulate = ["--poses", "60", "--noise", "0.0005", "--range", "20"];
        let simulate = [&["simulate", &urdf, &support][..], &simulate].concat();
        stdout(&sesc(&[&simulate[..], &["--out", &log]].concat()));
        // The name of the folder is that of the robot in a fleet.
        let own = format!("{}\u{1b}]0;owned\u{7}", foot.replace('/', "_"));
        let day = folder.path().join("logs").join(format!("robot={own}"));
        fs::create_dir_all(&day).unwrap();
        for end in ["csv", "csv.toml"] {
            fs::copy(at(&format!("log.{end}")), day.join(format!("monday.{end}"))).unwrap();
        }
        let (data, table, poses) = (at("logs"), at("fleet.csv"), at("poses.csv"));
        let commands: [&[&str]; 4] = [
            &["fit", &urdf, "--data", &log],
            &["diagnose", &urdf, "--data", &log],
            &in_words(
                "plan @ @ --poses 8 --cop-box 0.023 --out @",
                &[&urdf, &support, &poses],
            ),
            &in_words(
                "fleet @ --data @ --by robot,day --out @",
                &[&urdf, &data, &table],
            ),
        ];
        for (command, scripts) in commands.iter().zip(&mut scripts) {
            let page = at(&format!("{}.html", command[0]));
            let output = sesc(&[command, &["--report", &page][..]].concat());
            quiet(&output);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(
                matches!(output.status.code(), Some(0 | 1)),
                "{command:?}: {said}"
            );
            page_is_whole(&page, scripts);
        }
        let table = fs::read_to_string(&table).unwrap();
        assert!(!table.contains('\u{1b}') && !table.contains('\u{7}'));
        assert!(table.contains("\\u{1b}]0;owned\\u{7}"), "{table}");
    }
}
