//! Linear least squares on regressor rows, seed paper Eq. (1) and (5).
//!
//! ```text
//! Θ = Φ⁺ Y        Φ: 2N × p rows of the CoP, Y: readings
//! ```
//!
//! by singular values: directions the data cannot see (relative singular value
//! below [`UNSEEN`]) get the minimum-norm answer, zero.

use nalgebra::{DMatrix, DVector};

/// Singular values below this, relative to the largest, are not seen.
pub const UNSEEN: f64 = 1e-10;

/// A least-squares answer.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Parameters, m; minimum norm in unseen directions.
    pub params: DVector<f64>,
    /// Number of directions the data see.
    pub rank: usize,
    /// Largest over smallest seen singular value.
    pub condition_number: f64,
    /// Mean of |row · params − reading| over the data fitted: in-sample, m.
    pub in_sample_mae: f64,
}

/// Solve `rows · params ≈ readings`.
///
/// `None` when the rows are empty or the decomposition does not converge.
pub fn least_squares(rows: DMatrix<f64>, readings: &DVector<f64>) -> Option<Fit> {
    if rows.is_empty() {
        return None;
    }
    // Triangular factor first: the SVD then works on p × p.
    let (q, r) = rows.clone().qr().unpack();
    let svd = r.try_svd(true, true, f64::EPSILON, 0)?;
    let largest = svd.singular_values.max();
    let seen = |s: &&f64| **s > UNSEEN * largest;
    let rank = svd.singular_values.iter().filter(seen).count();
    let smallest = svd
        .singular_values
        .iter()
        .filter(seen)
        .copied()
        .fold(largest, f64::min);
    let params = svd
        .solve(&(q.transpose() * readings), UNSEEN * largest)
        .ok()?;
    let residuals = &rows * &params - readings;
    Some(Fit {
        rank,
        condition_number: largest / smallest,
        in_sample_mae: residuals.iter().map(|x| x.abs()).sum::<f64>() / residuals.len() as f64,
        params,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dependent_column_shares_the_weight_and_lowers_the_rank() {
        // y = 3 x; columns x and x again: minimum norm is 1.5 and 1.5.
        let rows = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 2.0, 2.0, -1.0, -1.0]);
        let fit = least_squares(rows, &DVector::from_vec(vec![3.0, 6.0, -3.0])).unwrap();
        assert_eq!(fit.rank, 1);
        assert!((fit.params - DVector::from_vec(vec![1.5, 1.5])).norm() < 1e-14);
        assert!(fit.in_sample_mae < 1e-14);
    }
}
