//! Files of a format that this version does not know, and TOML that is none: one sentence each,
//! however long the file's lines are.

use std::fs;
use std::process::Output;

use sesc_test_support::command::{Folder, refused, stderr, stdout};

/// A folder with the two-link robot and a log of it.
fn stage() -> Folder {
    let folder = Folder::with("two_link");
    folder.stdout("simulate two_link.urdf --support foot --poses 20 --noise 0.0005 --out log.csv");
    folder
}

/// What the reader of each kind of TOML says of `text`, and the file's name.
fn answers(folder: &Folder, text: &str) -> Vec<(&'static str, Output)> {
    let readers = [
        ("log.csv.toml", "fit --data log.csv"),
        ("prior.toml", "fit --data log.csv --prior prior.toml"),
        (
            "servos.toml",
            "generate --lang c --out out --servos servos.toml",
        ),
        ("model.toml", "generate --out out --model model.toml"),
        ("sesc.toml", "fit --data log.csv"),
    ];
    let answer = |(file, command): (&'static str, &str)| {
        folder.write(file, text);
        let output = folder.run(&format!("{command} --support foot two_link.urdf"));
        fs::remove_file(folder.join(file)).unwrap();
        (file, output)
    };
    readers.map(answer).into()
}

/// The first format may be said, although no file needs to; a newer one is refused.
#[test]
fn files_of_a_newer_format_are_refused_with_a_sentence() {
    let folder = stage();
    for (file, output) in answers(&folder, "format = 9\nwhat = 'nobody knows yet'\n") {
        let words = [
            file,
            "format 9",
            "reads formats up to 1",
            "take the version",
        ];
        refused(&output, &words);
    }
    for (file, output) in answers(&folder, "format = 1\n") {
        if file != "model.toml" {
            stdout(&output);
        }
    }
}

/// Messages do not repeat the file, and write a number with as many digits as tell it.
#[test]
fn long_lines_are_not_repeated() {
    let folder = stage();
    for text in [
        format!("x = [{}", "1,".repeat(400_000)),
        format!("support = {}", "\u{1b}".repeat(400_000)),
        format!("[links]\n{} = 'heavy'", "k".repeat(400_000)),
        format!("[joints.{}]\nzero = 1e300", "k".repeat(400_000)),
        format!("{} = 1", "k".repeat(400_000)),
    ] {
        for (file, output) in answers(&folder, &text) {
            let said = stderr(&output);
            assert!(said.len() < 4000, "{file}: {} bytes", said.len());
            assert!(!said.contains('\u{1b}'), "{file}");
        }
    }
    let [_, _, (_, servos), ..] = &answers(&folder, "[default]\nresolution = 1e300\n")[..] else {
        panic!("five readers")
    };
    refused(servos, &["resolution is 1e300"]);
    assert!(servos.stderr.len() < 300);
}
