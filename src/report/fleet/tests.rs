//! The page of a small fleet.

use sesc_identify::fleet::summary::summary;
use sesc_identify::fleet::{Fleet, Row};

use super::*;

fn fleet() -> Fleet {
    let row = |robot: &str, day: &str, text: &str| -> Row {
        let json = format!(
            r#"{{"robot": "{robot}", "day": "{day}", "urdf_hash": "a", "support": "sole",
                "postures": 60, "independent": 60, "noise_floor": 0.00014, "held_out_rmse": 0.0002,
                "verdict": "named", "sentence": "", "effects": [{text}], "health": [],
                "params": [], "std": [], "inputs": ["0"], "error": null, "version": "0"}}"#
        );
        serde_json::from_str(&json).unwrap()
    };
    let offset = |value: f64| {
        format!(
            r#"{{"effect": "joint_offset", "target": "l_<knee>", "evidence": 90.0,
                "parameters": {{"offset_rad": {{"value": {value}, "std": 0.001}}}}}}"#
        )
    };
    let mut fleet = Fleet::default();
    for (k, robot) in ["r1", "r<2>", "r3", "r4"].iter().enumerate() {
        for day in ["1", "2"] {
            fleet
                .rows
                .push(row(robot, day, &offset(0.05 + 1e-4 * k as f64)));
        }
    }
    fleet
}

#[test]
fn the_page_says_what_robots_share_and_escapes_names() {
    let fleet = fleet();
    let summary = summary(&fleet.rows, &Default::default());
    let page = page(&fleet, &summary, "sesc fleet").unwrap();
    for text in [
        "4 robots share joint_offset:l_&lt;knee&gt;",
        "offset 2.87",
        "1 shared effect, no change",
    ] {
        assert!(page.contains(text), "{text}\n{page}");
    }
    assert!(!page.contains("<knee>") && !page.contains("r<2>"));
    assert_eq!(page.matches("<details id=").count(), 4);
    let text = text(&fleet, &summary);
    assert!(
        text.contains("4 robots, 8 rows") && text.contains("4 robots share"),
        "{text}"
    );
}
