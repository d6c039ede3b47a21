//! Against closed forms; the root package compares with a batch fit.

mod correlation;
mod factor;
mod forgetting;
mod limits;

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
    let at = |i: f64| (i, 2.0 - 0.5 * i + 0.1 * (-1.0_f64).powf(i));
    let points: Vec<_> = (0..n).map(|i| at(i as f64)).collect();
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
    let x = points.iter().map(|p| p.0).sum::<f64>() / n;
    let y = points.iter().map(|p| p.1).sum::<f64>() / n;
    let xx: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let xy: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let slope = xy / xx;
    let rest = points.iter().map(|p| p.1 - y - slope * (p.0 - x));
    let rest: f64 = rest.map(|e| e * e).sum();

    let [a, b] = estimator.params();
    close(b, slope, 1e-13);
    close(a, y - slope * x, 1e-13);
    let squares = estimator.residual_sum_of_squares();
    close(squares, rest / (std * std), 1e-12);
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
        let row = |_| ([draw(), draw(), draw()], draw());
        (0..60).map(row).collect()
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
    let other = Estimator::with_nominal(&[5.0, -4.0, 2.0]).unwrap();
    half.merge(&feed(other, &rows[25..])).unwrap();
    for k in 0..3 {
        close(half.params()[k], all.params()[k], 1e-12);
        close(half.variance(k).unwrap(), all.variance(k).unwrap(), 1e-12);
    }
    let residual = all.residual_sum_of_squares();
    close(half.residual_sum_of_squares(), residual, 1e-11);
    // A prior of each of the three parameters is a reading of it.
    assert_eq!([&half, &all].map(Estimator::degrees_of_freedom), [60.0; 2]);
}
