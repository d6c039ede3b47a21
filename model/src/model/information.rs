//! How well parameters are known, as a triangular factor.
//!
//! ```text
//! RᵀR = C⁻¹        |R (r − r̂)|² = (r − r̂)ᵀ C⁻¹ (r − r̂)
//! ```
//!
//! C is the covariance of the base parameters r̂ as a fit leaves it, prior included. R is
//! upper triangular, in the order of the parameters, 1/m (1 in the column of a mass
//! share), its diagonal zero or more. A parameter that neither data nor prior say anything
//! about beyond those before it has a row of zeros; given it, the others are as known as
//! R says.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// The information factor R of a model file.
///
/// ```
/// use sesc_model::Information;
///
/// // A row of the prior, 1 ± 0.5, and a reading of the sum, ± 0.1.
/// let rows = nalgebra::DMatrix::from_row_slice(2, 2, &[2.0, 0.0, 10.0, 10.0]);
/// let information = Information::of(&rows);
/// let found = information.deviations();
/// assert!((found[0].unwrap() - 0.5).abs() < 1e-15);
/// assert_eq!(information.packed().len(), 3);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Information {
    /// The information factor, from which an estimator on the robot goes on: row i from its
    /// diagonal on, so that there are n, n − 1, … 1 numbers.
    pub factor: Vec<Vec<f64>>,
}

/// A column that is independent of those before it by less than this share of its length
/// says nothing of its own.
const INDEPENDENT: f64 = 1e-11;

/// A column that is shorter than this, relative to the longest, is rounding.
const ROUNDING: f64 = 1e-13;

impl Information {
    /// Factor of rows over their standard deviations, one column per parameter.
    ///
    /// Rows are rotated in one by one, so that a column without a pivot of its own leaves
    /// its row empty.
    #[doc(hidden)]
    pub fn of(rows: &DMatrix<f64>) -> Information {
        let n = rows.ncols();
        let norms: Vec<f64> = rows.column_iter().map(|column| column.norm()).collect();
        let longest = norms.iter().fold(0.0, |most, norm| norm.max(most));
        let least: Vec<f64> = norms.iter().map(|norm| INDEPENDENT * norm).collect();
        let mut triangle = DMatrix::<f64>::zeros(n, n);
        for row in rows.row_iter() {
            let mut row = row.into_owned();
            for (x, norm) in row.iter_mut().zip(&norms) {
                if *norm <= ROUNDING * longest {
                    *x = 0.0;
                }
            }
            for i in 0..n {
                if row[i].abs() <= least[i] && triangle[(i, i)] == 0.0 {
                    continue;
                }
                // Exact where the line is empty: it becomes the row.
                let (pivot, x) = (triangle[(i, i)], row[i]);
                let length = (pivot * pivot + x * x).sqrt();
                let (c, s) = (pivot / length, x / length);
                for k in i..n {
                    let (line, x) = (triangle[(i, k)], row[k]);
                    triangle[(i, k)] = c * line + s * x;
                    row[k] = c * x - s * line;
                }
                row[i] = 0.0;
            }
        }
        let line = |i: usize| (i..n).map(|k| triangle[(i, k)]).collect();
        Information {
            factor: (0..n).map(line).collect(),
        }
    }

    /// All rows one after the other: n (n + 1)/2 numbers.
    pub fn packed(&self) -> Vec<f64> {
        self.factor.concat()
    }

    /// Standard deviation of every parameter, √((RᵀR)⁻¹)ₖₖ, given those that have none.
    pub fn deviations(&self) -> Vec<Option<f64>> {
        let n = self.factor.len();
        let of = |k: usize| {
            // x R = e_k
            let mut x = vec![0.0; n];
            x[k] = 1.0;
            let mut variance = 0.0;
            for (i, line) in self.factor.iter().enumerate().skip(k) {
                if line[0] > 0.0 {
                    let pivot = x[i] / line[0];
                    variance += pivot * pivot;
                    for (x, r) in x[i..].iter_mut().zip(line) {
                        *x -= pivot * r;
                    }
                }
            }
            (self.factor[k][0] > 0.0).then(|| variance.sqrt())
        };
        (0..n).map(of).collect()
    }

    /// What is wrong with it as the factor of `n` parameters.
    pub(super) fn invalid_reason(&self, n: usize) -> Option<String> {
        let remedy = "fit again, or remove [information]";
        let mut rows = self.factor.iter().enumerate();
        if self.factor.len() != n || rows.any(|(i, row)| row.len() != n - i) {
            return Some(format!(
                "information.factor needs {n} rows of {n} to 1 numbers, row by row from the \
                 diagonal; {remedy}"
            ));
        }
        if self.factor.iter().flatten().any(|x| !x.is_finite()) {
            return Some(format!(
                "information.factor holds a number that is not finite; {remedy}"
            ));
        }
        let empty = |row: &[f64]| row.iter().all(|x| *x == 0.0);
        let wrong = |row: &Vec<f64>| row[0] < 0.0 || (row[0] == 0.0 && !empty(row));
        self.factor.iter().position(wrong).map(|k| {
            format!(
                "row {} of information.factor has a diagonal below zero, or of zero with numbers \
                 behind it; {remedy}",
                k + 1
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_that_of_the_normal_equations() {
        let rows = DMatrix::from_fn(30, 4, |i, k| ((i * (k + 2)) as f64 * 0.37).sin());
        let information = Information::of(&rows);
        let factor = DMatrix::from_fn(4, 4, |i, k| match k.checked_sub(i) {
            Some(at) => information.factor[i][at],
            None => 0.0,
        });
        assert!((factor.tr_mul(&factor) - rows.tr_mul(&rows)).norm() < 1e-12);
        let covariance = rows.tr_mul(&rows).try_inverse().unwrap();
        for (k, std) in information.deviations().into_iter().enumerate() {
            assert!((std.unwrap() / covariance[(k, k)].sqrt() - 1.0).abs() < 1e-12);
        }
        assert_eq!(information.invalid_reason(4), None);
    }

    /// The third column is the sum of the first two.
    #[test]
    fn a_dependent_column_has_an_empty_row() {
        let mut rows = DMatrix::from_fn(30, 4, |i, k| ((i * (k + 2)) as f64 * 0.37).sin());
        let sum = rows.column(0) + rows.column(1);
        rows.set_column(2, &sum);
        let information = Information::of(&rows);
        assert_eq!(information.factor[2], [0.0, 0.0]);
        let rest = rows.clone().remove_column(2);
        let covariance = rest.tr_mul(&rest).try_inverse().unwrap();
        let found = information.deviations();
        assert_eq!(found[2], None);
        assert!((found[3].unwrap() / covariance[(2, 2)].sqrt() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_factor_is_refused() {
        let factor = |rows: &[&[f64]]| Information {
            factor: rows.iter().map(|row| row.to_vec()).collect(),
        };
        let refused: [&[&[f64]]; 6] = [
            &[&[1.0, 2.0]],
            &[&[1.0], &[1.0]],
            &[&[1.0, 2.0], &[-1.0]],
            &[&[0.0, 2.0], &[1.0]],
            &[&[1.0, f64::NAN], &[1.0]],
            &[],
        ];
        for rows in refused {
            let reason = factor(rows).invalid_reason(2).expect("refused");
            assert!(reason.contains("fit again"), "{reason}");
        }
        assert_eq!(factor(&[&[0.0, 0.0], &[1.0]]).invalid_reason(2), None);
    }
}
