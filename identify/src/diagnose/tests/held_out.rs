//! Held-out errors by what they are for: each posture predicted without itself.

use super::{Bench, NOISE, term};
use crate::diagnose::held_out::{apart, cross_validate, of_cad, parts};
use crate::diagnose::problem::Problem;
use crate::logs::{LogSource, Options, ROOM, Samples};
use crate::observations::postures::Postures;

/// Cross-validated errors with the effects named, none where there are none.
fn errors(problem: &Problem, effects: &[(&str, &str)]) -> crate::diagnose::findings::HeldOut {
    let terms: Vec<_> = effects
        .iter()
        .map(|(effect, target)| term(problem, effect, target))
        .collect();
    let fit = problem.fit(&terms, None);
    cross_validate(problem, &fit, &apart(problem, &fit))
}

/// Had a fold seen the posture it judges, its error would move by less.
#[test]
fn a_reading_has_no_say_in_its_own_prediction() {
    let bench = Bench::skew();
    let q = bench.postures(45, 1);
    let moved = 4e-3;
    for (prior, effects) in [
        ("tight", &[("sensor_offset", "-")][..]),
        ("tight", &[("ground_slope", "-"), ("joint_offset", "knee")]),
        ("cad", &[]),
        ("free", &[("sensor_rotation", "-")]),
    ] {
        let before = bench.log(&bench.world(), &q, 1);
        let plain = errors(&bench.problem(before.clone(), prior), effects);
        assert!(plain.errors.iter().all(|e| e.is_finite()));
        for pose in [0, 13, 44] {
            let mut data = before.clone();
            data.reading[2 * pose + 1] += moved;
            let after = errors(&bench.problem(data, prior), effects);
            let own = after.errors[2 * pose + 1] - plain.errors[2 * pose + 1];
            // The start of the fit has moved, its end only by what is settled.
            assert!((own / moved - 1.0).abs() < 1e-3, "{prior} {pose}: {own:e}");
        }
    }
}

/// In time, neighbours are held out together, in stretches of at least four times what
/// noise lasts: 100 postures of which 9 are worth one, 4.5 rows long, are 5 stretches.
#[test]
fn stretches_of_time_are_held_out() {
    let bench = Bench::skew();
    let q = bench.postures(100, 3);
    let mut data = bench.log(&bench.world(), &q, 3);
    let without = bench.problem(data.clone(), "tight");
    let every: Vec<usize> = (0..100).map(|k| k % 20).collect();
    assert_eq!(parts(&without), every);
    data.t = Some((0..100).map(f64::from).collect());
    let mut timed = bench.problem(data, "tight");
    let stretches = |count: usize| -> Vec<usize> { (0..100).map(|k| k * count / 100).collect() };
    assert_eq!(parts(&timed), stretches(20));
    timed.blocks[0].widened = [1.0, 3.0];
    assert_eq!(parts(&timed), stretches(5));
}

/// Readings of one pose are one posture, however they are spread over a log.
#[test]
fn folds_never_share_a_pose() {
    let bench = Bench::skew();
    let q = bench.postures(30, 2);
    let data = bench.log(&bench.world(), &q, 2);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    let mut log = String::from("pose,hip,knee,cop_x,cop_y\n");
    for repeat in 0..3 {
        for k in 0..30 {
            let off = (repeat as f64 - 1.0) * NOISE;
            let (x, y) = (data.reading[2 * k] + off, data.reading[2 * k + 1]);
            let (hip, knee) = (q[2 * k], q[2 * k + 1]);
            log += &format!("{k},{hip},{knee},{x},{y}\n");
        }
    }
    std::fs::write(&path, log).unwrap();
    let (log, options) = (LogSource::from(&path), Options::default());
    let dofs = bench.model.tree.dofs.clone();
    let samples = Samples::of_joints(&log, dofs, &options, ROOM, &mut ()).unwrap();
    // Of a single reading: the mean of three is known to NOISE.
    let noise = (Some(NOISE * 3.0_f64.sqrt()), 0.0);
    let pooled = Postures::read(&samples, &bench.model, noise, &mut ()).unwrap();
    assert_eq!(pooled.len(), 30);
    let once = errors(&bench.problem(data, "tight"), &[("sensor_offset", "-")]);
    let thrice = errors(&bench.problem(pooled, "tight"), &[("sensor_offset", "-")]);
    assert_eq!(once.errors.len(), thrice.errors.len());
    for (a, b) in once.errors.iter().zip(&thrice.errors) {
        assert!((a - b).abs() < 1e-9);
    }
}

/// An offset taken from the other n' postures adds σ²/n' to the mean square:
/// in the sample it would seem to take as much away.
#[test]
fn a_useless_effect_does_not_pay() {
    const LOGS: usize = 60;
    const POSTURES: usize = 40;
    let bench = Bench::skew();
    let mut more = 0.0;
    for seed in 0..LOGS as u64 {
        let q = bench.postures(POSTURES, seed);
        let problem = bench.certain(bench.log(&bench.world(), &q, seed));
        let with = errors(&problem, &[("sensor_offset", "-")]);
        let without = errors(&problem, &[]);
        assert!((without.gap.rmse - of_cad(&problem).gap.rmse).abs() < 1e-12);
        more += (with.gap.rmse.powi(2) - without.gap.rmse.powi(2)) / (NOISE * NOISE);
    }
    // 20 folds of 2; by two axes and 60 logs known to 2/n'/√120.
    let expected = 1.0 / (POSTURES as f64 - 2.0);
    let more = more / LOGS as f64;
    let std = 2.0 * expected / (2.0 * LOGS as f64).sqrt();
    assert!(
        (more - expected).abs() < 4.0 * std,
        "{more} is not {expected}"
    );
}

#[test]
fn the_numbers_are_those_of_the_errors_and_the_same_every_time() {
    let bench = Bench::skew();
    let q = bench.postures(30, 5);
    let world = bench.world().sensor_offset([0.004, -0.002]);
    let problem = bench.problem(bench.log(&world, &q, 5), "cad");
    let raw = of_cad(&problem).gap;
    let by_hand: Vec<f64> = q
        .chunks(2)
        .flat_map(|q| bench.world().cop(q))
        .zip(&problem.first().data.reading)
        .map(|(cop, y)| y - cop)
        .collect();
    let mean = |axis: usize| by_hand.iter().skip(axis).step_by(2).sum::<f64>() / 30.0;
    let square = |axis: usize| {
        let own = by_hand.iter().skip(axis).step_by(2);
        own.map(|e| e * e).sum::<f64>() / 30.0
    };
    for axis in 0..2 {
        assert!((raw.bias[axis] - mean(axis)).abs() < 1e-12);
        let rmse = [raw.rmse_x, raw.rmse_y][axis];
        assert!((rmse - square(axis).sqrt()).abs() < 1e-12);
    }
    assert!((raw.rmse - ((square(0) + square(1)) / 2.0).sqrt()).abs() < 1e-12);
    let effects = [("sensor_offset", "-")];
    assert_eq!(errors(&problem, &effects), errors(&problem, &effects));
}

/// Outliers are taken first where they are gross, and every posture looks like one until
/// the offset is known: each step is judged by the postures that count in the end.
#[test]
fn steps_join_where_outliers_come_before_a_large_effect() {
    let bench = Bench::op2();
    let slips = [5, 18, 31, 44];
    let world = bench.world().joint_offset("r_knee", 0.05).unwrap();
    let q = bench.balanced(80, 4);
    let data = bench.read(&world, &q, 3, |k, _| match slips.contains(&k) {
        true => [0.06, -0.05],
        false => [0.0; 2],
    });
    let found = bench.diagnose(data, "tight").diagnosis;
    let [first, second] = &found.steps[..] else {
        panic!("two effects, two steps: {}", found.sentence);
    };
    assert_eq!(first.effect, "cop_outliers");
    assert_eq!(second.effect, "joint_offset");
    assert!(first.rmse_before > 5e-3 && first.rmse_after < first.rmse_before);
    assert_eq!(first.rmse_after, second.rmse_before);
    // Without the slips the offset is still missing.
    assert!(first.rmse_after > 3e-3, "{}", first.rmse_after);
    assert!((second.rmse_after / NOISE - 1.0).abs() < 0.3);
    assert_eq!(second.rmse_after, found.last.rmse);
    assert_eq!(found.last.left_out, slips.len());
}
