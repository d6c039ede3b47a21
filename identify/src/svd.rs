//! Singular values and eigenvalues that come to an end, whatever the matrix.
//!
//! ```text
//! A = U Σ Vᵀ
//! ```
//!
//! The iterations of the library behind this do not end where an entry is no number, and
//! refuse matrices without rows or columns. Here an empty matrix has no singular values,
//! and one that is not finite, or does not settle, has NaN for all of them: what is made of
//! these is not finite either, and is refused where results are checked.

use nalgebra::{DMatrix, DVector, Dyn, SVD, SymmetricEigen};

/// Rounds per singular value, at most; about three are usual.
const ROUNDS: usize = 200;

/// The decomposition of `matrix`, with U and Vᵀ where they are asked for.
pub(crate) fn svd(matrix: DMatrix<f64>, u: bool, v: bool) -> SVD<f64, Dyn, Dyn> {
    let (rows, columns) = matrix.shape();
    let few = rows.min(columns);
    let filled = |value: f64| SVD {
        u: u.then(|| DMatrix::from_element(rows, few, value)),
        v_t: v.then(|| DMatrix::from_element(few, columns, value)),
        singular_values: DVector::from_element(few, value),
    };
    if few == 0 {
        return filled(0.0);
    }
    if !matrix.iter().all(|x| x.is_finite()) {
        return filled(f64::NAN);
    }
    // The tolerance is the library's own.
    SVD::try_new(matrix, u, v, 5.0 * f64::EPSILON, ROUNDS * few).unwrap_or_else(|| filled(f64::NAN))
}

/// Eigenvalues and vectors of a symmetric matrix, NaN where it is not finite.
pub(crate) fn symmetric_eigen(matrix: DMatrix<f64>) -> SymmetricEigen<f64, Dyn> {
    let n = matrix.nrows();
    let unknown = || SymmetricEigen {
        eigenvectors: DMatrix::from_element(n, n, f64::NAN),
        eigenvalues: DVector::from_element(n, f64::NAN),
    };
    if n == 0 || !matrix.iter().all(|x| x.is_finite()) {
        return unknown();
    }
    SymmetricEigen::try_new(matrix, f64::EPSILON, ROUNDS * n).unwrap_or_else(unknown)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 and 1: the square roots of the eigenvalues 9 and 1 of AᵀA = [5 4; 4 5].
    #[test]
    fn a_matrix_by_hand_has_its_values() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let found = svd(matrix.clone(), true, true);
        assert!((&found.singular_values - DVector::from_vec(vec![3.0, 1.0])).amax() < 1e-14);
        assert!((found.recompose().unwrap() - matrix).amax() < 1e-14);
    }

    #[test]
    fn what_is_empty_or_no_number_comes_to_an_end() {
        for shape in [(0, 3), (3, 0), (0, 0)] {
            let found = svd(DMatrix::zeros(shape.0, shape.1), true, true);
            assert_eq!(found.u.unwrap().shape(), (shape.0, 0));
            assert_eq!(found.v_t.unwrap().shape(), (0, shape.1));
        }
        for odd in [f64::NAN, f64::INFINITY] {
            let mut matrix = DMatrix::identity(20, 20);
            matrix[(3, 4)] = odd;
            assert!(
                svd(matrix.clone(), false, false)
                    .singular_values
                    .iter()
                    .all(|x| x.is_nan())
            );
            let found = symmetric_eigen(matrix).eigenvalues;
            assert!(found.iter().all(|x| x.is_nan()));
        }
        // Sizes at both ends of what a float holds.
        for size in [f64::MAX, f64::MIN_POSITIVE, 5e-324] {
            let found = svd(DMatrix::from_element(30, 20, size), false, false).singular_values;
            assert_eq!(found.len(), 20);
        }
    }
}
