//! A plan asks for postures to reach again where nothing says what visits differ by.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_test_support::command::{Folder, list, number, says};
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::{Platform, Stage};

/// Without a log that has visits five postures are to come back at the end; a log whose visits
/// differ by 2 mm says what a posture is known to, and nothing needs to be asked for.
#[test]
fn a_plan_asks_for_revisits_until_a_log_knows_what_they_differ_by() {
    let folder = Folder::with("op2");
    let plan = |more: &str| {
        let options = "--poses 12 --candidates 100 --out poses.csv";
        folder.json(&format!("plan op2.urdf --support r_sole {options} {more}"))
    };
    let poses = |found: &serde_json::Value| -> Vec<usize> {
        let poses = list(found, "/revisits/poses").iter();
        poses.map(|pose| pose.as_u64().unwrap() as usize).collect()
    };
    // Named, and written where that is asked for.
    let found = plan("");
    assert_eq!(found["revisits"]["written"], false);
    assert_eq!(poses(&found).len(), 5);
    assert_eq!(folder.read("poses.csv").lines().count(), 13);
    let found = plan("--revisits 5");
    assert_eq!(found["revisits"]["written"], true);
    let again = poses(&found);
    let different: std::collections::BTreeSet<&usize> = again.iter().collect();
    assert_eq!(different.len(), 5, "{again:?}");
    let mut planned = folder.sheet("poses.csv");
    assert_eq!(planned.rows.len(), 17);
    for (row, pose) in planned.rows[12..].iter().zip(&again) {
        assert_eq!(*row, planned.rows[pose - 1]);
    }
    // Each posture four times in turn, 2 mm apart.
    let stage = Stage::new(Platform::Op2);
    let random = &mut ChaCha8Rng::seed_from_u64(3);
    planned.rows.truncate(12);
    let q = planned.numbers(&planned.names[1..]);
    let pose = (0..48).map(|k| (k % 12) as f64);
    let log = Recording {
        joints: planned.names[1..].to_vec(),
        pose: Some(pose.collect()),
        ..Recording::still(&stage, &stage.world(), [&q[..]; 4].concat(), 2e-3, random)
    };
    folder.write("log.csv", log.csv(false));
    let known = plan("--data log.csv");
    assert_eq!(poses(&known), [0; 0], "{}", known["revisits"]);
    let said = known["revisits"].to_string();
    says(said, &["visits of one posture differ by"]);
    // 72 degrees of freedom: to 8 %.
    let noise = number(&known, "/noise");
    assert!((noise / 2e-3 - 1.0).abs() < 0.3, "{noise}");
    assert_eq!(folder.read("poses.csv").lines().count(), 13);
    assert_eq!(poses(&plan("--revisits 0")), [0; 0]);
}
