//! Least squares under linear equations and inequalities, answered to the last digits.
//!
//! ```text
//! min ‖A v − b‖²        E v = e        G v ≤ h        A of full column rank
//! v = v_0 + T w         ‖A v − b‖² = ‖A v_0 − b‖² + ‖w‖²     on E v = e
//! min ‖w‖   G T w ≤ h − G v_0     ⇔     min ‖[Tᵀ Gᵀ; (h − G v_0)ᵀ] u + [0; 1]‖,  u ≥ 0
//! ```
//!
//! Lawson and Hanson (Solving Least Squares Problems, ch. 23): the least distance is
//! had from least squares with u ≥ 0, whose residual is zero just when no point
//! satisfies the inequalities. Those with u > 0 are active; with them as equations
//! the rest is linear, so that equations hold to rounding.
//!
//! # Unknowns that are not negative (Lawson and Hanson, algorithm NNLS)
//!
//! ```text
//! min ‖M u − f‖,  u ≥ 0        optimal when  w = Mᵀ(f − M u) ≤ 0,  w = 0 where u > 0
//! ```
//!
//! Unknowns enter by the largest slope w and leave where a step would make them
//! negative; the sum of squares falls with every step, so the search ends.

use nalgebra::{DMatrix, DVector};

use crate::svd::{svd, symmetric_eigen};

/// Singular values below this, relative to the largest, count as zero.
const DEPENDENT: f64 = 1e-12;
/// A normalised inequality may be missed by this, and dependent equations contradict each other.
const SLACK: f64 = 1e-11;

/// `matrix · v` against `right`.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
}

impl Linear {
    /// No rows over `columns` unknowns.
    pub(crate) fn none(columns: usize) -> Linear {
        Linear {
            matrix: DMatrix::zeros(0, columns),
            right: DVector::zeros(0),
        }
    }

    /// Row by row over its length; rows of zeros stay.
    fn normalised(&self) -> Linear {
        let mut rows = self.clone();
        for k in 0..rows.right.len() {
            let length = rows.matrix.row(k).norm();
            if length > 0.0 {
                rows.matrix.row_mut(k).unscale_mut(length);
                rows.right[k] /= length;
            }
        }
        rows
    }

    fn stacked(&self, more: &Linear, chosen: &[usize]) -> Linear {
        let n = self.right.len();
        let mut all = Linear {
            matrix: self.matrix.clone().insert_rows(n, chosen.len(), 0.0),
            right: self.right.clone().insert_rows(n, chosen.len(), 0.0),
        };
        for (to, &from) in chosen.iter().enumerate() {
            all.matrix.set_row(n + to, &more.matrix.row(from));
            all.right[n + to] = more.right[from];
        }
        all
    }
}

/// A problem of this kind.
#[derive(Debug, Clone)]
pub(crate) struct ConstrainedProblem {
    pub squares: Linear,
    pub equal: Linear,
    pub at_most: Linear,
}

/// Its answer.
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    pub v: DVector<f64>,
    /// Inequalities that hold as equations, by index.
    pub active: Vec<usize>,
}

/// Why there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum NoAnswer {
    /// The equations contradict each other.
    Contradiction,
    /// No point satisfies equations and inequalities.
    Infeasible,
    /// The search came to no end.
    Stuck,
}

impl ConstrainedProblem {
    /// The best v.
    ///
    /// # Errors
    /// When there is none, or none was found.
    pub(crate) fn solve(&self) -> Result<Answer, NoAnswer> {
        let equal = independent(&self.equal.normalised())?;
        let below = self.at_most.normalised();
        let face = Face::of(&self.squares, &equal).ok_or(NoAnswer::Contradiction)?;
        let mut active = match worst(&below, &face.best) {
            None => Vec::new(),
            Some(_) => nearest(&face, &below)?,
        };
        let mut near = face.best;
        for _ in 0..60 {
            let face = equal.stacked(&below, &active);
            let Some(Face { best: v, .. }) = Face::of(&self.squares, &face) else {
                break;
            };
            near.copy_from(&v);
            if let Some(k) = worst(&below, &v).filter(|k| !active.contains(k)) {
                active.push(k);
            } else if let Some(at) = self.pulling(&v, &face, equal.right.len()) {
                active.remove(at);
            } else {
                return Ok(Answer { v, active });
            }
        }
        // Rounding at a corner where more inequalities meet than directions are left.
        match worst(&below, &near) {
            Some(k) if (&below.matrix * &near - &below.right)[k] > 1e-8 => Err(NoAnswer::Stuck),
            _ => Ok(Answer { v: near, active }),
        }
    }

    /// The active inequality that holds `v` on the wrong side most, if any: a
    /// multiplier below zero in ∇ + Eᵀ λ + Gᵀ μ = 0.
    fn pulling(&self, v: &DVector<f64>, face: &Linear, equations: usize) -> Option<usize> {
        let a = &self.squares.matrix;
        let slope = a.transpose() * (&self.squares.right - a * v);
        let svd = svd(face.matrix.transpose(), true, true);
        let limit = DEPENDENT * svd.singular_values.max();
        let multipliers = svd.solve(&slope, limit).ok()?;
        // A multiplier so far below zero is one.
        let size = 1e-9 * multipliers.amax().max(f64::MIN_POSITIVE);
        let pulls = (equations..multipliers.len()).filter(|&k| multipliers[k] < -size);
        let most = pulls.min_by(|x, y| multipliers[*x].total_cmp(&multipliers[*y]));
        most.map(|k| k - equations)
    }
}

/// The inequality that `v` misses most, if any.
fn worst(below: &Linear, v: &DVector<f64>) -> Option<usize> {
    let over = &below.matrix * v - &below.right;
    let slack = |k: &usize| SLACK * (1.0 + below.right[*k].abs());
    (0..over.len())
        .filter(|k| over[*k] > slack(k))
        .max_by(|a, b| over[*a].total_cmp(&over[*b]))
}

/// Orthonormal rows that say the same.
fn independent(equal: &Linear) -> Result<Linear, NoAnswer> {
    if equal.right.is_empty() {
        return Ok(equal.clone());
    }
    let svd = svd(equal.matrix.clone(), true, true);
    let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else {
        return Err(NoAnswer::Stuck);
    };
    let limit = DEPENDENT * svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > limit)
        .collect();
    let sides = u.select_columns(&kept);
    let mut right = sides.transpose() * &equal.right;
    if (&equal.right - &sides * &right).amax() > SLACK {
        return Err(NoAnswer::Contradiction);
    }
    for (to, &k) in kept.iter().enumerate() {
        right[to] /= svd.singular_values[k];
    }
    Ok(Linear {
        matrix: v_t.select_rows(&kept),
        right,
    })
}

/// All v that satisfy some equations: `best + rotation · w`, at distance ‖w‖ from the best.
struct Face {
    best: DVector<f64>,
    rotation: DMatrix<f64>,
}

impl Face {
    /// `None` where no v satisfies `equal`.
    fn of(squares: &Linear, equal: &Linear) -> Option<Face> {
        let columns = squares.matrix.ncols();
        let face = independent(equal).ok()?;
        let start = face.matrix.transpose() * &face.right;
        let along = face.matrix.transpose() * &face.matrix;
        // Orthonormal columns beside the rows of `face`.
        let eigen = symmetric_eigen(DMatrix::identity(columns, columns) - along);
        let free: Vec<usize> = (0..columns)
            .filter(|&k| eigen.eigenvalues[k] > 0.5)
            .collect();
        let beside = eigen.eigenvectors.select_columns(&free);
        let rest = &squares.right - &squares.matrix * &start;
        let (q, r) = (&squares.matrix * &beside).qr().unpack();
        let step = r.solve_upper_triangular(&(q.transpose() * rest))?;
        let best = start + &beside * step;
        // Once more against rounding.
        let missing = &face.right - &face.matrix * &best;
        let rotated = r.transpose().solve_lower_triangular(&beside.transpose())?;
        Some(Face {
            best: best + face.matrix.transpose() * missing,
            rotation: rotated.transpose(),
        })
    }
}

/// Inequalities active at the point of `face` nearest to its best.
fn nearest(face: &Face, below: &Linear) -> Result<Vec<usize>, NoAnswer> {
    let rotated = Linear {
        matrix: &below.matrix * &face.rotation,
        right: &below.right - &below.matrix * &face.best,
    };
    let stuck = |k: &usize| rotated.matrix.row(*k).norm() < DEPENDENT && rotated.right[*k] < -SLACK;
    if (0..rotated.right.len()).any(|k| stuck(&k)) {
        return Err(NoAnswer::Infeasible);
    }
    let rows = rotated.normalised();
    let n = rows.matrix.ncols();
    // Right sides of order one, so that the residual is of order one, too.
    let far = rows.right.min().abs().max(f64::MIN_POSITIVE);
    let mut dual = DMatrix::zeros(n + 1, rows.right.len());
    dual.rows_mut(0, n).copy_from(&-rows.matrix.transpose());
    dual.row_mut(n).copy_from(&(-rows.right.transpose() / far));
    let mut target = DVector::zeros(n + 1);
    target[n] = 1.0;
    let u = non_negative(&dual, &target).ok_or(NoAnswer::Stuck)?;
    let rest = &dual * &u - target;
    // No point is feasible: it would be further than 1e6 standard deviations.
    if rest.norm_squared() < 1e-12 {
        return Err(NoAnswer::Infeasible);
    }
    Ok((0..u.len()).filter(|&k| u[k] > 0.0).collect())
}

/// u, or `None` where rounding keeps the search from an end.
pub(crate) fn non_negative(matrix: &DMatrix<f64>, target: &DVector<f64>) -> Option<DVector<f64>> {
    let m = matrix.ncols();
    let mut u = DVector::zeros(m);
    let mut inside: Vec<usize> = Vec::new();
    let mut barred = vec![false; m];
    for _ in 0..10 * m + 100 {
        let slope = matrix.transpose() * (target - matrix * &u);
        let next = (0..m)
            .filter(|k| !inside.contains(k) && !barred[*k] && slope[*k] > 1e-13)
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
                let keep = u[k] > 1e-15;
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
    use crate::tests::noise;

    fn rows(matrix: DMatrix<f64>, right: &[f64]) -> Linear {
        Linear {
            matrix,
            right: DVector::from_column_slice(right),
        }
    }

    /// The point of a triangle nearest to (2, 2, 2): worked out by hand.
    #[test]
    fn the_nearest_point_of_a_simplex() {
        let sums = DMatrix::from_fn(2, 3, |row, _| [1.0, 2.0][row]);
        let signs = DMatrix::from_fn(4, 3, |row, column| match (row, column) {
            (3, 0) => 5.0,
            _ => -f64::from(u8::from(row == column)),
        });
        let problem = |cap: f64, at: [f64; 3]| ConstrainedProblem {
            squares: rows(DMatrix::identity(3, 3), &at),
            equal: rows(sums.clone(), &[1.0, 2.0]),
            at_most: rows(signs.clone(), &[0.0, 0.0, 0.0, 5.0 * cap]),
        };
        let near = |found: &Answer, v: [f64; 3]| {
            let off = &found.v - DVector::from_column_slice(&v);
            assert!(off.amax() < 1e-14, "{}", found.v);
        };
        let third = 1.0 / 3.0;
        let free = problem(1.0, [2.0; 3]).solve().unwrap();
        near(&free, [third; 3]);
        assert!(free.active.is_empty());
        let capped = problem(0.2, [2.0, 2.0, 1.9]).solve().unwrap();
        near(&capped, [0.2, 0.45, 0.35]);
        assert_eq!(capped.active, [3]);
        let corner = problem(1.0, [5.0, -4.0, -4.0]).solve().unwrap();
        near(&corner, [1.0, 0.0, 0.0]);
        let empty = problem(-0.1, [2.0; 3]).solve().unwrap_err();
        assert_eq!(empty, NoAnswer::Infeasible);
        let mut torn = problem(1.0, [2.0; 3]);
        torn.equal.right[1] = 2.1;
        assert_eq!(torn.solve().unwrap_err(), NoAnswer::Contradiction);
    }
    /// Karush, Kuhn and Tucker's conditions, on problems drawn at random.
    #[test]
    fn no_direction_is_better() {
        // Within half of one.
        let mut draw = noise(12_f64.sqrt().recip());
        let mut felt = 0;
        for _ in 0..30 {
            let n = 8;
            let mut squares = DMatrix::from_fn(2 * n, n, |_, _| 30.0 * draw());
            squares.rows_mut(n, n).fill_with_identity();
            let right: Vec<f64> = (0..2 * n).map(|_| 20.0 * draw()).collect();
            let problem = ConstrainedProblem {
                squares: rows(squares, &right),
                equal: rows(DMatrix::from_fn(2, n, |_, _| draw()), &[0.0, 0.0]),
                at_most: rows(DMatrix::from_fn(12, n, |_, _| draw()), &[0.01; 12]),
            };
            let Answer { v, active } = problem.solve().unwrap();
            felt += active.len();
            assert!((&problem.equal.matrix * &v).amax() < 1e-13);
            let over = &problem.at_most.matrix * &v - &problem.at_most.right;
            assert!(over.max() < 1e-10);
            let face = problem.equal.stacked(&problem.at_most, &active);
            let a = &problem.squares.matrix;
            let slope = a.transpose() * (&problem.squares.right - a * &v);
            let columns = face.matrix.transpose();
            let svd = columns.clone().svd(true, true);
            let multipliers = svd.solve(&slope, 1e-12).unwrap();
            let rest = (columns * &multipliers - &slope).amax();
            assert!(rest < 1e-9 * slope.amax().max(1.0), "{rest}");
            let mut of_bounds = multipliers.iter().skip(2);
            assert!(of_bounds.all(|m| *m > -1e-6), "{multipliers}");
        }
        assert!(felt > 20, "{felt} bounds felt");
    }

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
