//! Against closed forms; the root package compares with a batch fit.

use std::string::ToString;
use std::vec::Vec;

use super::*;

/// A reproducible number in (-1, 1).
fn number(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs().max(1e-300), "{a} {b}");
}

/// y = a + b x at x = 0 … n-1 with alternating errors ±e: textbook line.
fn line(n: usize, std: f64) -> (Estimator<f64, 2>, Vec<(f64, f64)>) {
    let mut estimator = Estimator::new();
    let points: Vec<_> = (0..n)
        .map(|i| {
            (
                i as f64,
                2.0 - 0.5 * i as f64 + 0.1 * (-1.0_f64).powi(i as i32),
            )
        })
        .collect();
    for (x, y) in &points {
        estimator.row(&[1.0, *x], *y, std).unwrap();
    }
    (estimator, points)
}

#[test]
fn a_straight_line_is_the_textbook_one() {
    let std = 0.3;
    let (estimator, points) = line(11, std);
    let n = points.len() as f64;
    let (x, y) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let xx: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let xy: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let slope = xy / xx;
    let rest: f64 = points
        .iter()
        .map(|p| (p.1 - y - slope * (p.0 - x)).powi(2))
        .sum();

    let [a, b] = estimator.params();
    close(b, slope, 1e-13);
    close(a, y - slope * x, 1e-13);
    close(
        estimator.residual_sum_of_squares(),
        rest / (std * std),
        1e-12,
    );
    assert_eq!(estimator.degrees_of_freedom(), 9.0);
    assert_eq!(estimator.postures(), 0);

    let s2 = std * std;
    let mut covariance = [[f64::NAN; 2]; 2];
    estimator.covariance(&mut covariance);
    close(covariance[1][1], s2 / xx, 1e-13);
    close(covariance[0][1], -x * s2 / xx, 1e-13);
    close(covariance[0][0], s2 * (1.0 / n + x * x / xx), 1e-13);
    assert_eq!(covariance[0][1], covariance[1][0]);
    close(estimator.variance(0).unwrap(), covariance[0][0], 1e-13);
    close(estimator.variance(1).unwrap(), covariance[1][1], 1e-13);
    assert_eq!(estimator.variance(2), None);

    let at = estimator.predict(&[1.0, 20.0]).unwrap();
    close(at.value, a + 20.0 * b, 1e-13);
    close(at.variance, s2 * (1.0 / n + (20.0 - x).powi(2) / xx), 1e-13);
}

#[test]
fn prior_and_data_meet_by_their_weights() {
    let mut estimator = Estimator::<f64, 1>::with_prior(&[10.0], &[2.0]).unwrap();
    assert_eq!(estimator.params(), [10.0]);
    assert_eq!(estimator.degrees_of_freedom(), 0.0);
    for value in [13.0, 14.0, 15.0] {
        estimator.row(&[1.0], value, 0.5).unwrap();
    }
    // Information 1/4 at 10 and 3·4 at 14.
    close(estimator.params()[0], (2.5 + 168.0) / 12.25, 1e-14);
    close(estimator.variance(0).unwrap(), 1.0 / 12.25, 1e-14);
    assert_eq!(estimator.degrees_of_freedom(), 3.0);
}

#[test]
fn a_correlated_prior_enters_by_its_factor() {
    // P⁻¹ = Fᵀ F with F = [2 1; 0 3] and mean (1, -1).
    let mut estimator = Estimator::<f64, 2>::new();
    estimator.row(&[2.0, 1.0], 2.0 * 1.0 - 1.0, 1.0).unwrap();
    estimator.row(&[0.0, 3.0], -3.0, 1.0).unwrap();
    let mut covariance = [[0.0; 2]; 2];
    estimator.covariance(&mut covariance);
    // (Fᵀ F)⁻¹ = [10 -2; -2 4] / 36.
    for (found, exact) in covariance.iter().flatten().zip([10.0, -2.0, -2.0, 4.0]) {
        close(*found, exact / 36.0, 1e-14);
    }
    assert_eq!(estimator.params(), [1.0, -1.0]);
}

#[test]
fn forgetting_weighs_by_age() {
    let lambda = 0.9;
    let mut estimator = Estimator::<f64, 1>::new().forgetting(lambda).unwrap();
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in 0..50 {
        let value = (i % 7) as f64;
        estimator
            .posture(&[[1.0], [0.0]], &[value, 0.0], &[1.0, 1.0])
            .unwrap();
        (sum, weights) = (lambda * sum + value, lambda * weights + 1.0);
    }
    close(estimator.params()[0], sum / weights, 1e-13);
    close(estimator.variance(0).unwrap(), 1.0 / weights, 1e-13);
    close(estimator.degrees_of_freedom(), 2.0 * weights - 1.0, 1e-12);
    assert_eq!(estimator.postures(), 50);
}

#[test]
fn what_is_forgotten_is_unobservable_again_and_a_prior_is_not_forgotten() {
    let (mean, std) = ([0.5, -0.25, 1.0], [0.1, 0.2, 0.4]);
    let mut bare = Estimator::<f64, 3>::new().forgetting(0.5).unwrap();
    let mut held = Estimator::with_prior(&mean, &std)
        .unwrap()
        .forgetting(0.5)
        .unwrap();
    let still = [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    for estimator in [&mut bare, &mut held] {
        estimator.row(&[0.0, 1.0, 0.0], 7.0, 0.1).unwrap();
        for _ in 0..1000 {
            estimator.posture(&still, &[2.0, 2.0], &[1.0, 1.0]).unwrap();
        }
    }
    // 2⁻¹⁰⁰⁰ of the reading is left: less than what counts.
    assert_eq!(bare.observable(), [true, false, false]);
    assert_eq!(bare.params(), [2.0, 0.0, 0.0]);
    assert_eq!(held.rank(), 3);
    for k in 1..3 {
        close(held.params()[k], mean[k], 1e-12);
        let share = std[k] * std[k] / held.variance(k).unwrap();
        assert!((0.5_f64.powi(3)..=1.0 + 1e-12).contains(&share), "{share}");
    }
}

#[test]
fn the_prior_is_never_more_than_itself() {
    let mut estimator = Estimator::<f64, 4>::with_prior(&[0.0; 4], &[1.0; 4])
        .unwrap()
        .forgetting(0.9)
        .unwrap();
    let nothing = [[0.0; 4]; 2];
    for _ in 0..200 {
        estimator.posture(&nothing, &[0.0; 2], &[1.0; 2]).unwrap();
        for k in 0..4 {
            let information = 1.0 / estimator.variance(k).unwrap();
            assert!((0.9_f64.powi(4)..1.0 + 1e-12).contains(&information));
        }
    }
}

#[test]
fn an_unobservable_column_stays_nominal_and_has_a_name() {
    // Column 2 = 2·column 0 - column 1; column 3 is never observable.
    let mut estimator = Estimator::<f64, 4>::with_nominal(&[0.0, 0.0, 0.3, 0.7]).unwrap();
    let mut seed = 1;
    for _ in 0..200 {
        let (a, b) = (number(&mut seed), number(&mut seed));
        let value = 1.5 * a - 0.5 * b;
        let row = [a, b, 2.0 * a - b, 0.0];
        estimator.row(&row, value, 1e-3).unwrap();
    }
    assert_eq!(estimator.observable(), [true, true, false, false]);
    assert_eq!(estimator.rank(), 2);
    assert_eq!(estimator.degrees_of_freedom(), 198.0);
    let params = estimator.params();
    for (found, exact) in params.iter().zip([0.9, -0.2, 0.3, 0.7]) {
        close(*found, exact, 1e-12);
    }
    let direction = estimator.unobservable_direction(2).unwrap();
    for (found, exact) in direction.iter().zip([-2.0, 1.0, 1.0, 0.0]) {
        assert!((found - exact).abs() < 1e-12);
    }
    let alone = estimator.unobservable_direction(3).unwrap();
    assert_eq!(alone, [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(estimator.unobservable_direction(0), None);
    assert_eq!(estimator.unobservable_direction(4), None);
    assert_eq!(estimator.variance(2), Some(f64::INFINITY));
    let mut covariance = [[0.0; 4]; 4];
    estimator.covariance(&mut covariance);
    assert_eq!(covariance[3], [0.0, 0.0, 0.0, f64::INFINITY]);

    // A row in the span of the data is known; any other is not.
    for row in [[1.0, 2.0, 1.0, 0.0], [1.0, 2.0, 0.0, 1e-3]] {
        let prediction = estimator.predict(&row).unwrap();
        assert_eq!(prediction.variance, f64::INFINITY);
    }
    let known = estimator.predict(&[0.3, 0.1, 0.5, 0.0]).unwrap();
    close(known.value, 0.4, 1e-12);
    assert!(known.variance < 1e-6);
    assert!(estimator.residual_sum_of_squares() < 1e-12);
}

#[test]
fn a_dependent_column_in_single_precision_is_unobservable_too() {
    let mut estimator = Estimator::<f32, 3>::new();
    let mut seed = 5;
    for _ in 0..5000 {
        let (a, b) = (number(&mut seed) as f32, number(&mut seed) as f32);
        let row = [a, b, 0.3 * a - 0.7 * b];
        estimator.row(&row, a + b, 1e-3).unwrap();
    }
    assert_eq!(estimator.observable(), [true, true, false]);
    for (found, exact) in estimator.params().into_iter().zip([1.0, 1.0, 0.0]) {
        assert!((found - exact).abs() < 1e-5, "{found}");
    }
}

#[test]
fn merging_is_feeding() {
    let rows: Vec<([f64; 3], f64)> = {
        let mut seed = 3;
        let mut draw = || number(&mut seed);
        (0..60)
            .map(|_| ([draw(), draw(), draw()], draw()))
            .collect()
    };
    let feed = |mut estimator: Estimator<f64, 3>, rows: &[([f64; 3], f64)]| {
        for (row, value) in rows {
            estimator.row(row, *value, 0.1).unwrap();
        }
        estimator
    };
    let start = Estimator::with_prior(&[0.1, 0.2, 0.3], &[1.0; 3]).unwrap();
    let all = feed(start.clone(), &rows);
    let mut half = feed(start, &rows[..25]);
    half.merge(&feed(
        Estimator::with_nominal(&[5.0, -4.0, 2.0]).unwrap(),
        &rows[25..],
    ))
    .unwrap();
    for k in 0..3 {
        close(half.params()[k], all.params()[k], 1e-12);
        close(half.variance(k).unwrap(), all.variance(k).unwrap(), 1e-12);
    }
    let residual = all.residual_sum_of_squares();
    close(half.residual_sum_of_squares(), residual, 1e-11);
    assert_eq!(half.degrees_of_freedom(), all.degrees_of_freedom());
}

#[test]
fn refused_input_changes_nothing() {
    let mut estimator = line(5, 1.0).0;
    let before = estimator.clone();
    let good = [1.0, 1.0];
    let bad = [
        ([f64::NAN, 1.0], 1.0, 1.0, Error::NotFinite),
        ([1.0, f64::INFINITY], 1.0, 1.0, Error::NotFinite),
        (good, f64::NEG_INFINITY, 1.0, Error::NotFinite),
        (good, 1.0, f64::NAN, Error::NotFinite),
        (good, 1.0, f64::INFINITY, Error::NotFinite),
        (good, 1.0, 0.0, Error::Std),
        (good, 1.0, -1.0, Error::Std),
        (good, 1.0, 1e-35, Error::OutOfRange),
        (good, 1.0, f64::from_bits(1), Error::OutOfRange),
        ([1e300, f64::MAX], 1.0, 1.0, Error::OutOfRange),
    ];
    for (row, value, std, error) in bad {
        assert_eq!(estimator.row(&row, value, std), Err(error));
        // As the second row of a posture: the first is not taken either.
        let refused = estimator.posture(&[good, row], &[1.0, value], &[1.0, std]);
        assert_eq!(refused, Err(error));
        assert_eq!(estimator, before);
    }
    assert_eq!(estimator.predict(&[f64::NAN, 0.0]), Err(Error::NotFinite));
    for lambda in [0.0, -1.0, 1.5, f64::NAN] {
        assert_eq!(estimator.forget(lambda), Err(Error::Forgetting));
        assert_eq!(estimator.clone().forgetting(lambda), Err(Error::Forgetting));
    }
    assert_eq!(estimator, before);
    type One = Estimator<f32, 1>;
    assert_eq!(One::with_nominal(&[f32::NAN]), Err(Error::NotFinite));
    assert_eq!(One::with_prior(&[0.0], &[0.0]), Err(Error::Std));
    assert_eq!(One::with_prior(&[0.0], &[1e-7]), Err(Error::OutOfRange));
    assert!(Error::Std.to_string().contains("not positive"));

    // Doubling itself, an estimator comes to the end of the scalar, not past it.
    let mut full = One::new();
    full.row(&[1.0], 1.0, 1e-6).unwrap();
    while full.merge(&full.clone()).is_ok() {}
    assert_eq!(full.params(), [1.0]);
}

#[test]
fn extreme_standard_deviations_are_weights_like_others() {
    let mut estimator = Estimator::<f64, 2>::new();
    estimator.row(&[1.0, 1.0], 5.0, 1e150).unwrap();
    estimator.row(&[1.0, 0.0], 1.0, 1e-20).unwrap();
    estimator.row(&[0.0, 1.0], 2.0, 1e20).unwrap();
    estimator.row(&[1.0, 1.0], 4.0, 1e-20).unwrap();
    let [a, b] = estimator.params();
    close(a, 1.0, 1e-14);
    close(b, 3.0, 1e-14);
    close(estimator.variance(1).unwrap(), 2e-40, 1e-12);
}

/// Numbers over the whole range that is taken, columns that nearly repeat, priors,
/// forgetting: whatever comes, the state stays finite.
fn torture<T: Scalar + core::fmt::Debug + PartialEq>(decades: f64) {
    let mut seed = 11;
    for round in 0..40 {
        let mut estimator = Estimator::<T, 8>::new();
        let mut taken = 0;
        for _ in 0..2000 {
            let mut draw = || {
                let size = 10.0_f64.powf(decades * number(&mut seed));
                T::from_f64(size * number(&mut seed).signum())
            };
            let mut row: [T; 8] = core::array::from_fn(|_| draw());
            row[5] = row[4];
            row[6] = row[1] + T::from_f64(1e-7) * row[2];
            let (value, std) = (draw(), draw().abs());
            taken += usize::from(estimator.row(&row, value, std).is_ok());
            if round % 4 == 1 {
                estimator.forget(T::from_f64(0.5)).unwrap();
            }
            let state = estimator.triangle.lines.iter().flatten();
            let state = state.chain(&estimator.triangle.weights);
            let mut state = state.chain(&estimator.triangle.values);
            assert!(state.all(|x| x.is_finite()) && estimator.residual.is_finite());
        }
        assert!(taken > 100, "{taken}");
    }
}

#[test]
fn the_state_stays_finite_whatever_is_fed() {
    torture::<f64>(40.0);
    torture::<f64>(300.0);
    torture::<f32>(8.0);
    torture::<f32>(30.0);
}

#[test]
fn memory_is_what_the_module_says() {
    fn bytes<T, const N: usize>() -> usize {
        (N * N + 5 * N + 74) * size_of::<T>()
    }
    assert!(size_of::<Estimator<f32, 43>>() <= bytes::<f32, 43>() + 40);
    assert!(size_of::<Estimator<f64, 43>>() <= bytes::<f64, 43>() + 40);
    assert_eq!(size_of::<Estimator<f64, 43>>(), bytes::<f64, 43>() + 40);
}

#[test]
fn no_parameters_at_all_are_no_accident() {
    let mut estimator = Estimator::<f64, 0>::with_prior(&[], &[])
        .unwrap()
        .forgetting(0.5)
        .unwrap();
    estimator
        .posture(&[[], []], &[1.0, 2.0], &[1.0; 2])
        .unwrap();
    assert_eq!((estimator.params(), estimator.rank()), ([], 0));
    assert_eq!(estimator.residual_sum_of_squares(), 5.0);
}

#[test]
fn roots_are_right_to_the_last_place() {
    for k in 0..4000 {
        let x = 1.7_f64.powi(k % 61 - 40) * (1.0 + f64::from(k) / 4001.0);
        let root = crate::Scalar::root(x);
        assert!((root / x.sqrt() - 1.0).abs() <= f64::EPSILON, "{x:e}");
        let (x, root) = (x as f32, crate::Scalar::root(x as f32));
        assert!((root / x.sqrt() - 1.0).abs() <= f32::EPSILON, "{x:e}");
    }
}

/// A factor is as good as its rows fed one by one.
#[test]
fn a_factor_is_what_its_rows_are() {
    let params = [0.1, -0.2, 0.3];
    let factor = [400.0, 30.0, -20.0, 0.0, 0.0, 150.0];
    let mut resumed = Estimator::<f64, 3>::resume(&params, &factor).unwrap();
    let mut fed = Estimator::with_nominal(&params).unwrap();
    for row in [[400.0, 30.0, -20.0], [0.0, 0.0, 150.0]] {
        let value = row.iter().zip(&params).map(|(x, r)| x * r).sum();
        fed.row(&row, value, 1.0).unwrap();
    }
    assert_eq!(resumed.observable(), [true, false, true]);
    for estimator in [&mut resumed, &mut fed] {
        estimator.row(&[1.0, 2.0, 0.5], 0.4, 1e-3).unwrap();
        estimator.row(&[0.3, -1.0, 0.5], 0.2, 1e-3).unwrap();
    }
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    for k in 0..3 {
        near(resumed.params()[k], fed.params()[k]);
        near(resumed.deviations()[k], fed.deviations()[k]);
    }
    near(
        resumed.residual_sum_of_squares(),
        fed.residual_sum_of_squares(),
    );
    assert_eq!(resumed.degrees_of_freedom(), fed.degrees_of_freedom());
}

#[test]
fn what_is_no_factor_is_refused() {
    let refused = |params: [f64; 2], factor: &[f64]| {
        Estimator::<f32, 2>::resume(&params, factor).unwrap_err()
    };
    let params = [0.1, 0.2];
    assert_eq!(refused(params, &[1.0, 0.0]), Error::Factor);
    assert_eq!(refused(params, &[-1.0, 0.0, 1.0]), Error::Factor);
    assert_eq!(refused(params, &[0.0, 1.0, 1.0]), Error::Factor);
    assert_eq!(refused(params, &[1.0, f64::NAN, 1.0]), Error::NotFinite);
    assert_eq!(refused(params, &[1.0, 1e300, 1.0]), Error::NotFinite);
    assert_eq!(refused([0.1, f64::NAN], &[1.0, 0.0, 1.0]), Error::NotFinite);
    assert_eq!(refused(params, &[1e10, 0.0, 1.0]), Error::OutOfRange);
}

/// About normal, of deviation one.
fn normal(seed: &mut u64) -> f64 {
    (0..12).map(|_| number(seed)).sum::<f64>() / 2.0
}

/// Slow sines with noise that keeps `rho` of itself from posture to posture; how wrong each
/// parameter is, over its deviation.
fn recording(rho: f64, seed: u64, count: usize) -> (Estimator<f64, 5>, Vec<f64>) {
    let truth = [0.1, -0.2, 0.3, 0.05, 0.4];
    let mut seed = seed;
    let mut estimator = Estimator::new();
    let mut noise = [normal(&mut seed), normal(&mut seed)];
    for k in 0..count {
        let wave = |j: usize| (0.003 * (j + 1) as f64 * k as f64 + j as f64).sin();
        let x: [f64; 5] = core::array::from_fn(wave);
        let y: [f64; 5] = core::array::from_fn(|j| wave(j + 5));
        for e in &mut noise {
            *e = rho * *e + (1.0 - rho * rho).sqrt() * normal(&mut seed);
        }
        let of = |row: &[f64; 5]| row.iter().zip(&truth).map(|(a, b)| a * b).sum::<f64>();
        let cop = [of(&x) + 1e-3 * noise[0], of(&y) + 1e-3 * noise[1]];
        estimator.posture(&[x, y], &cop, &[1e-3; 2]).unwrap();
    }
    let all = estimator.params().into_iter().zip(truth);
    let wrong = all.zip(estimator.lasting_deviations());
    let wrong = wrong.map(|((found, truth), std)| (found - truth) / std);
    let wrong = wrong.collect();
    (estimator, wrong)
}

/// n/n_eff of AR(1) noise is (1 + ρ)/(1 − ρ); deviations are as wide as errors are.
#[test]
fn postures_are_worth_what_the_noise_leaves_of_them() {
    for (rho, count) in [(0.0, 3000), (0.8, 6000), (0.95, 12_000)] {
        let (mut worth, mut square, mut parameters) = (Vec::new(), 0.0, 0.0);
        for seed in 0..24 {
            let (estimator, wrong) = recording(rho, seed, count);
            worth.push(count as f64 / estimator.independent_postures());
            square += wrong.iter().map(|e| e * e).sum::<f64>();
            parameters += wrong.len() as f64;
        }
        worth.sort_by(f64::total_cmp);
        let expected = (1.0 + rho) / (1.0 - rho);
        let median = worth[worth.len() / 2] / expected;
        let rms = (square / parameters).sqrt();
        assert!((0.8..1.5).contains(&median), "{rho}: {median}");
        assert!((0.7..1.2).contains(&rms), "{rho}: {rms}");
        if rho == 0.0 {
            assert_eq!(worth[worth.len() - 1], 1.0);
        }
    }
}

/// Under forgetting, old noise no longer counts.
#[test]
fn noise_that_lasted_once_is_forgotten() {
    let mut estimator = Estimator::<f64, 1>::new().forgetting(0.99).unwrap();
    let mut seed = 7;
    let mut feed = |estimator: &mut Estimator<f64, 1>, hold: usize, count: usize| {
        let mut value = 0.0;
        for k in 0..count {
            if k % hold == 0 {
                value = 1e-3 * normal(&mut seed);
            }
            estimator
                .posture(&[[1.0], [0.0]], &[value, 0.0], &[1e-3; 2])
                .unwrap();
        }
        estimator.independent_postures() / estimator.postures() as f64
    };
    assert!(feed(&mut estimator, 8, 4000) < 0.4);
    assert!(feed(&mut estimator, 1, 40_000) > 0.9);
}
