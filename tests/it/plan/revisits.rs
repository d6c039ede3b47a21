//! A plan asks for postures to reach again where nothing says what visits differ by.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_test_support::command::Folder;
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
        let poses = found["revisits"]["poses"].as_array().unwrap().iter();
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
    let text = folder.read("poses.csv");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 17);
    for (row, pose) in rows[12..].iter().zip(&again) {
        assert_eq!(*row, rows[pose - 1]);
    }
    // Each posture four times in turn, 2 mm apart.
    let world = Stage::new(Platform::Op2).world();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut log = format!("{},cop_x,cop_y\n", text.lines().next().unwrap());
    for _ in 0..4 {
        for row in &rows[..12] {
            let q: Vec<f64> = row.split(',').skip(1).map(|x| x.parse().unwrap()).collect();
            let cop = world.cop(&q).map(|x| x + 2e-3 * gauss());
            log += &format!("{row},{:.6},{:.6}\n", cop[0], cop[1]);
        }
    }
    folder.write("log.csv", log);
    let known = plan("--data log.csv");
    assert_eq!(poses(&known), [0; 0], "{}", known["revisits"]);
    let said = known["revisits"]["sentence"].as_str().unwrap();
    assert!(said.contains("visits of one posture differ by"), "{said}");
    // 72 degrees of freedom: to 8 %.
    let noise = known["noise"].as_f64().unwrap();
    assert!((noise / 2e-3 - 1.0).abs() < 0.3, "{noise}");
    assert_eq!(folder.read("poses.csv").lines().count(), 13);
    assert_eq!(poses(&plan("--revisits 0")), [0; 0]);
}
