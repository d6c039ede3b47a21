//! The information that data and a prior leave, as a triangular factor.
//!
//! ```text
//! RᵀR = Aᵀ A + Cₚ⁻¹        A rows over deviations, Cₚ = S Sᵀ the prior
//! ```
//!
//! A direction that the prior holds exactly (S has no column for it: massless links) is
//! entered as known to a micrometre, so that RᵀR has an inverse.

use crate::svd::svd;
use nalgebra::DMatrix;
use sesc_model::Information;

/// What is known exactly is known within a micrometre: far below what moves a CoP, and
/// within the range of single precision.
const EXACT_M: f64 = 1e-6;

/// Singular values below this, relative to the largest, are rounding.
const ROUNDING: f64 = 1e-12;

/// What is known of directions that `S` has no column for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beyond {
    /// All: the parameters there are the prior's.
    Exact,
    /// Nothing: the prior is a wide one on the directions that data see.
    Nothing,
}

/// The factor of `rows` (over their deviations) and of a prior with the factor `s`.
pub fn information(rows: &DMatrix<f64>, s: &DMatrix<f64>, beyond: Beyond) -> Information {
    let p = s.nrows();
    // As many columns as rows, so that U is complete.
    let mut square = DMatrix::zeros(p, p.max(s.ncols()));
    square.columns_mut(0, s.ncols()).copy_from(s);
    let svd = svd(square, true, false);
    let values = &svd.singular_values;
    let u = svd.u.unwrap_or_else(|| DMatrix::identity(p, p));
    let least = ROUNDING * values.max();
    let mut of_prior = DMatrix::zeros(p, p);
    let mut seen = DMatrix::identity(p, p);
    for (k, direction) in u.column_iter().enumerate() {
        let weight = match (values[k] > least, beyond) {
            (true, _) => 1.0 / values[k],
            (false, Beyond::Exact) => 1.0 / EXACT_M,
            (false, Beyond::Nothing) => {
                seen -= direction * direction.transpose();
                0.0
            }
        };
        of_prior.set_row(k, &(direction.transpose() * weight));
    }
    let rows = match beyond {
        Beyond::Exact => rows.clone(),
        Beyond::Nothing => rows * seen,
    };
    let rows = match rows.nrows() > p {
        true => rows.qr().r(),
        false => rows,
    };
    let n = rows.nrows();
    let mut all = DMatrix::zeros(p + n, p);
    all.rows_mut(0, p).copy_from(&of_prior);
    all.rows_mut(p, n).copy_from(&rows);
    Information::of(&all)
}

/// The factor of `rows` alone, less the directions `unseen` (orthonormal columns).
pub fn of_rows(rows: &DMatrix<f64>, unseen: &DMatrix<f64>) -> Information {
    Information::of(&(rows - (rows * unseen) * unseen.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squared(information: &Information) -> DMatrix<f64> {
        let n = information.factor.len();
        let factor = DMatrix::from_fn(n, n, |i, k| match k.checked_sub(i) {
            Some(at) => information.factor[i][at],
            None => 0.0,
        });
        factor.tr_mul(&factor)
    }

    fn rows() -> DMatrix<f64> {
        DMatrix::from_fn(20, 3, |i, j| ((i * (j + 2)) as f64 * 0.37).sin())
    }

    #[test]
    fn data_and_prior_add_up() {
        let s = DMatrix::from_row_slice(3, 3, &[0.1, 0.0, 0.3, 0.02, 0.3, 0.1, 0.0, 0.05, 0.2]);
        let prior = (&s * s.transpose()).try_inverse().unwrap();
        let expected = rows().tr_mul(&rows()) + prior;
        let found = squared(&information(&rows(), &s, Beyond::Exact));
        assert!((&found - &expected).norm() < 1e-12 * expected.norm());
    }

    /// A prior on two of three directions: the third is exact, or the data leave it open.
    #[test]
    fn directions_beyond_the_prior_are_exact_or_open() {
        let s = DMatrix::from_row_slice(3, 2, &[0.1, 0.0, 0.0, 0.3, 0.0, 0.0]);
        let exact = information(&rows(), &s, Beyond::Exact).deviations();
        assert!((exact[2].unwrap() / EXACT_M - 1.0).abs() < 1e-6);
        let open = information(&rows(), &s, Beyond::Nothing).deviations();
        assert!(open[0].is_some() && open[1].is_some() && open[2].is_none());
    }

    #[test]
    fn without_a_prior_what_is_unseen_has_no_information() {
        let mut blind = rows();
        blind.set_column(1, &nalgebra::DVector::zeros(20));
        let unseen = DMatrix::from_row_slice(3, 1, &[0.0, 1.0, 0.0]);
        let found = of_rows(&blind, &unseen);
        assert_eq!(found.deviations()[1], None);
        let expected = blind.tr_mul(&blind);
        assert!((squared(&found) - &expected).norm() < 1e-12 * expected.norm());
    }
}
