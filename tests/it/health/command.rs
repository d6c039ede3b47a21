//! What the commands say and write of broken data.

use std::fmt::Write as _;
use std::process::Output;

use serde_json::Value;
use sesc_test_support::command::{folder, op2, sesc, write};
use tempfile::TempDir;

use super::log::{Log, NOISE_M, POSTURES};

/// The log as CSV.
fn csv(log: &Log) -> String {
    let mut text = format!(
        "pose,{},cop_x,cop_y,cop_x_std,cop_y_std\n",
        log.joints.join(",")
    );
    for (k, (q, cop)) in log.q.iter().zip(&log.cop).enumerate() {
        let q: Vec<String> = q.iter().map(f64::to_string).collect();
        let _ = writeln!(
            text,
            "{k},{},{},{},{NOISE_M},{NOISE_M}",
            q.join(","),
            cop[0],
            cop[1]
        );
    }
    text
}

struct Case {
    folder: TempDir,
    log: String,
}

impl Case {
    fn of(log: &Log) -> Case {
        let folder = folder();
        let log = write(folder.path(), "log.csv", csv(log));
        Case { folder, log }
    }

    /// With a page and a model file asked for.
    fn run(&self, command: &str, more: &[&str]) -> Output {
        let path = |name: &str| self.folder.path().join(name).display().to_string();
        let (op2, page, model) = (op2(), path("page.html"), path("model.toml"));
        let given = [command, &op2, "--support", "r_sole", "--data", &self.log];
        let wanted = ["--report", &page, "--out", &model];
        sesc(&[&given[..], &wanted, more].concat())
    }

    fn page(&self) -> Option<String> {
        std::fs::read_to_string(self.folder.path().join("page.html")).ok()
    }
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn neither_command_makes_anything_but_a_page_of_data_that_cannot_be_used() {
    let mut log = Log::of("r_sole", &[], |w| w, 80);
    log.cop.iter_mut().for_each(|y| y[1] = 0.0);
    let case = Case::of(&log);
    for command in ["fit", "diagnose"] {
        let output = case.run(command, &["--json"]);
        assert_eq!(output.status.code(), Some(1), "{command}");
        let found = json(&output);
        assert_eq!(found["verdict"], "unusable");
        assert_eq!(found["health"][0]["kind"], "cop_axis_dead");
        assert_eq!(found["health"][0]["target"], "y");
        assert!(found["parameters"].is_null());
        let plain = case.run(command, &[]);
        assert_eq!(plain.status.code(), Some(1));
        let said = String::from_utf8(plain.stdout).unwrap();
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(said.contains("check the sensor's wiring"), "{said}");
        let files = std::fs::read_dir(case.folder.path()).unwrap().count();
        assert_eq!(files, 2, "{command}");
        let page = case.page().unwrap();
        assert!(page.contains("These data cannot be used"), "{command}");
        assert!(page.contains("data-view="), "{command}: no robot");
        assert!(page.contains("cop axis dead, y") && page.contains("CoP y, mm"));
        assert!(!page.contains("NaN"), "{command}");
        std::fs::remove_file(case.folder.path().join("page.html")).unwrap();
    }
    let part = case.folder.path().join("log.part").display().to_string();
    let given = [
        "fit",
        &op2(),
        "--support",
        "r_sole",
        "--data",
        &case.log,
        "--partial",
        &part,
    ];
    assert_eq!(sesc(&given).status.code(), Some(1));
    assert!(!std::path::Path::new(&part).exists());
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
    let (good, bad) = (Case::of(&good), Case::of(&bad));
    let of_good = json(&good.run("fit", &["--json"]));
    assert_eq!(of_good["health"], serde_json::json!([]));
    assert!(!good.page().unwrap().contains("The data themselves"));
    let output = bad.run("fit", &["--json"]);
    assert_eq!(output.status.code(), Some(0));
    let of_bad = json(&output);
    let kinds: Vec<&str> = (of_bad["health"].as_array().unwrap().iter())
        .map(|h| h["kind"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["contact_lost", "cop_outside_sole", "rows_copied"]);
    for key in [
        "parameters",
        "rank",
        "postures",
        "held_out_rmse",
        "noise_floor",
    ] {
        assert_eq!(of_bad[key], of_good[key], "{key}");
    }
    let page = bad.page().unwrap();
    let (_, section) = page.split_once("The data themselves").unwrap();
    let (section, _) = section.split_once("<h2>").unwrap();
    assert_eq!(section.matches("<svg ").count(), 3);
    assert!(section.contains("rows copied") && section.contains("to the last digit"));
}

/// What the stuck joint moves is left to the noise: masses come out as well as without it.
#[test]
fn a_fit_goes_on_beside_a_stuck_encoder() {
    let mut log = Log::of("r_sole", &[], |w| w, 82);
    let knee = log.joints.iter().position(|name| name == "r_knee").unwrap();
    log.q.iter_mut().for_each(|q| q[knee] = 0.1);
    let case = Case::of(&log);
    let found = json(&case.run("fit", &["--json"]));
    assert_eq!(found["health"][0]["kind"], "encoder_stuck");
    assert_eq!(found["health"][0]["target"], "r_knee");
    for parameter in found["parameters"].as_array().unwrap() {
        let of = |key: &str| parameter[key].as_f64().unwrap();
        let off = (of("value") - of("cad")).abs();
        assert!(off < 4.0 * of("std") + 1e-4, "{parameter}");
    }
    let page = Case::of(&log);
    page.run("diagnose", &[]);
    let page = page.page().unwrap();
    assert!(page.contains("r_knee as the CoP has it, °"));
}

/// The log states 0.3 mm. What a fit tells the rows beside that is no noise of the log.
#[test]
fn noise_is_not_called_overstated_beside_a_stuck_encoder() {
    for joint in ["r_knee", "r_ank_pitch", "r_hip_roll"] {
        let mut log = Log::of("r_sole", &[], |w| w, 83);
        let at = log.joints.iter().position(|name| name == joint).unwrap();
        log.q.iter_mut().for_each(|q| q[at] = 0.1);
        let found = json(&Case::of(&log).run("fit", &["--json"]));
        let kinds: Vec<&str> = (found["health"].as_array().unwrap().iter())
            .map(|h| h["kind"].as_str().unwrap())
            .collect();
        assert_eq!(kinds, ["encoder_stuck"], "{joint}");
    }
}
