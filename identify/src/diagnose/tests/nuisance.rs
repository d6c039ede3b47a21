//! The marginalised evidence against the dense formula of a Gaussian.

use nalgebra::{DMatrix, DVector};

use super::gauss;
use crate::diagnose::nuisance::Nuisance;

const ROWS: usize = 14;
const PARAMS: usize = 5;
const DIRECTIONS: usize = 4;

/// Regressor, prior factor, deviations, two slopes and a gap: any numbers.
struct Case {
    rows: DMatrix<f64>,
    prior: DMatrix<f64>,
    std: DVector<f64>,
    slopes: DMatrix<f64>,
    gap: DVector<f64>,
}

impl Case {
    fn new(width: f64) -> Case {
        let mut gauss = gauss(1);
        let mut matrix = |r, c| DMatrix::from_fn(r, c, |_, _| gauss());
        Case {
            rows: matrix(ROWS, PARAMS),
            prior: matrix(PARAMS, DIRECTIONS) * width,
            slopes: matrix(ROWS, 2),
            gap: matrix(ROWS, 1).column(0).into_owned(),
            std: DVector::from_fn(ROWS, |k, _| 0.2 + 0.1 * (k % 4) as f64),
        }
    }

    fn nuisance(&self) -> Nuisance {
        Nuisance::of(self.whitened(&(&self.rows * &self.prior)))
    }

    fn whitened(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(x.nrows(), x.ncols(), |r, c| x[(r, c)] / self.std[r])
    }

    /// S + A P Aᵀ
    fn covariance(&self) -> DMatrix<f64> {
        let shift = &self.rows * &self.prior;
        DMatrix::from_diagonal(&self.std.map(|s| s * s)) + &shift * shift.transpose()
    }
}

fn close(a: f64, b: f64, relative: f64) {
    let scale = 1.0 + a.abs().max(b.abs());
    assert!((a - b).abs() <= relative * scale, "{a:e} is not {b:e}");
}

#[test]
fn chi2_and_projections_are_those_of_the_dense_covariance() {
    for width in [0.01, 0.3, 1.0, 20.0] {
        let case = Case::new(width);
        let nuisance = case.nuisance();
        let inverse = case.covariance().try_inverse().unwrap();
        let gap = case.whitened(&DMatrix::from_columns(std::slice::from_ref(&case.gap)));
        let gap = gap.column(0).into_owned();
        let slopes = case.whitened(&case.slopes);
        let dense = case.gap.dot(&(&inverse * &case.gap));
        close(gap.dot(&nuisance.project_out_one(&gap)), dense, 1e-9);
        let ours = slopes.tr_mul(&nuisance.project_out(&slopes));
        let dense = case.slopes.tr_mul(&(&inverse * &case.slopes));
        for (ours, dense) in ours.iter().zip(&dense) {
            close(*ours, *dense, 1e-9);
        }
        // log det (S + A P Aᵀ) = log det S + log det A
        let noise: f64 = case.std.iter().map(|s| 2.0 * s.ln()).sum();
        let dense = case.covariance().determinant().ln();
        close(nuisance.log_det + noise, dense, 1e-9);
        // The gain of a Kalman filter, and what it leaves unknown.
        let shift = &case.rows * &case.prior;
        let expected = shift.tr_mul(&(&inverse * &case.gap));
        let left = DMatrix::identity(DIRECTIONS, DIRECTIONS) - shift.tr_mul(&(&inverse * &shift));
        for k in 0..DIRECTIONS {
            close(nuisance.posterior_mean(&gap)[k], expected[k], 1e-9);
            for j in 0..DIRECTIONS {
                close(nuisance.covariance()[(k, j)], left[(k, j)], 1e-9);
            }
        }
        let directions = DIRECTIONS as f64 - left.trace();
        close(nuisance.directions(), directions, 1e-9);
        let shifted = &shift * &expected;
        let ours = nuisance.shift(&nuisance.posterior_mean(&gap));
        for (row, ours) in ours.iter().enumerate() {
            close(*ours, shifted[row] / case.std[row], 1e-9);
        }
    }
}

#[test]
fn without_a_prior_masses_take_nothing_and_with_a_wide_one_all_they_can() {
    let none = Case::new(1e-9);
    let gap = none.gap.component_div(&none.std);
    let rest = gap.dot(&none.nuisance().project_out_one(&gap));
    close(rest, gap.norm_squared(), 1e-12);
    assert!(none.nuisance().is_negligible());
    assert!(none.nuisance().directions() < 1e-12);
    let wide = Case::new(1e5);
    let seen = wide.whitened(&(&wide.rows * &wide.prior));
    let taken = seen.qr().q();
    let left = &gap - &taken * taken.tr_mul(&gap);
    let ours = wide.nuisance().project_out_one(&gap);
    assert!((ours - left).amax() < 1e-6);
    assert!(!wide.nuisance().is_negligible());
    close(wide.nuisance().directions(), DIRECTIONS as f64, 1e-6);
}

/// Rows that count nothing are as if they had never been logged.
#[test]
fn weights_of_rows_come_on_top() {
    let case = Case::new(0.5);
    let keep: Vec<f64> = (0..ROWS).map(|k| f64::from(u8::from(k >= 4))).collect();
    let mut fewer = Case::new(0.5);
    fewer.rows = case.rows.rows(4, ROWS - 4).into_owned();
    fewer.std = case.std.rows(4, ROWS - 4).into_owned();
    let gap = case.gap.component_div(&case.std);
    let kept = DVector::from_fn(ROWS, |k, _| gap[k] * keep[k]);
    let all = case.nuisance().reweighted(&keep);
    let few = fewer.nuisance();
    let own = gap.rows(4, ROWS - 4).into_owned();
    let fewer = own.dot(&few.project_out_one(&own));
    close(kept.dot(&all.project_out_one(&kept)), fewer, 1e-12);
    close(all.log_det, few.log_det, 1e-12);
}
