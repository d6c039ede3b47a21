//! What is written, for whatever robot: whole, the same every time, or refused.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use super::user::*;
use sesc_test_support::command::{Folder, ROOT, folder, says};
use sesc_test_support::trees::Urdf;

#[test]
fn names_of_robots_break_no_format() {
    let folder = fresh("names");
    let (_, library) = oddly_named(&folder, "arduino");
    let sentence = &properties(&library)["sentence"];
    assert_eq!(*sentence, odd_description(&folder));
}

#[test]
fn layouts_are_refused_where_they_cannot_be() {
    let folder = Folder::with("two_link");
    let generate = "generate two_link.urdf --support foot --out .";
    for (layout, name) in [("cmake", "test"), ("cmake", "m"), ("arduino", "Arduino")] {
        let line = format!("{generate} --lang c --layout {layout} --name {name}");
        folder.refuses(&line, &[layout, &format!("`{name}_robot`")]);
    }
    folder.refuses_each(
        "generate two_link.urdf --support foot --out . --lang rust --layout cmake | --layout
            | --lang c
         generate two_link.urdf --support foot --out . --layout bare | --layout | --lang c
         generate two_link.urdf --support foot --out . --lang c --layout meson | meson | cmake
            | platformio",
    );
    assert_eq!(folder.names(), ["two_link.urdf"]);
}

/// A file in the way of the last one: the others are not touched.
#[test]
fn packages_appear_whole_or_not_at_all() {
    let folder = Folder::with("two_link");
    let generate =
        "generate two_link.urdf --support foot --lang c --layout arduino --name legs --out out";
    for blocked in ["examples", "src/legs.c/inside"] {
        let path = folder.write(&format!("out/{blocked}"), "mine");
        folder.refuses(generate, &["cannot write"]);
        assert_eq!(files(&folder.join("out")), [blocked]);
        fs::remove_file(path).unwrap();
        let _ = fs::remove_dir(folder.join("out/src/legs.c"));
    }
    folder.stdout(generate);
    assert_eq!(files(&folder.join("out")).len(), 5);
}

#[test]
fn the_same_robot_gives_the_same_bytes() {
    let folder = folder();
    let two_link = format!("{ROOT}/robots/two_link/two_link.urdf");
    for layout in ["bare", "cmake", "platformio", "arduino"] {
        let more = ["--layout", layout, "--scalar", "f32", "--name", "legs"];
        let one = folder.path().join(layout);
        let two = folder.path().join("again").join(layout);
        let printed = generate(&one, &two_link, "foot", &more);
        generate(&two, &two_link, "foot", &more);
        let printed: BTreeSet<PathBuf> = printed.into_iter().collect();
        let there: BTreeSet<PathBuf> = files(&one).iter().map(|file| one.join(file)).collect();
        assert_eq!(printed, there, "every file is named on stdout");
        for file in files(&one) {
            let text = fs::read_to_string(one.join(&file)).unwrap();
            assert_eq!(text, fs::read_to_string(two.join(&file)).unwrap(), "{file}");
            assert!(text.ends_with('\n') && !text.ends_with("\n\n"), "{file}");
            assert!(!text.lines().any(|line| line.ends_with(' ')), "{file}");
        }
        assert_eq!(files(&one), files(&two));
    }
    assert_eq!(files(&folder.path().join("bare")), ["legs.c", "legs.h"]);
    let plain = folder.path().join("plain");
    generate(&plain, &two_link, "foot", &["--name", "legs"]);
    assert_eq!(files(&plain), ["legs.c", "legs.h"], "bare unless asked");
}

/// Keys and forms of <https://docs.platformio.org/en/latest/manifests/library-json/>.
#[test]
fn platformio_finds_what_its_manifest_names() {
    let folder = fresh("platformio");
    for scalar in ["f64", "f32", "fixed32"] {
        let library = folder.join(scalar);
        generate_op2(&library, "platformio", scalar);
        let there = "README.md include/op2_r_sole.h library.json src/op2_r_sole.c";
        assert_eq!(files(&library).join(" "), there);
        let manifest = fs::read_to_string(library.join("library.json")).unwrap();
        let manifest: Value = serde_json::from_str(&manifest).unwrap();
        assert_eq!(manifest["name"], NAME);
        assert_eq!(manifest["version"], VERSION);
        assert!((1..256).contains(&manifest["description"].as_str().unwrap().len()));
        assert_eq!(manifest["frameworks"], "*");
        assert_eq!(manifest["platforms"], "*");
        for keyword in manifest["keywords"].as_array().unwrap() {
            let allowed = |c: char| c.is_ascii_lowercase() || " -_.+".contains(c);
            assert!(keyword.as_str().unwrap().chars().all(allowed), "{keyword}");
        }
        let include = library.join(manifest["build"]["includeDir"].as_str().unwrap());
        let sources = library.join(manifest["build"]["srcDir"].as_str().unwrap());
        assert!(include.join(manifest["headers"].as_str().unwrap()).exists());
        let source = sources.join("op2_r_sole.c");
        compile_c(&source, &include, &library.join("package.o"));
    }
}

/// Boards have no double of 64 bits, or none in hardware: their layouts are in f32 unless the
/// scalar is said. Nobody's page and name stand in them.
#[test]
fn layouts_for_boards_are_in_f32_unless_told_otherwise() {
    let folder = Folder::with("two_link");
    let base = "generate two_link.urdf --support foot --lang c --name legs";
    for (layout, scalar, real, cores) in [
        ("arduino", "", "float", "architectures=*\n"),
        ("platformio", "", "float", ""),
        ("cmake", "", "double", ""),
        ("arduino", "f64", "double", "architectures=esp32,"),
        ("arduino", "fixed32", "int32_t", "architectures=*\n"),
    ] {
        let scalar = match scalar {
            "" => String::new(),
            scalar => format!("--scalar {scalar}"),
        };
        folder.stdout(&format!("{base} --layout {layout} {scalar} --out {layout}"));
        let is_arduino = layout == "arduino";
        let header = if is_arduino { "src" } else { "include" };
        let header = folder.read(&format!("{layout}/{header}/legs.h"));
        says(header, &[&format!("typedef {real} legs_real;")]);
        if is_arduino {
            let text = folder.read("arduino/library.properties");
            says(
                text,
                &[cores, "\nmaintainer=owner of two_link\n", "\nurl=\n"],
            );
        }
    }
}

/// Robot `a` on link `b_c` and robot `a_b` on link `c` come to one name.
#[test]
fn a_file_of_another_robot_is_not_replaced_without_a_word() {
    let folder = Folder::empty();
    let robot = |name: &str, link: &str| {
        let robot = Urdf::new(name)
            .link(link, 1.0, "0 0 0")
            .link("top", 2.0, "0 0 1");
        robot
            .revolute("j", [link, "top"], "0 0 0", "0 1 0", 1.0)
            .text()
    };
    folder.write("a.urdf", robot("a", "b_c"));
    folder.write("a_b.urdf", robot("a_b", "c"));
    for lang in ["c", "rust"] {
        let first = format!("generate a.urdf --support b_c --lang {lang} --out out");
        let other = format!("generate a_b.urdf --support c --lang {lang} --out out");
        folder.stdout(&first);
        let words = ["a_b_c.", "another robot or support", "--name or --out"];
        folder.refuses(&other, &words);
        // The same robot, changed, replaces its own; a name of one's own is a word.
        folder.write("a.urdf", robot("a", "b_c").replace("'2'", "'3'"));
        folder.stdout(&first);
        let said = folder.said(&format!("{other} --name a_b_c"));
        says(said, &["and is replaced"]);
        folder.stdout(&other);
        folder.write("a.urdf", robot("a", "b_c"));
    }
}
