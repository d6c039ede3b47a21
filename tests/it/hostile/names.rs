//! Names that were made to break out of where they are written: into Rust, C, CMake, JSON,
//! TOML, HTML, CSV and a terminal.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use sesc_test_support::command::{folder, in_words, refused, sesc, stdout, write};

/// Names of links, joints and robots; none has what a URDF is refused for.
fn names() -> Vec<String> {
    let mut names: Vec<String> = [
        // The end and the beginning of a comment, trigraphs, a line that goes on.
        "*/",
        "a */ int evil; /*",
        "/* bar",
        "/*/",
        "// x",
        "a??/",
        "??/",
        "a???/",
        "x??'y",
        "back\\",
        "a\\\\",
        "#define x",
        "#include \"/etc/passwd\"",
        "%:%:",
        "<::",
        // Strings of every language.
        "\"",
        "\"); exit(1); (\"",
        "'",
        "'''",
        "\"\"\"",
        "`id`",
        "$(id)",
        "$ENV{HOME}",
        "@X@",
        "]]",
        "]=]",
        "a;b",
        "${x}",
        "%s%n",
        "{{ 7*7 }}",
        "{% raw %}",
        "r#\"",
        "b'",
        "\\u{41}",
        "\\x41",
        "\\n",
        // Documents.
        "</script><b id=hostile>",
        "<b id=hostile>",
        "&lt;b&gt;",
        "&amp;",
        "]]>",
        "<!--",
        "-->",
        "=cmd|'/C calc'!A0",
        "a,b",
        "a\tb",
        "# title",
        "[x](javascript:alert(1))",
        "|",
        "* item",
        // Paths.
        "../../etc/passwd",
        "/etc/passwd",
        "C:\\CON",
        "CON",
        "nul",
        "..",
        ".",
        "~",
        "-rf",
        "--help",
        // Keywords, and names of what is generated.
        "fn",
        "self",
        "Self",
        "crate",
        "int",
        "double",
        "static",
        "class",
        "template",
        "main",
        "com",
        "cop",
        "q",
        "r",
        "sin",
        "cos",
        "DOF",
        "Real",
        "true",
        "None",
        "inf",
        "nan",
        "1e5",
        "007",
        // Names that collide when they are cleaned.
        "l-knee",
        "l.knee",
        "l knee",
        "l_knee",
        "L_KNEE",
        "l__knee",
        "!",
        "?",
        "_",
        "__",
        // Scripts that run the other way, joiners, letters beyond 16 bits, combining marks.
        "مفصل",
        "ברך",
        "膝",
        "a\u{200d}b",
        "👩‍👩‍👧",
        "e\u{301}",
        "\u{feff}a",
        "\u{a0}",
        "İ",
        "ß",
    ]
    .map(str::to_string)
    .into_iter()
    .filter(|name| !name.trim().is_empty() && !name.contains("${") && !name.contains("$("))
    .filter(|name| !name.contains('\t'))
    .collect();
    names.push("n".repeat(1000));
    names.push("??/".repeat(300));
    names.push("膝".repeat(300));
    names
}

fn escaped(name: &str) -> String {
    let name = name.replace('&', "&amp;").replace('<', "&lt;");
    name.replace('"', "&quot;").replace('\'', "&apos;")
}

/// A robot called `robot` that stands on a link called so, too, with a joint for each name.
pub(super) fn robot(robot: &str, joints: &[String]) -> String {
    let support = escaped(robot);
    let mut out = format!("<robot name=\"{support}\"><link name=\"{support}\"/>");
    let mut parent = support;
    for (k, name) in joints.iter().enumerate() {
        // The robot's own name may be among them.
        let name = escaped(name);
        let link = match *name == *escaped(robot) {
            true => format!("{name} 2"),
            false => name.clone(),
        };
        let kind = ["revolute", "prismatic", "continuous"][k % 3];
        let _ = write!(
            out,
            "<link name=\"{link}\"><inertial><origin xyz=\"0.01 0 0.02\"/><mass value=\"1\"/>\
             </inertial></link><joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/>\
             <child link=\"{link}\"/><origin xyz=\"0 0 0.05\" rpy=\"1.5708 0 0\"/><axis xyz=\"0 {} \
             {}\"/><limit lower=\"-1\" upper=\"1\"/></joint>",
            k % 2,
            (k + 1) % 2
        );
        parent = link;
    }
    out + "</robot>"
}

pub(super) fn run(program: &str, arguments: &[&str], folder: &Path) {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {arguments:?}:\n{said}");
}

/// Checks the crate `name` of the modules in `src`.
pub(super) fn check(folder: &Path, name: &str, library: String) {
    fs::write(folder.join("src/lib.rs"), library).unwrap();
    let root = env!("CARGO_MANIFEST_DIR");
    let manifest = format!(
        "[workspace]\n[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \
         \"2024\"\n[dependencies]\nsesc-runtime = {{ path = \"{root}/runtime\" }}\n"
    );
    fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("hostile-target");
    let target = target.display().to_string();
    let check = ["check", "--offline", "--quiet", "--target-dir", &target];
    run(env!("CARGO"), &check, folder);
}

/// Everything that goes into code, for a robot of each name, and for one of all of them.
#[test]
#[cfg(target_os = "linux")]
fn code_of_hostile_names_compiles_without_a_warning() {
    let folder = folder();
    let names = names();
    let some: Vec<String> = names.iter().step_by(4).cloned().collect();
    let mut library = String::from("#![deny(warnings)]\n");
    fs::create_dir(folder.path().join("src")).unwrap();
    let mut c = Vec::new();
    for (k, name) in names.iter().enumerate() {
        // One of all names, four times, so that every name is a joint somewhere.
        let joints = match k {
            0..4 => names.iter().skip(k).step_by(4).cloned().collect(),
            _ => vec![name.clone(), some[k % some.len()].clone() + " 3"],
        };
        // The file's name goes into the header, too.
        let file: String = name.chars().filter(|c| *c != '/').take(40).collect();
        let urdf = write(
            folder.path(),
            &format!("{file}{k}.urdf"),
            robot(name, &joints),
        );
        let module = format!("robot_{k}");
        // A name that begins with a dash is an option unless it is joined.
        let support = format!("--support={name}");
        let generate = ["generate", &urdf, &support, "--name", &module, "--out"];
        let at = |name: &str| folder.path().join(name).display().to_string();
        stdout(&sesc(&[&generate[..], &[&at("src")]].concat()));
        let _ = writeln!(library, "pub mod {module};");
        let scalar = ["f64", "f32", "fixed32"][k % 3];
        let layout = ["bare", "cmake", "platformio", "arduino"][k % 4];
        let out = at(&format!("c{k}"));
        let options = ["--lang", "c", "--scalar", scalar, "--layout", layout];
        stdout(&sesc(&[&generate[..], &[&out], &options].concat()));
        let own = match layout {
            "bare" => (format!("c{k}"), format!("c{k}")),
            "arduino" => (format!("c{k}/src"), format!("c{k}/src")),
            _ => (format!("c{k}/include"), format!("c{k}/src")),
        };
        c.push((format!("-I{}", own.0), format!("{}/{module}.c", own.1)));
    }
    for (include, file) in &c {
        let flags = [
            "-std=c99",
            "-trigraphs",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
        ];
        let bidi = ["-Wbidi-chars=any", "-fsyntax-only", include, file];
        run("cc", &[&flags[..], &bidi].concat(), folder.path());
    }
    check(folder.path(), "hostile-names", library);
}

/// Characters that turn text, and controls, are no part of a name.
#[test]
fn names_that_turn_text_are_refused() {
    let folder = folder();
    for c in [
        '\u{202e}', '\u{2066}', '\u{2028}', '\u{9b}', '\u{7f}', '\u{85}', '\u{200f}', '\u{61c}',
    ] {
        let urdf = write(
            folder.path(),
            "r.urdf",
            robot(&format!("a{c}b"), &["j".into()]),
        );
        let output = sesc(&["inspect", &urdf, "--support", "a"]);
        refused(&output, &["r.urdf", "rename it"]);
        assert!(!String::from_utf8_lossy(&output.stderr).contains(c));
    }
    let long = robot(&"n".repeat(10_000), &["j".into()]);
    let urdf = write(folder.path(), "r.urdf", long);
    refused(
        &sesc(&["inspect", &urdf, "--support", "n"]),
        &["shorten it"],
    );
}

/// A robot of hostile names is simulated, fitted, diagnosed and reported: each document is
/// what it says, and no name becomes a part of it.
#[test]
fn documents_of_hostile_names_stay_documents() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    // Names that a log cannot carry are refused by the writer; the others come back.
    let all = names();
    let carried = |name: &&String| {
        let quoted = name.len() > 1 && name.starts_with('"') && name.ends_with('"');
        let column = ["cop", "t", "pose", "support"].contains(&name.as_str());
        name.trim() == *name && !quoted && !column && !name.starts_with('\u{feff}')
    };
    let joints: Vec<String> = all.iter().filter(carried).cloned().collect();
    let name = "</script><b id=hostile>";
    for (k, joints) in joints.chunks(24).enumerate() {
        let urdf = write(folder.path(), "r.urdf", robot(name, joints));
        let log = at(&format!("log{k}.csv"));
        let simulate = in_words(
            "simulate @ --support @ --poses 80 --noise 0.0005",
            &[&urdf, name],
        );
        let written = sesc(&[&simulate[..], &["--range", "20", "--out", &log]].concat());
        stdout(&written);
        let (model, page, part) = (at("model.toml"), at("page.html"), at("corrected.urdf"));
        let fit = [
            "fit", &urdf, "--data", &log, "--json", "--out", &model, "--report", &page,
        ];
        let answer = stdout(&sesc(&[&fit[..], &["--urdf", &part]].concat()));
        let json: serde_json::Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(json["robot"], name);
        let text = fs::read_to_string(&model).unwrap();
        let table: toml::Table = text.parse().unwrap();
        assert_eq!(table["support"].as_str(), Some(name));
        let text = fs::read_to_string(&page).unwrap();
        assert!(!text.contains("<b id=hostile"), "{page}");
        assert!(text.trim_end().ends_with("</html>"));
        // The corrected URDF has the names that it had.
        let corrected = fs::read_to_string(&part).unwrap();
        let document = roxmltree::Document::parse(&corrected).unwrap();
        let kept = |name: &String| {
            let mut nodes = document.descendants();
            nodes.any(|node| node.attribute("name") == Some(name.as_str()))
        };
        assert!(joints.iter().all(kept));
    }
}

/// What a browser turns around, or a terminal that shows a page obeys, is spelled out there.
#[test]
#[cfg(unix)]
fn pages_spell_out_what_names_of_files_hide() {
    let folder = folder();
    let title = "\u{1b}[2J\u{202e}\u{7}";
    let at = |name: &str| folder.path().join(name).display().to_string();
    let text = robot("r", &["j".into()]);
    let urdf = write(folder.path(), &format!("{title}r.urdf"), text);
    let (log, page) = (at(&format!("{title}log.csv")), at("page.html"));
    let simulate = ["simulate", &urdf, "--support", "r", "--poses", "30"];
    stdout(&sesc(&[&simulate[..], &["--out", &log]].concat()));
    let mut commands = vec![
        vec!["fit", &urdf, "--data", &log],
        vec!["diagnose", &urdf, "--data", &log],
        vec!["compare", &log, "", "--urdf", &urdf, "--support", "r"],
    ];
    let (other, plan) = (at("other.csv"), at(&format!("{title}plan.csv")));
    fs::copy(&log, &other).unwrap();
    commands[2][2] = &other;
    let planned = ["plan", &urdf, "--support", "r", "--poses", "3"];
    commands.push([&planned[..], &["--cop-box", "0.2", "--out", &plan]].concat());
    for command in commands {
        let output = sesc(&[&command[..], &["--report", &page]].concat());
        let text = fs::read_to_string(&page).unwrap_or_else(|_| panic!("{output:?}"));
        assert!(
            !text.contains(['\u{1b}', '\u{202e}', '\u{7}']),
            "{command:?}"
        );
        assert!(text.contains("\\u{202e}"), "{command:?}");
        fs::remove_file(&page).unwrap();
    }
}

/// What a terminal obeys does not reach it from a file, nor from the name of one.
#[test]
#[cfg(unix)]
fn terminals_are_told_nothing_by_files() {
    let folder = folder();
    let title = "\u{1b}]0;owned\u{7}";
    let urdf = write(
        folder.path(),
        &format!("{title}r.urdf"),
        robot("r", &["j".into()]),
    );
    let log = folder
        .path()
        .join(format!("{title}log.csv"))
        .display()
        .to_string();
    let simulate = in_words("simulate @ --support r --poses 30 --out @", &[&urdf, &log]);
    let escaped = title.escape_default().to_string();
    let sidecar = format!("{log}.toml");
    let outputs = [
        sesc(&simulate),
        sesc(&["fit", &urdf, "--data", &log]),
        sesc(&["fit", &urdf, "--data", &log, "--json"]),
        sesc(&["inspect", &format!("{title}none.urdf"), "--support", "r"]),
        {
            write(folder.path(), "m.toml", format!(
                "robot = \"r\"\nhash = \"{escaped}\"\nsupport = \"{escaped}\"\nparameters = []\n"
            ).replace("\\u{1b}", "\\u001b").replace("\\u{7}", "\\u0007"));
            let model = folder.path().join("m.toml").display().to_string();
            sesc(&["predict", &urdf, "--model", &model, "--data", &log])
        },
        {
            let text = format!("support = \"{escaped}\"\nexperiment = \"{escaped}\"\n");
            let text = text
                .replace("\\u{1b}", "\\u001b")
                .replace("\\u{7}", "\\u0007");
            fs::write(&sidecar, text).unwrap();
            sesc(&["diagnose", &urdf, "--data", &log])
        },
    ];
    for output in outputs {
        for stream in [&output.stdout, &output.stderr] {
            let text = String::from_utf8_lossy(stream);
            assert!(
                !text.contains('\u{1b}') && !text.contains('\u{7}'),
                "{text:?}"
            );
        }
    }
}
