//! Bad robots, logs and usage: exit code 2, the file, line and remedy named,
//! nothing written.

use std::fs;

use sesc_test_support::command::{Folder, ROOT};

#[test]
fn bad_robots_and_usage_exit_with_two_and_write_nothing() {
    let folder = Folder::with("op2");
    folder.refuses_each(
        "generate op2.urdf --support sole --name x --out out | no link `sole`
            | has l_sole, r_sole, body_link
         generate op2.urdf --support r_sole --name 2fast --out out | `2fast` | `robot_2fast`
         generate op2.urdf --support r_sole --name fn --out out | `fn`
         generate op2.urdf --support r_sole --lang ada --out out | ada | rust
         inspect op2.urdf | --support
         inspect nowhere.urdf --support x | nowhere.urdf
         verify op2.urdf --support r_sole --samples 0 | --samples
         simulate op2.urdf --support r_sole --poses 5 --out log.csv --noise=nan | --noise
         simulate op2.urdf --support r_sole --poses 5 --out log.csv --noise=-1 | --noise
         simulate op2.urdf --support r_sole --poses 5 --out log.csv --range=0 | --range
         simulate op2.urdf --support r_sole --poses=0 --out log.csv | --poses",
    );
    let bad = format!("{ROOT}/tests/bad_urdf/everything_at_once.urdf");
    let generate = format!("generate {bad} --support base --name x --out out");
    folder.refuses(&generate, &["everything_at_once.urdf:14", "axis is zero"]);
    assert_eq!(folder.names(), ["op2.urdf"], "nothing was written");
}

/// What was settled when factor files were gathered cannot be asked for anew.
#[test]
fn factor_files_refuse_what_they_have_settled() {
    let folder = Folder::with("two_link");
    for (log, seed) in [("log.csv", 1), ("more.csv", 2)] {
        let options = format!("--poses 40 --noise 0.001 --seed {seed} --out {log}");
        folder.stdout(&format!("simulate two_link.urdf --support foot {options}"));
    }
    folder.stdout("fit two_link.urdf --data log.csv --folds 4 --partial a.part");
    // Gathering settles nothing about noise and range.
    folder.refuses_each(
        "fit a.part --folds 5 | --folds 5 | in 4 | --partial
         fit a.part --degrees | --degrees | no angles | --partial
         fit a.part --no-snap | --no-snap | right angles made exact
         fit a.part --robust huber | --robust | --data
         fit two_link.urdf --data log.csv --folds 4 --partial a.part --noise 0.05 | --noise
            | --partial
         fit two_link.urdf --data log.csv --folds 4 --partial a.part --range 0.05 | --range
            | --partial",
    );
    // A log that is added is dealt as the parts are.
    for more in ["", "--folds 4", "--data more.csv"] {
        let json = folder.json(&format!("fit a.part {more}"));
        assert_eq!(json["folds"], 4, "{more}");
    }
}

/// Outputs go where a link points, and never in place of a folder or a device.
#[cfg(unix)]
#[test]
fn outputs_replace_neither_links_nor_folders() {
    let folder = Folder::with("op2");
    folder.write("t.csv", "pose,hip,cop_x,cop_y\n");
    std::os::unix::fs::symlink("t.csv", folder.join("l.csv")).unwrap();
    folder.simulate("--poses 2 --out l.csv");
    let link = fs::symlink_metadata(folder.join("l.csv")).unwrap();
    assert!(link.is_symlink());
    assert!(folder.read("t.csv").starts_with("pose,head_pan"));
    let simulate = "simulate op2.urdf --support r_sole --poses 2 --out";
    folder.refuses(
        &format!("{simulate} {}", folder.at("")),
        &["no regular file"],
    );
}
