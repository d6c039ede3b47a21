//! The estimator of the runtime against the batch fit, on the OP2 on its right sole.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc::OP2_URDF;
use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS as N, CAD_PARAMS, DOF};
use sesc_identify::fit::{Report, Request, fit};
use sesc_identify::logs::Table;
use sesc_identify::lsq::Factor;
use sesc_identify::lsq::{Estimate, solve};
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::{ModelFile, Snapping};
use sesc_runtime::fit::{Error, Estimator};

/// Noise of the CoP, m.
const STD: f64 = 1e-3;
/// The column of the constant height of r_0.
const HEIGHT: usize = 2;

type Row = [f64; N];
/// Joint positions and a reading of the CoP.
type Reading = ([f64; DOF], [f64; 2]);

/// Postures, and readings of a robot that is off its CAD by up to `off` m.
fn log(count: usize, seed: u64, off: f64) -> Vec<Reading> {
    let robot = Robot::parse(OP2_URDF, "op2.urdf").unwrap();
    let model = robot.model("r_sole", Snapping::default(), None).unwrap();
    let mut simulator = Simulator::new(&model.tree.dofs, None, seed);
    let truth: Row = core::array::from_fn(|k| CAD_PARAMS[k] + off * (k as f64).sin());
    let mut reading = || {
        let q: [f64; DOF] = simulator.posture().try_into().unwrap();
        (q, op2::cop(&q, &truth).map(|x| x + simulator.gauss(STD)))
    };
    (0..count).map(|_| reading()).collect()
}

/// Rows and noisy readings of `count` postures: x, y, x, y, …
fn data(count: usize, seed: u64) -> Vec<(Row, f64)> {
    let rows = |(q, cop): Reading| op2::regressor_cop(&q).into_iter().zip(cop);
    log(count, seed, 0.01).into_iter().flat_map(rows).collect()
}

fn dot(a: &Row, b: &Row) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn feed(estimator: &mut Estimator<f64, N>, data: &[(Row, f64)]) {
    for pair in data.chunks_exact(2) {
        let [(x, cop_x), (y, cop_y)] = [pair[0], pair[1]];
        let fed = estimator.posture(&[x, y], &[cop_x, cop_y], &[STD; 2]);
        fed.unwrap();
    }
}

/// Rows over `std` each, as a batch problem.
fn batch(data: &[(Row, f64)], std: impl Fn(usize) -> f64) -> (DMatrix<f64>, DVector<f64>) {
    (
        DMatrix::from_fn(data.len(), N, |i, k| data[i].0[k] / std(i)),
        DVector::from_fn(data.len(), |i, _| data[i].1 / std(i)),
    )
}

/// Rows of the prior `CAD_PARAMS` ± `std`, before those of the data.
fn with_prior(data: &[(Row, f64)], prior_std: f64) -> (DMatrix<f64>, DVector<f64>) {
    let prior = (0..N).map(|k| {
        let mut row = [0.0; N];
        row[k] = 1.0;
        (row, CAD_PARAMS[k])
    });
    let all: Vec<_> = prior.chain(data.iter().copied()).collect();
    batch(&all, |i| if i < N { prior_std } else { STD })
}

/// What `sesc fit` makes of weighted rows without a prior.
fn least_squares(rows: &DMatrix<f64>, readings: &DVector<f64>) -> Estimate {
    let mut factor = Factor::new(rows.ncols());
    factor.push(rows, readings, &vec![1.0; rows.nrows()]);
    solve(&factor, 1.0, &DVector::zeros(rows.ncols()), None)
}

#[track_caller]
fn agree(found: &Row, expected: &DVector<f64>, within: f64) {
    let worst = (DVector::from_row_slice(found) - expected).amax();
    println!("worst {worst:.1e} m");
    assert!(worst <= within, "worst {worst:.1e} m, not {within:.1e} m");
}

#[test]
fn without_a_prior_it_is_the_batch_fit() {
    let data = data(1000, 1);
    let mut estimator = Estimator::new();
    feed(&mut estimator, &data);
    let (rows, readings) = batch(&data, |_| STD);
    let fit = least_squares(&rows, &readings);
    assert_eq!((estimator.rank(), fit.rank), (42, 42));
    let unseen: Vec<_> = (0..N).filter(|k| !estimator.observable()[*k]).collect();
    assert_eq!(unseen, [HEIGHT]);
    // Both leave the unseen column, which is zero, at zero.
    agree(&estimator.params(), &fit.params, 1e-9);

    let residual = (&rows * &fit.params - &readings).norm_squared();
    let found = estimator.residual_sum_of_squares();
    assert!((found / residual - 1.0).abs() < 1e-9);
    assert_eq!(estimator.degrees_of_freedom(), 2000.0 - 42.0);
    assert_eq!(estimator.postures(), 1000);
    // χ² with 1958 degrees of freedom, four standard deviations.
    assert!((found / 1958.0 - 1.0).abs() < 4.0 * (2.0_f64 / 1958.0).sqrt());
}

#[test]
fn with_a_prior_it_is_the_augmented_batch_fit() {
    let data = data(1000, 2);
    let mut estimator = Estimator::with_prior(&CAD_PARAMS, &[0.02; N]).unwrap();
    feed(&mut estimator, &data);
    let (rows, readings) = with_prior(&data, 0.02);
    let svd = rows.clone().svd(true, true);
    let expected = svd.solve(&readings, 0.0).unwrap();
    agree(&estimator.params(), &expected, 1e-9);
    assert_eq!(estimator.params()[HEIGHT], CAD_PARAMS[HEIGHT]);

    let exact = (rows.transpose() * &rows).try_inverse().unwrap();
    let mut covariance = [[0.0; N]; N];
    estimator.covariance(&mut covariance);
    for (a, line) in covariance.iter().enumerate() {
        let variance = estimator.variance(a).unwrap();
        assert!((variance / line[a] - 1.0).abs() < 1e-12);
        for (b, found) in line.iter().enumerate() {
            let scale = (exact[(a, a)] * exact[(b, b)]).sqrt();
            assert!((found - exact[(a, b)]).abs() < 1e-9 * scale);
        }
    }
    // The rows of the CoM, not only those of the CoP, with their uncertainty.
    let [_, _, z] = op2::regressor(&[0.1; DOF]);
    let predicted = estimator.predict(&z).unwrap();
    let row = DVector::from_row_slice(&z);
    let variance = (row.transpose() * &exact * &row)[0];
    assert!((predicted.variance / variance - 1.0).abs() < 1e-9);
    assert!((predicted.value - dot(&z, &estimator.params())).abs() < 1e-14);
}

#[test]
fn a_million_rows_do_not_drift() {
    let data = data(1000, 3);
    let mut once = Estimator::new();
    feed(&mut once, &data);
    let mut often = Estimator::new();
    for _ in 0..500 {
        feed(&mut often, &data);
    }
    assert_eq!(often.postures(), 500_000);
    assert_eq!(often.rank(), 42);
    // The same data 500 times: the same parameters, 1/500 of the variance.
    let expected = DVector::from_row_slice(&once.params());
    agree(&often.params(), &expected, 1e-9);
    for k in (0..N).filter(|k| *k != HEIGHT) {
        let ratio = often.variance(k).unwrap() / once.variance(k).unwrap();
        assert!((500.0 * ratio - 1.0).abs() < 1e-9, "{k}: {ratio}");
    }
    let ratio = often.residual_sum_of_squares() / once.residual_sum_of_squares();
    assert!((ratio / 500.0 - 1.0).abs() < 1e-9);
}

/// Single precision against double on the same postures: largest difference of the
/// parameters over the standard deviation that noise leaves them.
fn single_precision(postures: usize, lambda: f64, seed: u64) -> (f64, f64) {
    let data = data(postures, seed);
    let lambda = lambda as f32;
    let single = Estimator::<f32, N>::with_prior(&CAD_PARAMS.map(|x| x as f32), &[0.02; N]);
    let mut single = single.unwrap().forgetting(lambda).unwrap();
    let double = Estimator::with_prior(&CAD_PARAMS, &[0.02; N]).unwrap();
    let mut double = double.forgetting(f64::from(lambda)).unwrap();
    feed(&mut double, &data);
    for pair in data.chunks_exact(2) {
        let rows = [pair[0].0, pair[1].0].map(|row| row.map(|x| x as f32));
        let cop = [pair[0].1 as f32, pair[1].1 as f32];
        single.posture(&rows, &cop, &[STD as f32; 2]).unwrap();
    }
    assert_eq!(single.rank(), N);
    let mut worst = (0.0, 0.0);
    for k in 0..N {
        let error = (f64::from(single.params()[k]) - double.params()[k]).abs();
        let std = double.variance(k).unwrap().sqrt();
        worst = (f64::max(worst.0, error), f64::max(worst.1, error / std));
    }
    println!("{postures} postures, λ = {lambda}: {worst:.1?} m, std");
    worst
}

#[test]
fn single_precision_is_far_below_the_noise() {
    let cases = [
        (1000, 1.0, 4, 0.01),
        (100_000, 0.9995, 5, 0.01),
        (100_000, 1.0, 5, 0.1),
    ];
    for (postures, lambda, seed, most) in cases {
        let (error, share) = single_precision(postures, lambda, seed);
        assert!(error < 1e-6 && share < most, "{error} m, {share} std");
    }
}

#[test]
fn forgetting_is_the_batch_fit_weighed_by_age() {
    let (data, lambda) = (data(1000, 8), 0.995_f64);
    let mut estimator = Estimator::new().forgetting(lambda).unwrap();
    feed(&mut estimator, &data);
    let age = |i: usize| 999 - i / 2;
    let (rows, readings) = batch(&data, |i| STD / lambda.powf(0.5 * age(i) as f64));
    let fit = least_squares(&rows, &readings);
    agree(&estimator.params(), &fit.params, 1e-9);
}

/// Column 10 all but repeats column 9: condition number above 1e6.
#[test]
fn an_ill_conditioned_problem_is_solved_as_by_qr() {
    let mut data = data(500, 9);
    for (i, (row, _)) in data.iter_mut().enumerate() {
        row[10] = row[9] + 1e-6 * (i as f64 * 1.7).sin();
        row[HEIGHT] = (i as f64 * 0.3).cos();
    }
    let mut estimator = Estimator::new();
    feed(&mut estimator, &data);
    let (rows, readings) = batch(&data, |_| STD);
    let singular = rows.clone().singular_values();
    let condition = singular.max() / singular.min();
    assert!((1e6..1e8).contains(&condition), "{condition:e}");
    let (q, r) = rows.clone().qr().unpack();
    let exact = r.solve_upper_triangular(&(q.transpose() * &readings));
    let exact = exact.unwrap();
    assert_eq!(estimator.rank(), N);
    // What rounding of the rows alone does to any answer: Wedin's bound (Higham,
    // Accuracy and Stability of Numerical Algorithms, Theorem 20.1).
    let rest = (&rows * &exact - &readings).norm() / singular.max();
    let bound = f64::EPSILON * condition * (exact.norm() + condition * rest);
    println!("condition {condition:.1e}, bound {bound:.1e} m");
    agree(&estimator.params(), &exact, bound);

    // And the residuals are as small as they can be.
    let residual = |params: &DVector<f64>| (&rows * params - &readings).norm_squared();
    let found = residual(&DVector::from_row_slice(&estimator.params()));
    assert!(found <= residual(&exact) * (1.0 + 1e-12));
}

#[test]
fn what_is_no_reading_is_refused() {
    let data = data(100, 10);
    let mut estimator = Estimator::with_prior(&CAD_PARAMS, &[0.02; N]).unwrap();
    feed(&mut estimator, &data);
    let before = estimator.clone();
    // Beyond 1e5 rad the sine is NaN, and so is the row.
    let lost = op2::regressor_cop(&[1e9; DOF]);
    let refused = estimator.posture(&lost, &[0.0; 2], &[STD; 2]);
    assert_eq!(refused, Err(Error::NotFinite));
    let rows = [data[0].0, data[1].0];
    let refused = estimator.posture(&rows, &[0.0, f64::NAN], &[STD; 2]);
    assert_eq!(refused, Err(Error::NotFinite));
    let refused = estimator.posture(&rows, &[0.0; 2], &[STD, 0.0]);
    assert_eq!(refused, Err(Error::Std));
    assert_eq!(estimator, before);

    // A reading that is worth nothing changes nothing, one that is exact all but holds.
    estimator.posture(&rows, &[0.5; 2], &[1e200; 2]).unwrap();
    assert_eq!(estimator.params(), before.params());
    let [x, y] = [0.01, 0.02];
    estimator.posture(&rows, &[x, y], &[1e-12; 2]).unwrap();
    for (row, reading) in rows.iter().zip([x, y]) {
        let predicted = estimator.predict(row).unwrap();
        assert!((predicted.value - reading).abs() < 1e-10);
        assert!(predicted.variance < 1e-22);
    }
}

/// `sesc fit` of a log, `prior` held and the noise told.
fn batch_fit(log: &[Reading], prior: &str) -> Report {
    let column = |of: &dyn Fn(&Reading) -> f64| -> Vec<f64> { log.iter().map(of).collect() };
    let mut table = Table::new("log.csv")
        .numbers("cop_x", column(&|row| row.1[0]))
        .numbers("cop_y", column(&|row| row.1[1]));
    for (j, joint) in op2::JOINT_NAMES.iter().enumerate() {
        table = table.numbers(joint, column(&|row| row.0[j]));
    }
    let mut request = Request::default();
    request.robot = Some(Arc::new(Robot::parse(OP2_URDF, "op2.urdf").unwrap()));
    request.logs = vec![table.into()];
    request.support = Some("r_sole".into());
    request.noise = Some(STD);
    // The target knows of no offset of readings.
    request.offset = Some(0.0);
    request.prior = prior.into();
    let report = fit(&request, &mut ()).unwrap();
    assert_eq!(report.identification.inflation, 1.0, "the noise is as told");
    report
}

/// A model file as it is read again.
fn written(report: &Report) -> ModelFile {
    let text = toml::to_string(&report.model_file).unwrap();
    let file = ModelFile::parse(&text, "model.toml").unwrap();
    assert_eq!(file.information, report.model_file.information);
    file
}

/// Half of a log in a batch, the other half on the robot: what a batch of all is.
#[test]
fn it_goes_on_from_a_model_file() {
    let log = log(600, 9, 1e-3);
    for prior in ["cad", "tight", "free"] {
        let (half, whole) = (batch_fit(&log[..300], prior), batch_fit(&log, prior));
        let file = written(&half);
        let params: Row = file.values().try_into().unwrap();
        let factor = file.information.as_ref().unwrap().packed();
        let mut estimator = Estimator::<f64, N>::resume(&params, &factor).unwrap();
        for (q, reading) in &log[300..] {
            estimator
                .add_posture::<op2::Op2RSole>(q, reading, &[STD; 2])
                .unwrap();
        }
        let (found, std) = (estimator.params(), estimator.deviations());
        let expected = written(&whole);
        for (k, parameter) in expected.parameters.iter().enumerate() {
            let (name, value, found, std) = (&parameter.name, parameter.value, found[k], std[k]);
            let off = (found - value).abs();
            let most = 1e-9 * (value.abs() + parameter.std.unwrap_or(1.0));
            assert!(off < most, "{prior} {name}: {found} {value}");
            match parameter.std {
                Some(own) => assert!(
                    (std / own - 1.0).abs() < 1e-9,
                    "{prior} {name}: {std} {own}"
                ),
                None => assert_eq!((prior, std), ("free", f64::INFINITY), "{name}"),
            }
        }
    }
}

/// R of the file against its deviations, and the covariance that the fit states.
#[test]
fn a_model_file_holds_the_inverse_covariance() {
    for prior in ["cad", "tight"] {
        let report = batch_fit(&log(200, 10, 1e-3), prior);
        let file = written(&report);
        let rows = &file.information.as_ref().unwrap().factor;
        let factor = DMatrix::from_fn(N, N, |i, k| k.checked_sub(i).map_or(0.0, |k| rows[i][k]));
        let inverse = factor.try_inverse().unwrap();
        let covariance = &inverse * inverse.transpose();
        let stated = &report.identification.estimate.covariance;
        for (k, parameter) in file.parameters.iter().enumerate() {
            let std = parameter.std.unwrap();
            let off = (covariance[(k, k)].sqrt() / std - 1.0).abs();
            assert!(off < 1e-10, "{prior} {k}");
            for i in 0..N {
                let scale = (stated[(k, k)] * stated[(i, i)]).sqrt();
                let off = (covariance[(k, i)] - stated[(k, i)]).abs();
                assert!(off < 1e-8 * scale, "{prior} {k} {i}: {off:e} {scale:e}");
            }
        }
    }
}
