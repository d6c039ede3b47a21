//! Whatever is fed: refusals, extremes, memory.

use super::*;

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
