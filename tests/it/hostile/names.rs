//! Names that were made to break out of where they are written: into Rust, C, CMake, JSON,
//! TOML, HTML, CSV and a terminal.

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Output};

use sesc_test_support::child::Child;
use sesc_test_support::command::{Folder, folder, in_words, printed, refused, sesc, stdout, write};

/// Names of links, joints and robots without blanks; none has what a URDF is refused for.
const NAMES: &str = r###"
    */ /*/ a??/ ??/ a???/ x??'y back\ a\\ %:%: <::
    " ' ''' """ `id` $ENV{HOME} @X@ ]] ]=] a;b %s%n r#" b' \u{41} \x41 \n
    </script><b <b &lt;b&gt; &amp; ]]> <!-- --> =cmd|'/C a,b [x](javascript:alert(1)) |
    ../../etc/passwd /etc/passwd C:\CON CON nul .. . ~ -rf --help
    fn self Self crate int double static class template main com cop q r sin cos DOF Real true None
    inf nan 1e5 007 l-knee l.knee l_knee L_KNEE l__knee ! ? _ __
    */"</script>??/ ??/\%s{{"# --]]>../..{% \"*/<!--fn ";=cmd|@/* 0??'</script>\\
    مفصل ברך 膝 👩‍👩‍👧 İ ß مفصل*/膝"
"###;

/// The same with blanks, characters that are not seen, and beyond all lengths.
fn names() -> Vec<String> {
    let with_blanks = [
        "a */ int evil; /*",
        "/* bar",
        "// x",
        "#define x",
        "#include \"/etc/passwd\"",
        "\"); exit(1); (\"",
        "{{ 7*7 }}",
        "{% raw %}",
        "</script><b id=hostile>",
        "<b id=hostile>",
        "=cmd|'/C calc'!A0",
        "# title",
        "* item",
        "l knee",
        "*/ \" <b id=hostile> ??/",
        "a\u{200d}b",
        "e\u{301}",
        "\u{feff}a",
        "\u{a0}",
        "\u{200b}*/\u{200d}",
    ];
    let names = NAMES.split_ascii_whitespace().chain(with_blanks);
    let names = names
        .filter(|name| !name.trim().is_empty())
        .map(str::to_string);
    let long = [("n", 1000), ("??/", 300), ("膝", 300)].map(|(part, count)| part.repeat(count));
    names.chain(long).collect()
}

fn escaped(name: &str) -> String {
    let name = name.replace('&', "&amp;").replace('<', "&lt;");
    name.replace('"', "&quot;").replace('\'', "&apos;")
}

/// A robot called `robot` that stands on a link called so, too, with a joint for each name.
fn robot(robot: &str, joints: &[String]) -> String {
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

/// Everything that goes into code, for a robot of each name, and for one of all of them.
#[test]
#[cfg(target_os = "linux")]
fn code_of_hostile_names_compiles_without_a_warning() {
    let folder = folder();
    let names = names();
    let some: Vec<String> = names.iter().step_by(4).cloned().collect();
    let mut library = String::from("#![deny(warnings)]\n");
    let child = Child::new("hostile-names", "");
    let mut c = Vec::new();
    for (k, name) in names.iter().enumerate() {
        // One of all names, four times, so that every name is a joint somewhere.
        let joints = match k {
            0..4 => names.iter().skip(k).step_by(4).cloned().collect(),
            _ => vec![name.clone(), some[k % some.len()].clone() + " 3"],
        };
        // The file's name goes into the header, too.
        let file: String = name.chars().filter(|c| *c != '/').take(40).collect();
        let file = format!("{file}{k}.urdf");
        let urdf = write(folder.path(), &file, robot(name, &joints));
        let module = format!("robot_{k}");
        // A name that begins with a dash is an option unless it is joined.
        let support = format!("--support={name}");
        let generate = ["generate", &urdf, &support, "--name", &module, "--out"];
        let at = |name: &str| folder.path().join(name).display().to_string();
        let source = child.path("src").display().to_string();
        quiet(&sesc(&[&generate[..], &[&source]].concat()), &[0]);
        let _ = writeln!(library, "pub mod {module};");
        let scalar = ["f64", "f32", "fixed32"][k % 3];
        let layout = ["bare", "cmake", "platformio", "arduino"][k % 4];
        let options = ["--lang", "c", "--scalar", scalar, "--layout", layout];
        quiet(
            &sesc(&[&generate[..], &[&at(&format!("c{k}"))], &options].concat()),
            &[0],
        );
        let [include, source] = match layout {
            "bare" => ["", ""],
            "arduino" => ["/src", "/src"],
            _ => ["/include", "/src"],
        };
        c.push((
            format!("-Ic{k}{include}"),
            format!("c{k}{source}/{module}.c"),
        ));
    }
    for (include, file) in &c {
        let mut cc = Command::new("cc");
        cc.args([
            "-std=c99",
            "-trigraphs",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Werror",
        ]);
        cc.args(["-Wbidi-chars=any", "-fsyntax-only", include, file]);
        printed(cc.current_dir(&folder));
    }
    child.write("src/lib.rs", &library);
    child.cargo(&["check"]).unwrap();
}

/// Characters that turn text, and controls, are no part of a name.
#[test]
fn names_that_turn_text_are_refused() {
    let folder = Folder::empty();
    for c in [
        '\u{202e}', '\u{2066}', '\u{2028}', '\u{9b}', '\u{7f}', '\u{85}', '\u{200f}', '\u{61c}',
    ] {
        folder.write("r.urdf", robot(&format!("a{c}b"), &["j".into()]));
        let output = folder.run("inspect r.urdf --support a");
        refused(&output, &["r.urdf", "rename it"]);
        assert!(!String::from_utf8_lossy(&output.stderr).contains(c));
    }
    folder.write("r.urdf", robot(&"n".repeat(10_000), &["j".into()]));
    folder.refuses("inspect r.urdf --support n", &["shorten it"]);
}

/// Names that a log can carry; its writer refuses the others.
fn carried(name: &str) -> bool {
    let quoted = name.len() > 1 && name.starts_with('"') && name.ends_with('"');
    let column = ["cop", "t", "pose", "support"].contains(&name);
    name.trim() == name && !quoted && !column && !name.starts_with('\u{feff}')
}

/// A robot of hostile names is simulated, fitted, diagnosed and reported: each document is
/// what it says, and no name becomes a part of it.
#[test]
fn documents_of_hostile_names_stay_documents() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let joints: Vec<String> = names().into_iter().filter(|name| carried(name)).collect();
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
        scripts(&page);
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

/// The number of scripts of a page that names are no element of.
fn scripts(path: &str) -> usize {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    assert!(!text.contains("<b id=hostile"), "{path}");
    assert!(!text.contains(OBEYED), "{path}");
    assert!(text.trim_end().ends_with("</html>"), "{path}");
    let ends = text.matches("</script").count();
    assert_eq!(text.matches("<script").count(), ends, "{path}");
    ends
}

/// What a terminal obeys, and what a browser turns around.
const OBEYED: [char; 3] = ['\u{1b}', '\u{202e}', '\u{7}'];

/// What reaches the terminal has no character that it obeys, and the command ends with one of
/// `codes`.
fn quiet(output: &Output, codes: &[i32]) {
    for stream in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(stream);
        let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
        assert!(!text.contains(obeyed), "{text:?}");
    }
    let code = output.status.code().unwrap();
    assert!(codes.contains(&code), "{output:?}");
}

/// Every page of a robot of hostile names has the scripts that it has for a plain one, and spells
/// out what names of files hide.
#[test]
#[cfg(unix)]
fn pages_of_hostile_names_stay_pages() {
    let hostile = [
        "*/\"</script><b id=hostile>",
        "</script>??/",
        "]]>&amp;膝",
        "=cmd|'{{%s",
        "--><!--",
    ];
    let hostile = hostile.map(str::to_string).to_vec();
    let plain = (0..5).map(|k| format!("part {k}")).collect();
    let [plain, hostile] = [(plain, ""), (hostile, "\u{1b}[2J\u{202e}\u{7}")].map(
        |(names, title): (Vec<String>, &str)| {
            let folder = folder();
            let at = |name: &str| folder.path().join(name).display().to_string();
            let of = |name: &str| at(&format!("{title}{name}"));
            let support = format!("--support={}", names[0]);
            let urdf = write(
                folder.path(),
                &format!("{title}r.urdf"),
                robot(&names[0], &names[1..5]),
            );
            let (log, other, page) = (of("log.csv"), at("other.csv"), at("page.html"));
            let simulate = "simulate @ @ --poses 60 --noise 0.0005 --range 20 --out @";
            quiet(&sesc(&in_words(simulate, &[&urdf, &support, &log])), &[0]);
            fs::copy(&log, &other).unwrap();
            // The name of the folder is that of the robot in a fleet.
            let day = folder.path().join(format!("logs/robot={title}"));
            fs::create_dir_all(&day).unwrap();
            for end in ["", ".toml"] {
                let to = day.join(format!("monday.csv{end}"));
                fs::copy(format!("{log}{end}"), to).unwrap();
            }
            let (logs, table, poses) = (at("logs"), at("fleet.csv"), of("poses.csv"));
            let found = [
                in_words("fit @ --data @", &[&urdf, &log]),
                in_words("diagnose @ --data @", &[&urdf, &log]),
                in_words("compare @ @ --urdf @ @", &[&log, &other, &urdf, &support]),
                in_words(
                    "plan @ @ --poses 8 --cop-box 0.2 --out @",
                    &[&urdf, &support, &poses],
                ),
                in_words(
                    "fleet @ --data @ --by robot,day --out @",
                    &[&urdf, &logs, &table],
                ),
            ]
            .map(|command| {
                quiet(
                    &sesc(&[&command[..], &["--report", &page]].concat()),
                    &[0, 1],
                );
                let found = scripts(&page);
                let text = fs::read_to_string(&page).unwrap();
                assert!(
                    text.contains(&title.escape_debug().to_string()),
                    "{command:?}"
                );
                fs::remove_file(&page).unwrap();
                found
            });
            let table = fs::read_to_string(&table).unwrap();
            assert!(!table.contains(OBEYED) && table.contains(&title.escape_debug().to_string()));
            found
        },
    );
    assert_eq!(plain, hostile);
}

/// What a terminal obeys does not reach it from a file, nor from the name of one.
#[test]
#[cfg(unix)]
fn terminals_are_told_nothing_by_files() {
    let folder = Folder::empty();
    let title = "\u{1b}]0;owned\u{7}";
    folder.write(&format!("{title}r.urdf"), robot("r", &["j".into()]));
    let run = |line: &str, codes: &[i32]| quiet(&folder.run(&line.replace('@', title)), codes);
    run(
        "simulate @r.urdf --support r --poses 30 --out @log.csv",
        &[0],
    );
    run("fit @r.urdf --data @log.csv", &[0, 1]);
    run("fit @r.urdf --data @log.csv --json", &[0, 1]);
    run("inspect @none.urdf --support r", &[2]);
    let escaped = "\\u001b]0;owned\\u0007";
    let model = format!("hash = \"{escaped}\"\nsupport = \"{escaped}\"\nparameters = []\n");
    folder.write("m.toml", format!("robot = \"r\"\n{model}"));
    run("predict @r.urdf --model m.toml --data @log.csv", &[2]);
    let sidecar = format!("support = \"{escaped}\"\nexperiment = \"{escaped}\"\n");
    folder.write(&format!("{title}log.csv.toml"), sidecar);
    run("diagnose @r.urdf --data @log.csv", &[2]);
}
