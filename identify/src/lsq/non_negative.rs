//! Least squares with unknowns that are not negative (Lawson and Hanson, Solving
//! Least Squares Problems, algorithm NNLS).
//!
//! ```text
//! min ‖M u − f‖,  u ≥ 0        optimal when  w = Mᵀ(f − M u) ≤ 0,  w = 0 where u > 0
//! ```
//!
//! Unknowns enter by the largest slope w and leave where a step would make them
//! negative; the sum of squares falls with every step, so the search ends.

use crate::svd::svd;
use nalgebra::{DMatrix, DVector};

/// Singular values below this, relative to the largest, count as zero.
const DEPENDENT: f64 = 1e-12;
/// Slopes below this are rounding, in units of the target.
const FLAT: f64 = 1e-13;
/// Unknowns below this are zero.
const NOTHING: f64 = 1e-15;

/// u, or `None` where rounding keeps the search from an end.
pub fn non_negative(matrix: &DMatrix<f64>, target: &DVector<f64>) -> Option<DVector<f64>> {
    let m = matrix.ncols();
    let mut u = DVector::zeros(m);
    let mut inside: Vec<usize> = Vec::new();
    let mut barred = vec![false; m];
    for _ in 0..10 * m + 100 {
        let slope = matrix.transpose() * (target - matrix * &u);
        let next = (0..m)
            .filter(|k| !inside.contains(k) && !barred[*k] && slope[*k] > FLAT)
            .max_by(|a, b| slope[*a].total_cmp(&slope[*b]));
        let Some(next) = next else {
            return Some(u);
        };
        inside.push(next);
        loop {
            let chosen = matrix.select_columns(&inside);
            let svd = svd(chosen, true, true);
            let limit = DEPENDENT * svd.singular_values.max();
            let z = svd.solve(target, limit).ok()?;
            // A new column that rounding alone let in goes out again, for this point.
            let last = inside.len() - 1;
            if inside[last] == next && u[next] == 0.0 && z[last] <= 0.0 {
                inside.pop();
                barred[next] = true;
                break;
            }
            if z.iter().all(|x| *x > 0.0) {
                for (&k, &x) in inside.iter().zip(&z) {
                    u[k] = x;
                }
                barred.fill(false);
                break;
            }
            let ratio = |at: usize| u[inside[at]] / (u[inside[at]] - z[at]);
            let steps = (0..inside.len()).filter(|&at| z[at] <= 0.0).map(ratio);
            let step = steps.fold(1.0, f64::min);
            for (&k, &x) in inside.iter().zip(&z) {
                u[k] += step * (x - u[k]);
            }
            inside.retain(|&k| {
                let keep = u[k] > NOTHING;
                if !keep {
                    u[k] = 0.0;
                }
                keep
            });
            if inside.is_empty() {
                break;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns (1, 0), (1, 1) towards (1, −1): 2 and −1 without bounds, 1 and 0 with them.
    #[test]
    fn unknowns_that_would_be_negative_are_zero() {
        let matrix = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]);
        let target = DVector::from_vec(vec![1.0, -1.0]);
        let u = non_negative(&matrix, &target).unwrap();
        assert!((u - DVector::from_vec(vec![1.0, 0.0])).amax() < 1e-14);
        let away = DVector::from_vec(vec![-1.0, 0.0]);
        let one = matrix.columns(0, 1).into_owned();
        assert_eq!(non_negative(&one, &away).unwrap()[0], 0.0);
    }
}
