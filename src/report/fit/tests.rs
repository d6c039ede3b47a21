//! The page and the console's account of a small fit.

use sesc_model::Snapping;

use super::{FitReport, Moved, Shown, corrections, page, text};
use crate::OP2_URDF;
use crate::report::tests::{says, still};
use sesc_identify::fit::Gathered;
use sesc_identify::fit::corrected::correct;
use sesc_identify::fit::prior::Prior;
use sesc_identify::fit::residuals::Residual;
use sesc_identify::fit::{Identification, Settings, identify};
use sesc_identify::logs::Block;
use sesc_identify::observations::Measurement;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_identify::skeleton::Skeleton;

/// Readings that CAD explains but for a few millimetres.
fn fit(robot: &Robot) -> Identification {
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut measurement = Measurement::new(robot, "r_sole", Snapping::default()).unwrap();
    let q = Simulator::new(&model.tree.dofs, Some(0.5), 1).batch(60);
    let mut block = Block {
        line: vec![1; 60],
        pose: (0..60).collect(),
        q,
        ..Block::default()
    };
    let rows = measurement.rows(&block).unwrap().matrix;
    let cop = rows.times(&model.cad_params().into());
    let off = |k: usize| 0.003 * (k as f64).sin();
    let reading = (0..60).map(|k| [cop[2 * k] + off(k), cop[2 * k + 1] + off(3 * k)]);
    block.reading = Some(reading.collect());
    let mut gathered = Gathered::new(model.base.params.len(), 5);
    let pushed = gathered.push(&mut measurement, &block, "log.csv", None);
    pushed.unwrap();
    let settings = Settings::new(Prior::named("cad", &model).unwrap());
    identify(&model, &["r_sole"], &gathered, &settings)
}

#[test]
fn the_page_stands_alone_says_the_numbers_and_escapes_names() {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut found = fit(&robot);
    found.robot = "op<2>".to_string();
    found.parameters[1].std = None;
    let prior = Prior::named("cad", &model).unwrap();
    let target = (found.estimate.params.as_slice(), found.masses.as_ref());
    let corrected = correct(&robot, &model, Snapping::default(), target, &prior, None).unwrap();
    let residual = |k: i64| Residual {
        pose: k,
        support: String::new(),
        measured: [0.01 * k as f64, 0.0],
        cad: [0.01 * k as f64, 0.004],
        fitted: [0.01 * k as f64, 0.001],
        q: vec![0.1 * (k % 7) as f64; 20],
    };
    let shown = Shown {
        residuals: (0..900).map(residual).collect(),
        correlation_matrix: found.correlation_matrix(),
        command: "sesc fit 'a<b>.urdf'".to_string(),
        used: vec![[0.0, 0.6]; 20],
        robot: Some(Moved {
            skeleton: Skeleton::of(&model, &robot.description, None),
            deviations: (0..21).map(|k| 0.5 * f64::from(k)).collect(),
        }),
    };
    let report = FitReport {
        found: &found,
        next_steps: &[],
        corrected: Some(&corrected),
        shown: Some(&shown),
    };
    let html = page(&report).unwrap();
    let words = [
        "op&lt;2&gt;",
        "sesc fit &#x27;a&lt;b&gt;.urdf&#x27;",
        "42 <small>of 43</small>",
        "not seen",
        "corrected URDF",
        "0.71 mm RMS per axis",
        "2.83 mm RMS per axis",
        "What moved most, in standard deviations: <code>",
        "0 of 20 use more than half of their range",
    ];
    says(&html, &words);
    // The robot and its gaps, six figures, and a bar for each joint.
    assert_eq!(html.matches("<svg ").count(), 3 + 6 + 20);
    assert!(!html.contains("NaN") && !html.contains("op<2>"));
    still(&html, 2);
    assert_eq!(html, page(&report).unwrap());
    let json = serde_json::to_value(&report).unwrap();
    assert_eq!(json["residuals"].as_array().unwrap().len(), 900);
    assert_eq!(json["correlation_matrix"][0][0], 1.0);
    assert!(json["corrected"]["links"][0]["mass"][1].is_number());
    assert_eq!(json["rank"], 42);

    let bare = FitReport {
        found: &found,
        next_steps: &[],
        corrected: None,
        shown: None,
    };
    let html = page(&bare).unwrap();
    says(&html, &["the readings are not at hand"]);
    let json = serde_json::to_value(&bare).unwrap();
    assert_eq!(json.get("residuals"), None);
    assert!(corrections(&corrected, false).contains("inertia is scaled"));
}

#[test]
fn the_console_counts_what_every_robot_hides() {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let said = text(&fit(&robot), &[], false);
    let joints = "along 20 joints mass moves to the parent";
    says(
        &said,
        &[joints, "the height of the CoM is known up to one constant"],
    );
    assert!(said.matches("cannot be seen").count() < 4, "{said}");
    // What the tutorial reads first stands first, the table after it and short.
    let place = |words: &str| {
        said.find(words)
            .unwrap_or_else(|| panic!("{words}: {said}"))
    };
    let first = [
        "lack of fit",
        "held-out error",
        "cannot be seen",
        "parameter ",
        "rank ",
    ];
    assert!(first.map(place).is_sorted(), "{said}");
    says(
        &said,
        &[
            "The parameters that moved most",
            "and 35 more: --long lists all",
        ],
    );
    let long = text(&fit(&robot), &[], true);
    says(&long, &["r_el_link.z "]);
    assert!(
        !long.contains("--long") && !long.contains("moved most"),
        "{long}"
    );
}
