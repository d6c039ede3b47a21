//! Names that were made to break out of where they are written: into Rust, C, CMake, JSON,
//! TOML, HTML, CSV and a terminal.

use std::fmt::Write as _;
use std::fs;
use std::process::{Command, Output};

use sesc_test_support::child::Child;
use sesc_test_support::command::{Folder, printed, refused, stdout};

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
        "a */ int evil; /*\n/* bar\n// x\n#define x\n#include \"/etc/passwd\"\n\"); exit(1); (\"",
        "{{ 7*7 }}\n{% raw %}\n</script><b id=hostile>\n<b id=hostile>\n=cmd|'/C calc'!A0",
        "# title\n* item\nl knee\n*/ \" <b id=hostile> ??/\na\u{200d}b\ne\u{301}",
        "\u{feff}a\n\u{a0}\n\u{200b}*/\u{200d}",
    ];
    let with_blanks = with_blanks.iter().flat_map(|names| names.split('\n'));
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
    let folder = Folder::empty();
    let names = names();
    let some: Vec<String> = names.iter().step_by(4).cloned().collect();
    let mut library = String::from("#![deny(warnings)]\n");
    let child = Child::new("hostile-names", "");
    let source = child.path("src").display().to_string();
    let mut c = Vec::new();
    for (k, name) in names.iter().enumerate() {
        // One of all names, four times, so that every name is a joint somewhere.
        let joints = match k {
            0..4 => names.iter().skip(k).step_by(4).cloned().collect(),
            _ => vec![name.clone(), some[k % some.len()].clone() + " 3"],
        };
        // The file's name goes into the header, too.
        let file: String = name.chars().filter(|c| *c != '/').take(40).collect();
        let urdf = folder.write(&format!("{file}{k}.urdf"), robot(name, &joints));
        let module = format!("robot_{k}");
        // A name that begins with a dash is an option unless it is joined.
        let support = format!("--support={name}");
        let generate = "generate @ @ --name @ --out @";
        quiet(
            &folder.run_on(generate, &[&urdf, &support, &module, &source]),
            &[0],
        );
        let _ = writeln!(library, "pub mod {module};");
        let scalar = ["f64", "f32", "fixed32"][k % 3];
        let layout = ["bare", "cmake", "platformio", "arduino"][k % 4];
        let in_c = format!("{generate} --lang c --scalar {scalar} --layout {layout}");
        let out = format!("c{k}");
        quiet(
            &folder.run_on(&in_c, &[&urdf, &support, &module, &out]),
            &[0],
        );
        let [include, source] = match layout {
            "bare" => ["", ""],
            "arduino" => ["/src", "/src"],
            _ => ["/include", "/src"],
        };
        let file = format!("c{k}{source}/{module}.c");
        c.push((format!("-Ic{k}{include}"), file));
    }
    for (include, file) in &c {
        let mut cc = Command::new("cc");
        cc.args("-std=c99 -trigraphs -pedantic -Wall -Wextra -Werror".split(' '));
        cc.args(["-Wbidi-chars=any", "-fsyntax-only", include, file]);
        printed(cc.current_dir(folder.path()));
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
    let folder = Folder::empty();
    let joints: Vec<String> = names().into_iter().filter(|name| carried(name)).collect();
    let name = "</script><b id=hostile>";
    for (k, joints) in joints.chunks(24).enumerate() {
        folder.write("r.urdf", robot(name, joints));
        let simulate = "simulate r.urdf --support @ --poses 80 --noise 0.0005 --range 20 --out @";
        stdout(&folder.run_on(simulate, &[name, &format!("log{k}.csv")]));
        let outputs = "--out model.toml --report page.html --urdf corrected.urdf";
        let json = folder.json(&format!("fit r.urdf --data log{k}.csv {outputs}"));
        assert_eq!(json["robot"], name);
        assert_eq!(folder.toml("model.toml")["support"].as_str(), Some(name));
        scripts(&folder.read("page.html"));
        // The corrected URDF has the names that it had.
        let corrected = folder.read("corrected.urdf");
        let document = roxmltree::Document::parse(&corrected).unwrap();
        let kept = |name: &String| {
            let mut nodes = document.descendants();
            nodes.any(|node| node.attribute("name") == Some(name.as_str()))
        };
        assert!(joints.iter().all(kept));
    }
}

/// The number of scripts of a page that names are no element of.
fn scripts(page: &str) -> usize {
    assert!(!page.contains("<b id=hostile") && !page.contains(OBEYED));
    assert!(page.trim_end().ends_with("</html>"));
    let ends = page.matches("</script").count();
    assert_eq!(page.matches("<script").count(), ends);
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
    let hostile = "*/\"</script><b_id=hostile> </script>??/ ]]>&amp;膝 =cmd|'{{%s --><!--";
    let hostile = hostile
        .split(' ')
        .map(|name| name.replace('_', " "))
        .collect();
    let plain: Vec<String> = (0..5).map(|k| format!("part {k}")).collect();
    let pages = |(names, title): (Vec<String>, &str)| {
        let folder = Folder::empty();
        let spelled = title.escape_debug().to_string();
        let [urdf, log, poses] = ["r.urdf", "log.csv", "poses.csv"].map(|n| format!("{title}{n}"));
        folder.write(&urdf, robot(&names[0], &names[1..5]));
        let support = format!("--support={}", names[0]);
        let simulate = "simulate @ @ --poses 60 --noise 0.0005 --range 20 --out @";
        quiet(&folder.run_on(simulate, &[&urdf, &support, &log]), &[0]);
        folder.write("other.csv", folder.read(&log));
        // The name of the folder is that of the robot in a fleet.
        for end in ["", ".toml"] {
            let text = folder.read(&format!("{log}{end}"));
            folder.write(&format!("logs/robot={title}/monday.csv{end}"), text);
        }
        let plan = "plan @ @ --poses 8 --cop-box 0.2 --report page.html --out @";
        let compare = "compare @ other.csv --urdf @ @ --report page.html";
        let fleet = "fleet @ --data logs --by robot,day --report page.html --out fleet.csv";
        let commands: [(&str, &[&str]); 5] = [
            ("fit @ --data @ --report page.html", &[&urdf, &log]),
            ("diagnose @ --data @ --report page.html", &[&urdf, &log]),
            (compare, &[&log, &urdf, &support]),
            (plan, &[&urdf, &support, &poses]),
            (fleet, &[&urdf]),
        ];
        let found = commands.map(|(line, values)| {
            quiet(&folder.run_on(line, values), &[0, 1]);
            let page = folder.read("page.html");
            assert!(page.contains(&spelled), "{line}");
            fs::remove_file(folder.join("page.html")).unwrap();
            scripts(&page)
        });
        let table = folder.read("fleet.csv");
        assert!(!table.contains(OBEYED) && table.contains(&spelled));
        found
    };
    assert_eq!(
        pages((plain, "")),
        pages((hostile, "\u{1b}[2J\u{202e}\u{7}"))
    );
}

/// What a terminal obeys does not reach it from a file, nor from the name of one.
#[test]
#[cfg(unix)]
fn terminals_are_told_nothing_by_files() {
    let folder = Folder::empty();
    let title = "\u{1b}]0;owned\u{7}";
    folder.write(&format!("{title}r.urdf"), robot("r", &["j".into()]));
    let run = |line: &str, codes: &[i32]| quiet(&folder.run(&line.replace('@', title)), codes);
    let simulate = "simulate @r.urdf --support r --poses 30 --out @log.csv";
    run(simulate, &[0]);
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
