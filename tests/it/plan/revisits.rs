//! A plan asks for postures to reach again where nothing says what visits differ by.

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_test_support::command::{folder, in_words, op2, sesc, stdout};

/// Without a log that has visits five postures are to come back at the end; a log whose visits
/// differ by 2 mm says what a posture is known to, and nothing needs to be asked for.
#[test]
fn a_plan_asks_for_revisits_until_a_log_knows_what_they_differ_by() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let [out, data, second] = ["poses.csv", "log.csv", "second.csv"].map(at);
    let op2 = op2();
    let plan = |out: &str, more: &[&str]| -> serde_json::Value {
        let words = in_words(
            "plan @ --support r_sole --poses 12 --candidates 100",
            &[&op2],
        );
        let all = [&words[..], &["--json", "--out", out], more].concat();
        serde_json::from_str(&stdout(&sesc(&all))).unwrap()
    };
    // Named, and written where that is asked for.
    let found = plan(&out, &[]);
    assert_eq!(found["revisits"]["written"], false);
    assert_eq!(found["revisits"]["poses"].as_array().unwrap().len(), 5);
    assert_eq!(std::fs::read_to_string(&out).unwrap().lines().count(), 13);
    let found = plan(&out, &["--revisits", "5"]);
    assert_eq!(found["revisits"]["written"], true);
    let again: Vec<usize> = found["revisits"]["poses"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pose| pose.as_u64().unwrap() as usize)
        .collect();
    let mut different = again.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), 5, "{again:?}");
    let text = std::fs::read_to_string(&out).unwrap();
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 17);
    for (row, pose) in rows[12..].iter().zip(&again) {
        assert_eq!(*row, rows[pose - 1]);
    }
    // Each posture four times in turn, 2 mm apart.
    let stage = sesc_test_support::stage::Stage::new(sesc_test_support::stage::Platform::Op2);
    let world = stage.world();
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
    std::fs::write(&data, log).unwrap();
    let known = plan(&second, &["--data", &data]);
    assert_eq!(
        known["revisits"]["poses"].as_array().unwrap().len(),
        0,
        "{}",
        known["revisits"]
    );
    let said = known["revisits"]["sentence"].as_str().unwrap();
    assert!(said.contains("visits of one posture differ by"), "{said}");
    // 72 degrees of freedom: to 8 %.
    let noise = known["noise"].as_f64().unwrap();
    assert!((noise / 2e-3 - 1.0).abs() < 0.3, "{noise}");
    let rows = std::fs::read_to_string(&second).unwrap().lines().count();
    assert_eq!(rows, 13);
    assert_eq!(
        plan(&second, &["--revisits", "0"])["revisits"]["poses"]
            .as_array()
            .unwrap()
            .len(),
        0
    );
}
