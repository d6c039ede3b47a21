//! Formulas for what no effect explains, planted and found again.

use super::{Bench, NOISE, term};
use crate::diagnose::Follows;
use crate::diagnose::leftover::{Misfit, formula, strongest};
use crate::diagnose::problem::ALL;

const POSTURES: usize = 100;

#[test]
fn sines_and_powers_are_found_with_their_weights() {
    let bench = Bench::op2();
    let (dof, q) = (bench.model.dof(), bench.balanced(POSTURES, 3));
    let (knee, elbow) = (bench.joint("r_knee"), bench.joint("l_el"));
    type Planted<'a> = (&'a str, &'a dyn Fn(&[f64]) -> f64);
    let planted: [Planted; 4] = [
        ("sin(3 r_knee)", &|q| (3.0 * q[knee]).sin()),
        ("cos(4 l_el)", &|q| (4.0 * q[elbow]).cos()),
        ("sin(2 l_el)", &|q| (2.0 * q[elbow]).sin()),
        ("|r_knee|", &|q| q[knee].abs()),
    ];
    for (k, (name, f)) in planted.iter().enumerate() {
        let weight = [4e-3, -2.5e-3];
        let data = bench.read(&bench.world(), &q, k as u64, |_, q| {
            weight.map(|w| w * f(q))
        });
        let problem = bench.certain(data);
        let null = problem.fit(&[], None, ALL);
        let found = formula(&problem, &null);
        assert!(found.is_reported(), "{name}: {}", found.share);
        let first = &found.terms[0];
        assert_eq!(first.name, *name, "{}", found.text());
        assert_eq!(found.terms.len(), 1, "{}", found.text());
        // One regressor alone: its weight is known to σ / |f|.
        let squares: f64 = q.chunks(dof).map(|q| f(q).powi(2)).sum();
        for (told, truth) in first.weight.iter().zip(weight) {
            let pull = (told - truth) / (NOISE / squares.sqrt());
            assert!(pull.abs() < 3.5, "{name}: {}", found.text());
        }
        assert!((found.share - 1.0).abs() < 0.1, "{}", found.share);
        let text = found.text();
        let of_x = format!("x: {:+.2} mm {name}", 1e3 * first.weight[0]);
        assert!(text.starts_with(&of_x), "{text}");
        // Its mean apart, |q| is as much like cos(4 q).
        if name.starts_with("sin") {
            let (most, of, share) = strongest(&problem, &null).unwrap();
            assert!(most == *name && share > 0.5, "{most} {share}");
            let joint = if name.contains("knee") {
                "r_knee"
            } else {
                "l_el"
            };
            assert_eq!(of, Follows::Position(joint.to_string()));
        }
    }
}

#[test]
fn what_grows_along_the_log_is_told_by_its_place() {
    let bench = Bench::op2();
    let q = bench.balanced(POSTURES, 4);
    let data = bench.read(&bench.world(), &q, 1, |k, _| {
        [0.0, 5e-3 * k as f64 / (POSTURES - 1) as f64]
    });
    let problem = bench.certain(data);
    let found = formula(&problem, &problem.fit(&[], None, ALL));
    assert_eq!(found.terms.len(), 1, "{}", found.text());
    assert_eq!(found.terms[0].name, "place in the log");
    // Σ (k/99)² = 33.8: known to 0.09 mm.
    assert!((found.terms[0].weight[1] - 5e-3).abs() < 3.5 * 0.09e-3);
    assert!(found.terms[0].weight[0].abs() < 3.5 * 0.09e-3);
    // What an effect has taken is not left over.
    let drift = problem.fit(&[term(&problem, "sensor_drift", "-")], None, ALL);
    assert!(formula(&problem, &drift).terms.is_empty());
}

#[test]
fn noise_follows_nothing() {
    let bench = Bench::op2();
    for seed in 0..30 {
        let q = bench.balanced(60, seed);
        let problem = bench.problem(bench.log(&bench.world(), &q, seed), "tight");
        let null = problem.fit(&[], None, ALL);
        let misfit = Misfit::of(&problem, &null);
        assert!(!misfit.is_clear(), "{seed}: {misfit:?}");
        assert!(misfit.deviations().abs() < 4.0, "{seed}: {misfit:?}");
        let found = formula(&problem, &null);
        assert!(found.terms.is_empty(), "{seed}: {}", found.text());
        assert!(!found.is_reported());
    }
}

/// Free masses take their directions from what noise leaves.
#[test]
fn masses_are_not_expected_to_leave_their_part() {
    let bench = Bench::skew();
    let q = bench.postures(60, 1);
    let of = |prior: &str| {
        let problem = bench.problem(bench.log(&bench.world(), &q, 1), prior);
        Misfit::of(&problem, &problem.fit(&[], None, ALL))
    };
    // Flat CoP of two skewed joints sees six directions.
    assert!((of("free").expected - (120.0 - 6.0)).abs() < 1e-3);
    assert!(of("tight").expected > 115.0);
    assert!(of("free").chi2 < of("tight").chi2);
}
