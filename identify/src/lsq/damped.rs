//! Damped least squares (Levenberg and Marquardt) of a model that is not linear.
//!
//! ```text
//! F(x + d) ≈ F(x) − 2 gᵀ d + dᵀ H d        (H + λ diag H + ε D⁻²) d = g
//! ```
//!
//! H and g are the normal equations at x, D the ordinary sizes of the unknowns. λ
//! falls after a step that lowers F and rises after one that does not.

use nalgebra::{DMatrix, DVector};

/// Curvature that every unknown has, in units of its size: ε.
const RIDGE: f64 = 1e-9;
/// A sum of squares that falls by less than this (of χ²) is settled.
pub(crate) const SETTLED: f64 = 1e-3;

/// A sum of squares near some unknowns.
pub(crate) struct Expansion<T> {
    /// The unknowns.
    pub unknowns: Vec<f64>,
    /// F there.
    pub value: f64,
    /// H = JᵀJ.
    pub normal: DMatrix<f64>,
    /// g = Jᵀ(y − f).
    pub gradient: DVector<f64>,
    /// What else the caller knows there.
    pub there: T,
}

/// The least sum of squares that descent from `start` finds; `sizes` are the
/// ordinary sizes of the unknowns.
pub(crate) fn minimise<T>(
    start: Expansion<T>,
    sizes: &[f64],
    expand: impl Fn(Vec<f64>) -> Expansion<T>,
) -> Expansion<T> {
    let mut here = start;
    let mut damping = 1e-3;
    if sizes.is_empty() {
        return here;
    }
    for _ in 0..25 {
        let mut lower = None;
        for _ in 0..8 {
            let mut damped = here.normal.clone();
            for (k, size) in sizes.iter().enumerate() {
                let unit = 1.0 / (size * size);
                let own = here.normal[(k, k)].max(1e-12 * unit);
                damped[(k, k)] += damping * own + RIDGE * unit;
            }
            if let Some(factor) = damped.cholesky() {
                let step = factor.solve(&here.gradient);
                let moved = here.unknowns.iter().zip(step.iter());
                let next = expand(moved.map(|(x, d)| x + d).collect());
                if next.value < here.value {
                    lower = Some(next);
                    damping = (damping * 0.2).max(1e-9);
                    break;
                }
            }
            damping *= 10.0;
        }
        let Some(next) = lower else { break };
        let gain = here.value - next.value;
        here = next;
        if gain < SETTLED {
            break;
        }
    }
    here
}

/// Covariance of the unknowns, (H + ε D⁻²)⁻¹; zero where H is not finite.
pub(crate) fn covariance(normal: &DMatrix<f64>, sizes: &[f64]) -> DMatrix<f64> {
    let p = sizes.len();
    let mut normal = normal.clone();
    for (k, size) in sizes.iter().enumerate() {
        normal[(k, k)] += RIDGE / (size * size);
    }
    let factor = normal.cholesky();
    factor.map_or_else(|| DMatrix::zeros(p, p), |factor| factor.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals and slopes at some unknowns.
    fn expanded(
        unknowns: Vec<f64>,
        residual: &DVector<f64>,
        slopes: &DMatrix<f64>,
    ) -> Expansion<()> {
        Expansion {
            unknowns,
            value: residual.norm_squared(),
            normal: slopes.tr_mul(slopes),
            gradient: slopes.tr_mul(residual),
            there: (),
        }
    }

    /// A straight line through (0, 1), (1, 3), (2, 4), (3, 4): 1.5 + 1 t, by hand.
    #[test]
    fn a_straight_line_is_found_with_its_covariance() {
        let slopes = DMatrix::from_fn(4, 2, |row, k| (row as f64).powi(k as i32));
        let readings = DVector::from_vec(vec![1.0, 3.0, 4.0, 4.0]);
        let at = |x: Vec<f64>| {
            let residual = &readings - &slopes * DVector::from_column_slice(&x);
            expanded(x, &residual, &slopes)
        };
        let found = minimise(at(vec![0.0, 0.0]), &[1.0, 1.0], at);
        assert!((found.unknowns[0] - 1.5).abs() < 1e-3 && (found.unknowns[1] - 1.0).abs() < 1e-3);
        assert!((found.value - 1.0).abs() < 1e-6);
        // (JᵀJ)⁻¹ = [14 −6; −6 4] / 20.
        let expected = DMatrix::from_row_slice(2, 2, &[0.7, -0.3, -0.3, 0.2]);
        assert!((covariance(&found.normal, &[1.0, 1.0]) - expected).amax() < 1e-6);
    }

    /// Rosenbrock's valley: 0 at (1, 1), round a bend from (−1.2, 1).
    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let at = |x: Vec<f64>| {
            let (a, b) = (x[0], x[1]);
            let residual = DVector::from_vec(vec![10.0 * (a * a - b), a - 1.0]);
            let slopes = DMatrix::from_row_slice(2, 2, &[-20.0 * a, 10.0, -1.0, 0.0]);
            expanded(x, &residual, &slopes)
        };
        let found = minimise(at(vec![-1.2, 1.0]), &[1.0, 1.0], at);
        assert!(found.value < SETTLED, "{:?}", found.unknowns);
        assert!(found.unknowns.iter().all(|x| (x - 1.0).abs() < 0.05));
    }

    /// An unknown that nothing depends on stays where it is, and so does the best point.
    #[test]
    fn what_does_not_matter_stays() {
        let at = |x: Vec<f64>| {
            let residual = DVector::from_vec(vec![2.0 - x[0]]);
            let slopes = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
            expanded(x, &residual, &slopes)
        };
        let found = minimise(at(vec![2.0, 7.0]), &[1.0, 0.1], at);
        assert_eq!(found.unknowns, [2.0, 7.0]);
        let nothing = minimise(at(vec![0.5, 7.0]), &[], at);
        assert_eq!(nothing.unknowns, [0.5, 7.0]);
    }
}
