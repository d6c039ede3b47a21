//! Noise of two widths, against its closed form and against planted foot-slips.

use nalgebra::DVector;

use super::{Bench, gauss, term};
use crate::diagnose::outliers::Outliers;

/// Noise of 100 postures, and `far` deviations on every `every`-th.
fn residual(seed: u64, every: usize, far: f64) -> DVector<f64> {
    let mut gauss = gauss(seed);
    DVector::from_fn(200, |row, _| {
        let slipped = every > 0 && (row / 2) % every == 3;
        let side = if row % 3 == 0 { -1.0 } else { 1.0 };
        gauss() + if slipped { side * far } else { 0.0 }
    })
}

#[test]
fn slips_are_found_one_by_one() {
    let mut extra = 0;
    for seed in 0..20 {
        let found = Outliers::of(residual(seed, 10, 12.0).as_slice(), None);
        let planted: Vec<usize> = (0..10).map(|k| 10 * k + 3).collect();
        let named = found.named();
        assert!(planted.iter().all(|k| named.contains(k)), "seed {seed}");
        // Of two thousand postures noise carries one beyond 3.7 deviations.
        extra += named.len() - planted.len();
        assert!((found.share - 0.1).abs() < 0.03, "{}", found.share);
        // Twelve deviations on each axis: 12² = ρ².
        assert!((found.width / 12.0 - 1.0).abs() < 0.15, "{}", found.width);
    }
    assert!(extra <= 4, "{extra}");
}

#[test]
fn clean_data_have_none() {
    for seed in 0..40 {
        let residual = residual(seed, 0, 0.0);
        let found = Outliers::of(residual.as_slice(), None);
        // A posture beyond 3.4 deviations is one in three hundred.
        let odd = |k: &usize| residual[2 * k].hypot(residual[2 * k + 1]) > 3.4;
        assert!(found.named().iter().all(odd), "seed {seed}");
        assert!(found.named().len() <= 2);
        assert!(found.share < 0.05, "seed {seed}: {}", found.share);
    }
}

#[test]
fn the_objective_is_that_of_the_mixture() {
    let residual = residual(5, 10, 8.0);
    let found = Outliers::of(residual.as_slice(), None);
    let (share, width) = (found.share, found.width);
    let weighted: f64 = residual
        .iter()
        .zip(found.root_weights(None))
        .map(|(e, w)| (e * w).powi(2))
        .sum();
    let density = |square: f64| {
        (1.0 - share) * (-0.5 * square).exp()
            + share / (width * width) * (-0.5 * square / (width * width)).exp()
    };
    let pairs = residual.as_slice().chunks(2);
    let expected: f64 = pairs
        .map(|e| -2.0 * density(e[0] * e[0] + e[1] * e[1]).ln())
        .sum();
    let ours = found.objective(residual.as_slice(), None, weighted);
    assert!((ours - expected).abs() < 1e-9 * expected);
    // Share and width are where it is least.
    for (share, width) in [
        (share * 1.2, width),
        (share / 1.2, width),
        (share, width * 1.2),
        (share, width / 1.2),
    ] {
        let beside = Outliers {
            share,
            width,
            ..found.clone()
        };
        let root = beside.root_weights(None);
        let weighted = residual.iter().zip(root).map(|(e, w)| (e * w).powi(2));
        let weighted = weighted.sum();
        assert!(beside.objective(residual.as_slice(), None, weighted) > ours);
    }
}

/// Postures that are left out have no say.
#[test]
fn only_what_is_kept_counts() {
    let mut residual = residual(1, 10, 12.0);
    let keep: Vec<bool> = (0..100).map(|k| k % 10 != 3).collect();
    let calm = Outliers::of(residual.as_slice(), Some(&keep));
    assert!(calm.share < 0.05);
    residual
        .iter_mut()
        .skip(2 * 13)
        .take(2)
        .for_each(|e| *e = 1e6);
    let same = Outliers::of(residual.as_slice(), Some(&keep));
    assert_eq!((calm.share, calm.width), (same.share, same.width));
    let root = same.root_weights(Some(&keep));
    assert!((0..200).all(|row| (root[row] == 0.0) != keep[row / 2]));
}

#[test]
fn slips_do_not_move_the_effect_beside_them() {
    let bench = Bench::op2();
    let q = bench.balanced(80, 4);
    let slips = [7, 19, 20, 33, 55, 71];
    let world = bench.world().joint_offset("r_knee", 0.03).unwrap();
    let data = bench.read(&world, &q, 3, |k, _| match slips.contains(&k) {
        true => [0.015, if k % 2 == 0 { 0.012 } else { -0.012 }],
        false => [0.0; 2],
    });
    let problem = bench.certain(data);
    let offset = term(&problem, "joint_offset", "r_knee");
    let outliers = term(&problem, "cop_outliers", "-");
    let fit = problem.fit(&[offset.clone(), outliers], None);
    assert_eq!(fit.outliers.as_ref().unwrap().named(), slips);
    let deviations = |fit: &crate::diagnose::problem::Fit| {
        (fit.unknowns[0] - 0.03).abs() / fit.covariance[(0, 0)].sqrt()
    };
    assert!(deviations(&fit) < 3.0, "{}", deviations(&fit));
    // Plain least squares follows the outliers.
    assert!(deviations(&problem.fit(&[offset], None)) > 5.0);
    let found = bench
        .diagnose(problem.first().data.clone(), "tight")
        .diagnosis;
    assert_eq!(found.outliers, slips.map(|k| k as i64));
}
