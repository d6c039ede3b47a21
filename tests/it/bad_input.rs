//! Bad robots, logs and usage: exit code 2, the file, line and remedy named,
//! nothing written.

use std::fs;

use serde_json::Value;
use sesc_test_support::command::{ROOT, folder, in_words, op2, refused, sesc, stdout};

#[test]
fn bad_robots_and_usage_exit_with_two_and_write_nothing() {
    let folder = folder();
    let out = folder.path().join("out").display().to_string();
    let bad = format!("{ROOT}/tests/bad_urdf/everything_at_once.urdf");
    let generate = |urdf: &str, support: &str, name: &str| {
        sesc(&in_words(
            "generate @ --support @ --name @ --out @",
            &[urdf, support, name, &out],
        ))
    };
    refused(
        &generate(&bad, "base", "x"),
        &["everything_at_once.urdf:14", "axis is zero"],
    );
    refused(
        &generate(&op2(), "sole", "x"),
        &["no link `sole`", "has l_sole, r_sole, body_link"],
    );
    refused(
        &generate(&op2(), "r_sole", "2fast"),
        &["`2fast`", "`robot_2fast`"],
    );
    refused(&generate(&op2(), "r_sole", "fn"), &["`fn`"]);
    refused(&sesc(&["inspect", &op2()]), &["--support"]);
    refused(
        &sesc(&["inspect", "nowhere.urdf", "--support", "x"]),
        &["nowhere.urdf"],
    );
    refused(
        &sesc(&["verify", &op2(), "--support", "r_sole", "--samples", "0"]),
        &["--samples"],
    );
    refused(
        &sesc(&in_words(
            "generate @ --support r_sole --lang ada --out @",
            &[&op2(), &out],
        )),
        &["ada", "rust"],
    );
    let log = folder.path().join("log.csv");
    for (flag, value) in [
        ("--noise", "nan"),
        ("--noise", "-1"),
        ("--range", "0"),
        ("--poses", "0"),
    ] {
        let mut arguments = vec!["simulate".to_string(), op2(), "--support=r_sole".into()];
        if flag != "--poses" {
            arguments.push("--poses=5".into());
        }
        arguments.extend([
            format!("{flag}={value}"),
            format!("--out={}", log.display()),
        ]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        refused(&sesc(&arguments), &[flag]);
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing was written"
    );
}

/// What was settled when factor files were gathered cannot be asked for anew.
#[test]
fn factor_files_refuse_what_they_have_settled() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (urdf, log, part) = (
        format!("{ROOT}/robots/two_link/two_link.urdf"),
        at("log.csv"),
        at("a.part"),
    );
    let fit = |words: &[&str]| sesc(&[&["fit"], words].concat());
    stdout(&sesc(&in_words(
        "simulate @ --support foot --poses 40 --noise 0.001 --out @",
        &[&urdf, &log],
    )));
    let gather = [&urdf, "--data", &log, "--folds", "4", "--partial", &part];
    stdout(&fit(&gather));
    refused(
        &fit(&[&part, "--folds", "5"]),
        &["--folds 5", "in 4", "--partial"],
    );
    refused(
        &fit(&[&part, "--degrees"]),
        &["--degrees", "no angles", "--partial"],
    );
    refused(
        &fit(&[&part, "--no-snap"]),
        &["--no-snap", "right angles made exact"],
    );
    refused(&fit(&[&part, "--robust", "huber"]), &["--robust", "--data"]);
    let folds = |words: &[&str]| {
        let json: Value = serde_json::from_str(&stdout(&fit(words))).unwrap();
        json["folds"].as_u64()
    };
    assert_eq!(folds(&[&part, "--json"]), Some(4));
    assert_eq!(folds(&[&part, "--folds", "4", "--json"]), Some(4));
    // A log that is added is dealt as the parts are.
    let more = at("more.csv");
    stdout(&sesc(&in_words(
        "simulate @ --support foot --poses 40 --noise 0.001 --seed 2 --out @",
        &[&urdf, &more],
    )));
    assert_eq!(folds(&[&part, "--data", &more, "--json"]), Some(4));
    // Gathering settles nothing about these.
    for word in ["--noise", "--range"] {
        refused(
            &fit(&[&gather[..], &[word, "0.05"]].concat()),
            &[word, "--partial"],
        );
    }
}

/// Outputs go where a link points, and never in place of a folder or a device.
#[cfg(unix)]
#[test]
fn outputs_replace_neither_links_nor_folders() {
    let folder = folder();
    let (target, link) = (folder.path().join("t.csv"), folder.path().join("l.csv"));
    fs::write(&target, "pose,hip,cop_x,cop_y\n").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let simulate = |out: &str| {
        let urdf = op2();
        sesc(&in_words(
            "simulate @ --support r_sole --poses 2 --out @",
            &[&urdf, out],
        ))
    };
    assert!(simulate(&link.display().to_string()).status.success());
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(fs::read_to_string(&target).unwrap().starts_with("pose,"));
    refused(
        &simulate(&folder.path().display().to_string()),
        &["no regular file"],
    );
}
