//! Logs as the diagnosis takes them: means, noise, places, worked out by hand.

use std::fmt::Write as _;

use super::{Bench, NOISE, diagnosed, gauss, says};
use crate::diagnose::Verdict;
use crate::logs::{LogSource, Options, ROOM, Readings, Samples};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::Postures;
use crate::observations::postures::gathering::MOST;

const HEADER: &str = "pose,hip,knee,cop_x,cop_y";

/// The log as a file with its sidecar, read.
fn read(log: &str, sidecar: &str, noise: Option<f64>) -> Result<Postures, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, log).unwrap();
    std::fs::write(folder.path().join("log.toml"), sidecar).unwrap();
    let options = Options {
        readings: Readings::Required,
        links: ["foot", "thigh", "shank"].map(String::from).to_vec(),
        support: Some("foot".into()),
        any_unit: true,
        ..Options::default()
    };
    let (model, log) = (Bench::skew().model, LogSource::from(&path));
    let dofs = model.tree.dofs.clone();
    let samples = Samples::of_joints(&log, dofs, &options, ROOM, &mut ());
    let read = samples.and_then(|samples| Postures::read(&samples, &model, (noise, 1e-4), &mut ()));
    read.map_err(|error| error.to_string())
}

/// A log of 300 postures, each read so often, twice as noisy on y.
fn noisy(bench: &Bench, readings: usize, seed: u64) -> String {
    let mut gauss = gauss(seed);
    let mut log = format!("{HEADER}\n");
    for (k, q) in bench.postures(300, 1).chunks(2).enumerate() {
        let [x, y] = bench.world().cop(q);
        for _ in 0..readings {
            let (x, y) = (x + NOISE * gauss(), y + 2.0 * NOISE * gauss());
            let _ = writeln!(log, "{k},{},{},{x},{y}", q[0], q[1]);
        }
    }
    log
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-14, "{a:e} is not {b:e}");
}

/// Three readings a pose, off their mean by −d, 0, d in x and twice that in y:
/// 3 (2 d² + 8 d²) over 3 · 2 · 2 degrees of freedom.
#[test]
fn repeated_readings_are_pooled() {
    let d = 1e-3;
    let rows = [
        (4, [-1.0, -2.0]),
        (4, [0.0, 0.0]),
        (9, [1.0, 2.0]),
        (9, [0.0, 0.0]),
        (9, [-1.0, -2.0]),
        // Back at the first pose.
        (4, [1.0, 2.0]),
        (11, [0.0, 0.0]),
        (11, [1.0, -2.0]),
        (11, [-1.0, 2.0]),
    ];
    let mut log = format!("{HEADER}\n");
    for (k, (pose, [x, y])) in rows.iter().enumerate() {
        let q = 0.01 * *pose as f64;
        // Encoders flicker, too.
        let knee = q + if k == 2 { 0.015 } else { 0.0 };
        let (x, y) = (0.02 + x * d, -0.01 + y * d);
        let _ = writeln!(log, "{pose},{q},{knee},{x},{y}");
    }
    let data = read(&log, "", None).unwrap();
    assert_eq!(data.pose, [4, 9, 11]);
    assert_eq!(data.postures, 3);
    assert_eq!(data.noise_source, NoiseSource::Repeats);
    for k in 0..3 {
        near(data.reading[2 * k], 0.02);
        near(data.reading[2 * k + 1], -0.01);
    }
    near(data.q[3], 0.09 + 0.005);
    let single = d * (30.0_f64 / 12.0).sqrt();
    near(data.noise, single / 3.0_f64.sqrt());
    let with_floor = (single * single / 3.0 + 1e-8).sqrt();
    near(data.noise_floor, with_floor);
    data.std.iter().for_each(|std| near(*std, with_floor));
}

/// Two sessions, both numbered from 0: postures of their own, and a word about it.
#[test]
fn sessions_numbered_alike_are_not_averaged() {
    let mut log = format!("{HEADER}\n");
    for (session, knee) in [(0, 0.1), (1, 0.4)] {
        for pose in 0..5 {
            let x = 0.01 * f64::from(1 + session);
            let hip = 0.05 * f64::from(pose);
            for _ in 0..2 {
                let _ = writeln!(log, "{pose},{hip},{knee},{x},0.02");
            }
        }
    }
    let data = read(&log, "", Some(NOISE)).unwrap();
    assert_eq!(data.pose, [0, 1, 2, 3, 4, 0, 1, 2, 3, 4]);
    assert_eq!(data.postures, 10);
    for k in 0..10 {
        near(data.q[2 * k + 1], if k < 5 { 0.1 } else { 0.4 });
        near(data.reading[2 * k], if k < 5 { 0.01 } else { 0.02 });
    }
    let words = "5 rows share the `pose` of an earlier row";
    says(&data.warnings[0], &[words]);
}

/// Five degrees of freedom on each axis, or nothing is known of the noise.
#[test]
fn few_repeats_do_not_make_a_noise() {
    let mut log = format!("{HEADER}\n");
    for k in 0..8 {
        let _ = writeln!(log, "{},0,0.1,{},0.01", k / 2, 0.01 + 1e-3 * (k % 2) as f64);
    }
    let data = read(&log, "", None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Residuals);
    let _ = writeln!(log, "4,0,0.1,0.01,0.01\n4,0,0.1,0.011,0.01");
    let data = read(&log, "", None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Repeats);
    // Pairs 1 mm apart in x alone: 5 · 0.5 mm² over 10.
    near(data.noise, (0.25e-6_f64 / 2.0).sqrt());
}

#[test]
fn stated_deviations_are_of_single_readings() {
    let header = format!("{HEADER},cop_x_std,cop_y_std");
    let hundred = "readings_per_pose = 100\n";
    // 4, 5 and 6 mm differ too much to be one number.
    let log = format!(
        "{header}\n1,0,0,0.01,0,0.004,0.002\n2,0,0.1,0.01,0,0.005,0.004\n3,0,0.2,0.01,0,0.006,0.009\n"
    );
    let data = read(&log, hundred, None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Stated);
    let floored = |x: f64| x.hypot(1e-4);
    let expected = [4e-4, 2e-4, 5e-4, 4e-4, 6e-4, 9e-4];
    for (std, expected) in data.std.iter().zip(expected) {
        near(*std, floored(expected));
    }
    let squares: f64 = expected.iter().map(|s| s * s).sum();
    near(data.noise, (squares / 6.0).sqrt());
    // 4.9 and 5.1 mm are two estimates of one: their mean square holds.
    let log = format!("{header}\n1,0,0,0.01,0,0.0049,0.003\n2,0,0.1,0.01,0,0.0051,0.003\n");
    let data = read(&log, hundred, None).unwrap();
    let alike = ((4.9e-4_f64.powi(2) + 5.1e-4_f64.powi(2)) / 2.0).sqrt();
    near(data.std[0], floored(alike));
    near(data.std[2], floored(alike));
    // Four rows of one pose: σ/√4.
    let rows = "\n1,0,0,0.01,0,0.004,0.004".repeat(4);
    let four = format!("{header}{rows}\n2,0,0,0,0,0.004,0.004\n");
    let data = read(&four, "", None).unwrap();
    near(data.std[0], floored(0.002));
    near(data.std[2], floored(0.004));
    // What the user says is of single readings, too, and rescales what the log says.
    let data = read(&log, hundred, Some(4e-3)).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Given);
    near(data.noise, 4e-4);
    let stated = ((alike * alike + 3e-4 * 3e-4) / 2.0).sqrt();
    near(data.std[0], floored(4e-4 / stated * alike));
    near(data.std[1], floored(4e-4 / stated * 3e-4));
}

/// σ of a reading: of a row that is the mean of 100 a tenth, of four rows half of that.
#[test]
fn a_given_noise_is_of_a_single_reading() {
    let once = format!("{HEADER}\n1,0,0,0.01,0\n2,0,0.1,0.01,0\n");
    let data = read(&once, "readings_per_pose = 100\n", Some(5e-3)).unwrap();
    near(data.noise, 5e-4);
    near(read(&once, "", Some(5e-3)).unwrap().noise, 5e-3);
    let rows = "\n1,0,0,0.01,0".repeat(4);
    let data = read(&format!("{HEADER}{rows}\n2,0,0,0,0\n"), "", Some(5e-3)).unwrap();
    near(data.std[0], 2.5e-3_f64.hypot(1e-4));
    near(data.std[2], 5e-3_f64.hypot(1e-4));
}

/// Pairs 4 mm apart where 1 mm is stated: the scatter is taken, and said.
#[test]
fn repeats_that_scatter_more_than_is_stated_are_believed() {
    let mut log = format!("{HEADER},cop_x_std,cop_y_std\n");
    for k in 0..20 {
        let [x, y] = [0.01, 0.02].map(|cop| cop + if k % 2 == 0 { -2e-3 } else { 2e-3 });
        let pose = k / 2;
        let q = 0.1 * f64::from(pose);
        let _ = writeln!(log, "{pose},0,{q},{x},{y},0.001,0.001");
    }
    let data = read(&log, "", None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Repeats);
    // Of a mean of two: √8 mm / √2.
    near(data.noise, 2e-3);
    says(&data.warnings[0], &["scatter 2.8 times"]);
}

#[test]
fn without_any_word_on_noise_free_masses_tell() {
    let bench = Bench::skew();
    let data = read(&noisy(&bench, 1, 1), "", None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Residuals);
    let problem = bench.problem(data, "tight");
    // Each axis has its own; a median of 300 sizes scatters by 6.7 %.
    let std = |axis: usize| 1.0 / problem.first().weight[axis];
    for axis in 0..2 {
        let expected = ((axis + 1) as f64 * NOISE).hypot(1e-4);
        assert!((std(axis) / expected - 1.0).abs() < 0.2, "{axis}");
        let own = problem.first().weight.iter().skip(axis).step_by(2);
        own.for_each(|w| near(w * std(axis), 1.0));
    }
    let floor = problem.first().data.noise.hypot(1e-4);
    near(problem.first().data.noise_floor, floor);
    let both = (std(0).powi(2) + std(1).powi(2)) / 2.0;
    near(both.sqrt(), floor);
}

/// Two readings each of 300 postures, twice as noisy on y: each axis has its own noise.
#[test]
fn repeats_tell_the_noise_of_each_axis() {
    let bench = Bench::skew();
    let data = read(&noisy(&bench, 2, 2), "", None).unwrap();
    assert_eq!(data.noise_source, NoiseSource::Repeats);
    let problem = bench.problem(data, "tight");
    for axis in 0..2 {
        // Of a mean of two, beside 0.1 mm.
        let expected = ((axis + 1) as f64 * NOISE / 2_f64.sqrt()).hypot(1e-4);
        let own = problem.first().weight.iter().skip(axis).step_by(2);
        for ratio in own.map(|w| w * expected) {
            assert!((ratio - 1.0).abs() < 0.15, "{axis}: {ratio}");
        }
    }
}

/// A log of any length: an even choice, the same every time, with its ends' places.
#[test]
fn long_logs_are_thinned_evenly() {
    const ROWS: usize = 9_001;
    let slope = 1e-6;
    let mut log = format!("{HEADER}\n");
    for k in 0..ROWS {
        let x = slope * k as f64;
        let _ = writeln!(log, "{},{},0.1,{x},0.01", 10 + k, 1e-5 * k as f64);
    }
    let data = read(&log, "", Some(NOISE)).unwrap();
    assert_eq!(data.postures, ROWS);
    assert!((MOST..=2 * MOST).contains(&data.len()), "{}", data.len());
    let steps: Vec<i64> = data.pose.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(steps.iter().all(|s| *s == steps[0]));
    assert_eq!(data.pose[0], 10);
    let layout = sesc_model::effects::PostureContext::with_joints(2);
    for (k, pose) in data.pose.iter().enumerate() {
        near(data.reading[2 * k], slope * (pose - 10) as f64);
        let place = data.posture_context[k * layout.len() + layout.place()];
        near(place, (pose - 10) as f64 / (ROWS - 1) as f64);
    }
    let mean = data.reading.iter().step_by(2).sum::<f64>() / data.len() as f64;
    let whole = slope * (ROWS - 1) as f64 / 2.0;
    assert!((mean - whole).abs() <= slope * steps[0] as f64);
    let again = read(&log, "", Some(NOISE)).unwrap();
    assert_eq!((again.pose, again.q), (data.pose, data.q));
    assert_eq!(again.reading, data.reading);
}

/// Whatever the stamps, rates of a polynomial of order 4 are known exactly, and accelerations of
/// one of order 3, on which orders agree; of one of order 4, to the hundredth that a swing whose
/// orders differ as much is freed of.
#[test]
fn rates_and_accelerations_come_from_rows_around() {
    // Rows are looked at 0.05 s apart.
    let times: Vec<f64> = (0..60)
        .map(|k| 0.06 * f64::from(k) + 0.009 * f64::from(k * k % 3))
        .collect();
    for (cubic, quartic, least, most) in [(0.5, 0.0, -1e-7, 1e-7), (0.0, 0.3, -1e-7, 0.01)] {
        let mut log = String::from("t,hip,knee,cop_x,cop_y\n");
        for t in &times {
            let s = t - 1.8;
            let hip = 0.1 + 0.2 * s - 0.15 * s * s + cubic * s.powi(3) + quartic * s.powi(4);
            let _ = writeln!(log, "{t},{hip},0.1,0.01,0.02");
        }
        let data = read(&log, "", Some(NOISE)).unwrap();
        let layout = sesc_model::effects::PostureContext::with_joints(2);
        let known = data.motion.unwrap().known;
        assert!(known[20..40].iter().all(|known| *known) && !known[0] && !known[59]);
        for (k, t) in times.iter().map(|t| t - 1.8).enumerate().take(40).skip(20) {
            let at = |entry: usize| data.posture_context[k * layout.len() + entry];
            let rate = 0.2 - 0.3 * t + 3.0 * cubic * t * t + 4.0 * quartic * t.powi(3);
            let acceleration = 6.0 * cubic * t + 12.0 * quartic * t * t - 0.3;
            let off = at(layout.rate(0)) - rate;
            assert!(off.abs() < 1e-9, "{off}");
            let off = at(layout.acceleration(0)) - acceleration;
            let part = off / acceleration;
            let is_within = (least..=most).contains(&part) || off.abs() < most.min(1e-7);
            assert!(is_within, "{part}");
            assert_eq!(at(layout.rate(1)), 0.0);
        }
    }
}

#[test]
fn a_drift_runs_from_the_least_time_to_the_largest() {
    let times = [3.0, 1.0, 5.0, 2.0, 4.0];
    let mut log = String::from("t,hip,knee,cop_x,cop_y\n");
    for (k, t) in times.iter().enumerate() {
        let _ = writeln!(log, "{t},0.{k},0.1,0.01,0.02");
    }
    let data = read(&log, "", Some(NOISE)).unwrap();
    let layout = sesc_model::effects::PostureContext::with_joints(2);
    for (k, t) in times.iter().enumerate() {
        let place = data.posture_context[k * layout.len() + layout.place()];
        near(place, (t - 1.0) / 4.0);
    }
}

#[test]
fn one_and_two_postures_are_no_reason_to_fail() {
    let bench = Bench::skew();
    for count in [1, 2] {
        let mut log = format!("{HEADER},cop_x_std,cop_y_std\n");
        for k in 0..count {
            let q = [0.1, 0.2 + 0.1 * k as f64];
            let [x, y] = bench.world().cop(&q);
            let _ = writeln!(log, "{k},{},{},{x},{y},0.001,0.001", q[0], q[1]);
        }
        let data = read(&log, "", None).unwrap();
        assert_eq!(data.len(), count);
        for prior in ["tight", "free"] {
            let found = diagnosed(&mut bench.problem(data.clone(), prior)).diagnosis;
            assert_eq!(found.verdict, Verdict::None, "{count} {prior}");
            assert!(found.baseline.rmse < 1e-12 && found.last.rmse.is_finite());
        }
    }
    // The same without a word on noise.
    let log = format!("{HEADER}\n1,0.1,0.2,0.05,0.01\n");
    let mut problem = bench.problem(read(&log, "", None).unwrap(), "tight");
    let found = diagnosed(&mut problem).diagnosis;
    assert!(found.steps.is_empty(), "{}", found.sentence);
}

#[test]
fn rows_on_another_foot_are_left_out_and_counted() {
    let log = "pose,support,hip,knee,cop_x,cop_y\n\
               1,foot,0,0.1,0.01,0.02\n2,shank,0,0.2,0.3,0.4\n3,foot,0,0.3,0.05,0.06\n";
    let data = read(log, "", Some(NOISE)).unwrap();
    assert_eq!(data.pose, [1, 3]);
    assert_eq!(data.reading, [0.01, 0.02, 0.05, 0.06]);
    assert_eq!(data.elsewhere.get("shank"), Some(&1));
    let refusal = read(&log.replace("foot", "thigh"), "", Some(NOISE)).unwrap_err();
    let words = ["no posture stands on `foot`", "another link by `support`"];
    says(refusal, &words);
}

#[test]
fn numbers_that_are_none_are_refused_by_place() {
    for (column, name) in ["hip", "knee", "cop_x", "cop_y"].iter().enumerate() {
        let mut cells = ["0.1", "0.2", "0.01", "0.02"];
        cells[column] = "inf";
        let log = format!("{HEADER}\n1,0,0,0,0\n2,{}\n", cells.join(","));
        let refusal = read(&log, "", None).unwrap_err();
        says(refusal, &["log.csv:3", name, "not finite", "mend"]);
    }
}
