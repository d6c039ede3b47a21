//! Header and source that two runs wrote are never taken for a pair.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use super::user::*;
use sesc_test_support::command::{ROOT, says, stderr, stdout, write};

/// Two packages of one name, whose functions have the same declarations: the masses differ.
fn two_runs(name: &str) -> [std::path::PathBuf; 2] {
    let folder = fresh(name);
    let urdf = fs::read_to_string(format!("{ROOT}/robots/two_link/two_link.urdf")).unwrap();
    let heavier = urdf.replacen("mass value=\"", "mass value=\"1", 1);
    assert_ne!(urdf, heavier);
    [("old", urdf), ("new", heavier)].map(|(run, urdf)| {
        let urdf = write(&folder, "a.urdf", urdf);
        let out = folder.join(run);
        generate(&out, &urdf, "foot", &["--name", "leg"]);
        out
    })
}

fn cc_in(folder: &Path, arguments: &[&str]) -> Output {
    cc(arguments).current_dir(folder).output().unwrap()
}

fn refused(output: &Output, word: &str) {
    assert!(!output.status.success(), "nothing was refused");
    says(stderr(output), &[word]);
}

#[test]
fn a_source_beside_the_header_of_another_run_does_not_compile() {
    let [old, new] = two_runs("pair_of_files");
    let compile = ["-c", "leg.c", "-o", "leg.o"];
    stdout(&cc_in(&old, &compile));
    for file in ["leg.h", "leg.c"] {
        let mixed = fresh(&format!("pair_of_files_{}", &file[4..]));
        for own in ["leg.h", "leg.c"] {
            let from = if own == file { &old } else { &new };
            fs::copy(from.join(own), mixed.join(own)).unwrap();
        }
        refused(&cc_in(&mixed, &compile), "generate both again");
    }
}

#[test]
fn a_program_does_not_link_with_the_library_of_another_run() {
    let [old, new] = two_runs("pair_of_objects");
    // As programs call it, and as those do that take its address.
    let main = "#include \"leg.h\"\n\nint main(void)\n{\n    int (*again)(void) = leg_selftest;\n    \
                return leg_selftest() + again();\n}\n";
    for folder in [&old, &new] {
        write(folder, "main.c", main);
        stdout(&cc_in(folder, &["-c", "leg.c", "-o", "leg.o"]));
        stdout(&cc_in(folder, &["-c", "main.c", "-o", "main.o"]));
        stdout(&cc_in(folder, &["main.o", "leg.o", "-lm", "-o", "main"]));
        run(&mut Command::new(folder.join("main")));
    }
    let mixed = ["main.o", "../new/leg.o", "-lm", "-o", "mixed"];
    refused(&cc_in(&old, &mixed), "leg_selftest_");
}
