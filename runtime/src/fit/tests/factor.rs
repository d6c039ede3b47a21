//! Going on from the factor of a batch fit.

use super::*;

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
    let squares = fed.residual_sum_of_squares();
    near(resumed.residual_sum_of_squares(), squares);
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
