//! What the commands say and write of broken data.

use std::fs;

use serde_json::Value;
use sesc_test_support::command::{Folder, list, says, says_somewhere};

use super::log::{Log, NOISE_M, POSTURES};

/// The log in a folder.
fn case(log: &Log) -> Folder {
    let folder = Folder::with("op2");
    let mut sheet = log.recording().sheet(false);
    sheet.add("pose", |k| k.to_string());
    sheet.add("cop_x_std", |_| NOISE_M.to_string());
    sheet.add("cop_y_std", |_| NOISE_M.to_string());
    folder.write("log.csv", sheet.to_string());
    folder
}

/// A command with a page and a model file asked for.
fn line(command: &str) -> String {
    let outputs = "--report page.html --out model.toml";
    format!("{command} op2.urdf --support r_sole --data log.csv {outputs}")
}

fn kinds(found: &Value) -> Vec<&str> {
    let health = list(found, "/health").iter();
    health.map(|h| h["kind"].as_str().unwrap()).collect()
}

#[test]
fn neither_command_makes_anything_but_a_page_of_data_that_cannot_be_used() {
    let mut log = Log::of("r_sole", &[], |w| w, 80);
    log.cop.iter_mut().for_each(|y| y[1] = 0.0);
    let case = case(&log);
    for command in ["fit", "diagnose"] {
        let found = case.json_of(1, &line(command));
        assert_eq!(found["verdict"], "unusable");
        assert_eq!(found["health"][0]["kind"], "cop_axis_dead");
        assert_eq!(found["health"][0]["target"], "y");
        assert!(found["parameters"].is_null());
        let plain = case.run(&line(command));
        assert_eq!(plain.status.code(), Some(1));
        let said = String::from_utf8(plain.stdout).unwrap();
        says_somewhere(said, &["check the sensor's wiring"]);
        assert_eq!(case.names(), ["log.csv", "op2.urdf", "page.html"]);
        let page = case.read("page.html");
        let parts = ["data-view=", "cop axis dead, y", "CoP y, mm"];
        says(
            &page,
            &[&["These data cannot be used"][..], &parts].concat(),
        );
        assert!(!page.contains("NaN"), "{command}");
        fs::remove_file(case.join("page.html")).unwrap();
    }
    case.json_of(
        1,
        "fit op2.urdf --support r_sole --data log.csv --partial log.part",
    );
    assert!(!case.join("log.part").exists());
}

/// Half of the rows are at hand once more, some without contact and some far away: the fit
/// is that of the log without them, to the digit.
#[test]
fn a_fit_leaves_out_what_is_bad_and_is_that_of_the_rest() {
    let good = Log::of("r_sole", &[], |w| w, 81);
    let mut bad = good.clone();
    for k in 0..POSTURES / 2 {
        bad.q.push(good.q[k].clone());
        bad.cop.push(good.cop[k]);
    }
    for (k, cop) in [
        (3, [0.0; 2]),
        (9, [0.0; 2]),
        (14, [0.0; 2]),
        (5, [2.0, 1.0]),
    ] {
        bad.q.push(good.q[k].iter().map(|q| q + 0.01).collect());
        bad.cop.push(cop);
    }
    let (good, bad) = (case(&good), case(&bad));
    let of_good = good.json(&line("fit"));
    assert_eq!(kinds(&of_good), [""; 0]);
    assert!(!good.read("page.html").contains("The data themselves"));
    let of_bad = bad.json(&line("fit"));
    let left_out = ["contact_lost", "cop_outside_sole", "rows_copied"];
    assert_eq!(kinds(&of_bad), left_out);
    for key in "parameters rank postures held_out_rmse noise_floor".split(' ') {
        assert_eq!(of_bad[key], of_good[key], "{key}");
    }
    let page = bad.read("page.html");
    let (_, section) = page.split_once("The data themselves").unwrap();
    let (section, _) = section.split_once("<h2>").unwrap();
    assert_eq!(section.matches("<svg ").count(), 3);
    says(section, &["rows copied", "to the last digit"]);
}

/// What the stuck joint moves is left to the noise: masses come out as well as without it, and the
/// 0.3 mm that the log states are not called too much.
#[test]
fn a_fit_goes_on_beside_a_stuck_encoder() {
    let log = Log::of("r_sole", &[], |w| w, 82);
    for joint in ["r_ank_pitch", "r_hip_roll", "r_knee"] {
        let case = case(&log.clone().stuck(joint, 0.1));
        let found = case.json(&line("fit"));
        assert_eq!(kinds(&found), ["encoder_stuck"], "{joint}");
        assert_eq!(found["health"][0]["target"], joint);
        for parameter in list(&found, "/parameters") {
            let of = |key: &str| parameter[key].as_f64().unwrap();
            let off = (of("value") - of("cad")).abs();
            assert!(off < 4.0 * of("std") + 1e-4, "{parameter}");
        }
        case.stdout(&line("diagnose"));
        says(
            case.read("page.html"),
            &[&format!("{joint} as the CoP has it, °")],
        );
    }
}
