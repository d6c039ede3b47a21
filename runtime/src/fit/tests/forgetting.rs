//! Forgetting, and what is not forgotten.

use super::*;

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
