//! What noise leaves, and what a planted gap goes with.

use super::{Bench, term};
use crate::diagnose::findings::Suspect;
use crate::diagnose::leftover::{Misfit, suspects};

const POSTURES: usize = 100;

/// Waves and powers of a joint, whose parts linear in it may be none.
#[test]
fn a_function_of_a_joint_goes_with_the_position_of_that_joint() {
    let bench = Bench::op2();
    let q = bench.balanced(POSTURES, 3);
    let (knee, elbow) = (bench.joint("r_knee"), bench.joint("l_el"));
    type Planted<'a> = (&'a str, &'a dyn Fn(&[f64]) -> f64);
    let planted: [Planted; 4] = [
        ("r_knee", &|q| (3.0 * q[knee]).sin()),
        ("l_el", &|q| (4.0 * q[elbow]).cos()),
        ("l_el", &|q| (2.0 * q[elbow]).sin()),
        ("r_knee", &|q| q[knee].abs()),
    ];
    for (seed, (joint, f)) in planted.iter().enumerate() {
        let data = bench.read(&bench.world(), &q, seed as u64, |_, q| {
            [4e-3, -2.5e-3].map(|weight| weight * f(q))
        });
        let problem = bench.certain(data);
        let fit = problem.fit(&[], None);
        assert!(Misfit::of(&problem, &fit).is_clear(), "{joint}");
        let found = suspects(&problem, &fit);
        let position = Suspect::Position(joint.to_string());
        assert_eq!(found[0].0, position, "{found:?}");
        // More than noise alone gives to anything, see below.
        assert!(found[0].1 > 0.5 && found.len() <= 3, "{found:?}");
    }
}

#[test]
fn what_grows_along_the_log_goes_with_its_place() {
    let bench = Bench::op2();
    let q = bench.balanced(POSTURES, 4);
    let data = bench.read(&bench.world(), &q, 1, |k, _| {
        [0.0, 5e-3 * k as f64 / (POSTURES - 1) as f64]
    });
    let problem = bench.certain(data);
    let found = suspects(&problem, &problem.fit(&[], None));
    assert_eq!(found[0].0, Suspect::Place, "{found:?}");
    // An effect that takes it leaves nothing.
    let drift = problem.fit(&[term(&problem, "sensor_drift", "-")], None);
    assert!(!Misfit::of(&problem, &drift).is_clear());
    let found = suspects(&problem, &drift);
    assert!(found.iter().all(|(_, share)| *share < 0.35), "{found:?}");
}

#[test]
fn noise_goes_with_nothing() {
    let bench = Bench::op2();
    for seed in 0..30 {
        let q = bench.balanced(60, seed);
        let problem = bench.problem(bench.log(&bench.world(), &q, seed), "tight");
        let null = problem.fit(&[], None);
        let misfit = Misfit::of(&problem, &null);
        assert!(!misfit.is_clear(), "{seed}: {misfit:?}");
        assert!(misfit.deviations().abs() < 4.0, "{seed}: {misfit:?}");
        let found = suspects(&problem, &null);
        assert!(found.iter().all(|(_, share)| *share < 0.5), "{found:?}");
    }
}

/// Free masses take their directions from what noise leaves.
#[test]
fn masses_are_not_expected_to_leave_their_part() {
    let bench = Bench::skew();
    let q = bench.postures(60, 1);
    let of = |prior: &str| {
        let problem = bench.problem(bench.log(&bench.world(), &q, 1), prior);
        Misfit::of(&problem, &problem.fit(&[], None))
    };
    // Flat CoP of two skewed joints sees six directions.
    assert!((of("free").expected - (120.0 - 6.0)).abs() < 1e-3);
    assert!(of("tight").expected > 115.0);
    assert!(of("free").chi2 < of("tight").chi2);
}
