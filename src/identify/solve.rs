//! Parameters and their covariance from a factor and a prior.
//!
//! ```text
//! data   ‖(R r − z) / σ‖²            prior   r = r_CAD + S u,  ‖u‖²
//! r = r_CAD + S u        u = argmin ‖(R S u − (z − R r_CAD)) / σ‖² + ‖u‖²
//! C = S (I + Sᵀ Rᵀ R S / σ²)⁻¹ Sᵀ
//! ```
//!
//! Without a prior the same by singular values of R: directions below
//! [`UNSEEN`] of the largest stay at CAD.

use nalgebra::{DMatrix, DVector};

use super::factor::Factor;

/// Singular values below this, relative to the largest, are not seen.
pub const UNSEEN: f64 = 1e-10;

/// What data and prior say together.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Base parameters, m.
    pub params: DVector<f64>,
    /// Covariance of what was estimated; unseen directions of a free fit have none.
    pub covariance: DMatrix<f64>,
    /// Directions that the data see.
    pub rank: usize,
    /// Largest over smallest singular value that the data see.
    pub condition_number: f64,
    /// Directions that the data do not see, as orthonormal columns: p × (p − rank).
    pub unseen: DMatrix<f64>,
}

/// Estimate from weighted rows (σ = 1 where weights are 1/σ already).
///
/// `prior` is the factor S of the prior covariance about `cad`.
pub fn solve(
    factor: &Factor,
    sigma: f64,
    cad: &DVector<f64>,
    prior: Option<&DMatrix<f64>>,
) -> Estimate {
    let p = factor.params();
    let svd = factor.r().svd(true, true);
    let largest = svd.singular_values.max();
    let seen = |k: &usize| svd.singular_values[*k] > UNSEEN * largest;
    let (seen, blind): (Vec<usize>, Vec<usize>) = (0..p).partition(seen);
    let v = svd
        .v_t
        .as_ref()
        .map_or_else(|| DMatrix::identity(p, p), DMatrix::transpose);
    let smallest = seen
        .iter()
        .map(|&k| svd.singular_values[k])
        .fold(largest, f64::min);
    let unseen = v.select_columns(&blind);
    let away = factor.z() - factor.r() * cad;
    let (params, covariance) = match prior {
        None => {
            let u = svd
                .u
                .as_ref()
                .map_or_else(|| DMatrix::identity(p, p), Clone::clone);
            let inverse = |k: usize| 1.0 / svd.singular_values[k];
            let mut half = v.select_columns(&seen);
            let mut step = DVector::zeros(p);
            for (to, &k) in seen.iter().enumerate() {
                let along = u.column(k).dot(&away) * inverse(k);
                step.axpy(along, &v.column(k), 1.0);
                half.column_mut(to).scale_mut(sigma * inverse(k));
            }
            (cad + step, &half * half.transpose())
        }
        Some(s) => {
            let m = s.ncols();
            let mut stacked = DMatrix::zeros(p + m, m);
            stacked.rows_mut(0, p).copy_from(&(factor.r() * s / sigma));
            stacked.rows_mut(p, m).fill_with_identity();
            let (q, r) = stacked.qr().unpack();
            let right = q.rows(0, p).transpose() * (away / sigma);
            // The identity below makes r regular, with singular values of one or more.
            let u = r.solve_upper_triangular(&right);
            let u = u.unwrap_or_else(|| DVector::zeros(m));
            let half = r.transpose().solve_lower_triangular(&s.transpose());
            let half = half.unwrap_or_else(|| DMatrix::zeros(m, p)).transpose();
            (cad + s * u, &half * half.transpose())
        }
    };
    Estimate {
        params,
        covariance,
        rank: seen.len(),
        condition_number: largest / smallest,
        unseen,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data() -> (DMatrix<f64>, DVector<f64>, Factor) {
        let matrix = DMatrix::from_fn(30, 3, |i, j| ((i * (j + 2)) as f64 * 0.37).sin());
        let reading = DVector::from_fn(30, |i, _| (i as f64 * 0.11).cos());
        let mut factor = Factor::new(3);
        factor.push(&matrix, &reading, &[1.0; 30]);
        (matrix, reading, factor)
    }

    /// Against the normal equations of the same problem.
    #[test]
    fn data_and_prior_weigh_as_their_variances() {
        let (matrix, reading, factor) = data();
        let cad = DVector::from_vec(vec![0.5, -0.5, 0.1]);
        let s = DMatrix::from_row_slice(3, 2, &[0.1, 0.0, 0.02, 0.3, 0.0, 0.05]);
        let sigma = 0.7;
        let found = solve(&factor, sigma, &cad, Some(&s));
        let a = &matrix * &s / sigma;
        let normal = a.transpose() * &a + DMatrix::identity(2, 2);
        let inverse = normal.try_inverse().unwrap();
        let u = &inverse * a.transpose() * (&reading - &matrix * &cad) / sigma;
        assert!((found.params - (&cad + &s * u)).norm() < 1e-13);
        let covariance = &s * inverse * s.transpose();
        assert!((found.covariance - covariance).norm() < 1e-14);
        assert_eq!(found.rank, 3);
    }

    #[test]
    fn what_data_do_not_see_stays_at_cad() {
        let (matrix, reading, _) = data();
        let mut blind = matrix.clone();
        let twice = blind.column(0) * 2.0;
        blind.set_column(2, &twice);
        let mut factor = Factor::new(3);
        factor.push(&blind, &reading, &[1.0; 30]);
        let cad = DVector::from_vec(vec![0.5, -0.5, 0.1]);
        let found = solve(&factor, 1.0, &cad, None);
        assert_eq!(found.rank, 2);
        // (2, 0, −1) is not seen: the estimate differs from CAD at right angles to it.
        let direction = DVector::from_vec(vec![2.0, 0.0, -1.0]);
        assert!(direction.dot(&(&found.params - &cad)).abs() < 1e-12);
        assert!((found.unseen.column(0).dot(&direction).abs() - direction.norm()).abs() < 1e-12);
        let residual = blind.transpose() * (&blind * &found.params - reading);
        assert!(residual.norm() < 1e-12);
    }
}
