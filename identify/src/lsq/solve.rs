//! Parameters and their covariance from a factor and a prior.
//!
//! ```text
//! data   ‖(R r − z) / σ‖²            prior   r = r_CAD + S u,  ‖u‖²
//! r = r_CAD + S u        u = argmin ‖(R S u − (z − R r_CAD)) / σ‖² + ‖u‖²
//! C = S (I + Sᵀ Rᵀ R S / σ²)⁻¹ Sᵀ
//! ```
//!
//! Without a prior the same by singular values of R: directions below
//! [`UNSEEN`] of the largest stay at CAD. What is seen is a matter of postures,
//! not of weights: it is decided on rows as they are, so that a row with an
//! absurdly small deviation hides no other.
//!
//! # Information
//!
//! What data and a prior tell together is kept as a triangular factor:
//!
//! ```text
//! RᵀR = Aᵀ A + Cₚ⁻¹        A rows over deviations, Cₚ = S Sᵀ the prior
//! ```
//!
//! A direction that the prior holds exactly (S has no column for it: massless links) is
//! entered as known to a micrometre, so that RᵀR has an inverse.

use nalgebra::{DMatrix, DVector};
use sesc_model::Information;

use super::factor::Factor;
use crate::svd::svd;

/// Singular values below this, relative to the largest, are not seen.
pub(crate) const UNSEEN: f64 = 1e-10;

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

/// Estimate from rows that count alike, or all with one deviation.
///
/// `sigma` is that of the rows (1 where they are over it already); `prior` is the
/// factor S of the prior covariance about `cad`.
pub fn solve(
    factor: &Factor,
    sigma: f64,
    cad: &DVector<f64>,
    prior: Option<&DMatrix<f64>>,
) -> Estimate {
    Seen::by(factor, factor).solve(factor, sigma, cad, prior)
}

/// What CAD leaves of the readings.
fn away(factor: &Factor, cad: &DVector<f64>) -> DVector<f64> {
    factor.z() - factor.r() * cad
}

/// What data and a prior say of the unknowns u.
pub(crate) struct Posterior {
    /// Their mean.
    pub mean: DVector<f64>,
    /// T with TᵀT the inverse of their covariance: the triangle of (R S / σ; 1).
    triangle: DMatrix<f64>,
    /// ‖Qᵀ b‖², b what CAD leaves over σ: how much less is left by `mean`, its own square counted.
    explained: f64,
}

impl Posterior {
    /// Root of the covariance of s u.
    pub(crate) fn spread(&self, s: &DMatrix<f64>) -> DMatrix<f64> {
        let half = self.triangle.tr_solve_upper_triangular(&s.transpose());
        half.unwrap_or_else(|| DMatrix::zeros(s.ncols(), s.nrows()))
            .transpose()
    }

    /// −2 log of the evidence of the prior, less what is the same for every prior.
    pub(crate) fn evidence(&self) -> f64 {
        let log_det = self.triangle.diagonal().map(|x| x.abs().ln()).sum();
        2.0 * log_det - self.explained
    }
}

/// What data and a prior S about CAD say of u.
pub(crate) fn with_prior(
    factor: &Factor,
    sigma: f64,
    cad: &DVector<f64>,
    s: &DMatrix<f64>,
) -> Posterior {
    let (p, m) = s.shape();
    let mut stacked = DMatrix::zeros(p + m, m);
    stacked.rows_mut(0, p).copy_from(&(factor.r() * s / sigma));
    stacked.rows_mut(p, m).fill_with_identity();
    let (q, r) = stacked.qr().unpack();
    let right = q.rows(0, p).transpose() * (away(factor, cad) / sigma);
    // The identity below makes r regular, with singular values of one or more.
    let mean = r.solve_upper_triangular(&right);
    Posterior {
        mean: mean.unwrap_or_else(|| DVector::zeros(m)),
        explained: right.norm_squared(),
        triangle: r,
    }
}

/// What rows see, and what they do not.
pub(crate) struct Seen {
    /// Orthonormal columns, p × rank.
    basis: DMatrix<f64>,
    /// p × (p − rank)
    blind: DMatrix<f64>,
    condition_number: f64,
}

impl Seen {
    /// Observable directions by the singular values of `plain`, less what `weighted` gives no
    /// weight at all.
    pub(crate) fn by(plain: &Factor, weighted: &Factor) -> Seen {
        let p = plain.params();
        let svd = svd(plain.r(), false, true);
        let values = svd.singular_values;
        let largest = values.max();
        let (seen, blind): (Vec<usize>, Vec<usize>) =
            (0..p).partition(|&k| values[k] > UNSEEN * largest);
        let smallest = seen.iter().map(|&k| values[k]).fold(largest, f64::min);
        let v = svd
            .v_t
            .unwrap_or_else(|| DMatrix::identity(p, p))
            .transpose();
        let mut found = Seen {
            basis: v.select_columns(&seen),
            blind: v.select_columns(&blind),
            condition_number: largest / smallest,
        };
        if !std::ptr::eq(plain, weighted) {
            found.weigh(weighted);
        }
        found
    }

    /// Rows that a robust fit rejects have no weight, and may be all that saw a direction.
    fn weigh(&mut self, weighted: &Factor) {
        let svd = svd(weighted.r() * &self.basis, false, true);
        let values = svd.singular_values;
        // Per parameter less is rounding.
        let least = 4.0 * f64::EPSILON * weighted.params() as f64 * values.max();
        let (seen, lost): (Vec<usize>, Vec<usize>) =
            (0..values.len()).partition(|&k| values[k] > least);
        let Some(v) = svd.v_t.filter(|_| !lost.is_empty()) else {
            return;
        };
        let v = &self.basis * v.transpose();
        let blind: Vec<_> = self.blind.column_iter().collect();
        let lost: Vec<_> = lost.iter().map(|&k| v.column(k)).collect();
        self.blind = DMatrix::from_columns(&[blind, lost].concat());
        self.basis = v.select_columns(&seen);
    }

    /// Estimate from rows over deviations of their own, as [`solve`] does.
    pub(crate) fn solve(
        &self,
        factor: &Factor,
        sigma: f64,
        cad: &DVector<f64>,
        prior: Option<&DMatrix<f64>>,
    ) -> Estimate {
        let (params, covariance) = match prior {
            None => self.step(factor, sigma, &away(factor, cad)),
            Some(s) => {
                let posterior = with_prior(factor, sigma, cad, s);
                let half = posterior.spread(s);
                (s * posterior.mean, &half * half.transpose())
            }
        };
        Estimate {
            params: cad + params,
            covariance,
            rank: self.basis.ncols(),
            condition_number: self.condition_number,
            unseen: self.blind.clone(),
        }
    }

    /// Step from where `away` is left over, in the directions seen, and its covariance.
    fn step(
        &self,
        factor: &Factor,
        sigma: f64,
        away: &DVector<f64>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let p = factor.params();
        let svd = svd(factor.r() * &self.basis, true, true);
        let (Some(u), Some(v_t)) = (&svd.u, &svd.v_t) else {
            return (DVector::zeros(p), DMatrix::zeros(p, p));
        };
        let inverse = svd.singular_values.map(|value| 1.0 / value);
        let along = u.tr_mul(away).component_mul(&inverse);
        let v = &self.basis * v_t.transpose();
        let half = &v * DMatrix::from_diagonal(&(inverse * sigma));
        (v * along, &half * half.transpose())
    }
}

/// What is known of directions that `S` has no column for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Beyond {
    /// All: the parameters there are the prior's.
    Exact,
    /// Nothing: the prior is a wide one on the directions that data see.
    Nothing,
}

/// The factor of `rows` (over their deviations) and of a prior with the factor `s`.
pub(crate) fn information(rows: &DMatrix<f64>, s: &DMatrix<f64>, beyond: Beyond) -> Information {
    let p = s.nrows();
    // As many columns as rows, so that U is complete.
    let mut square = DMatrix::zeros(p, p.max(s.ncols()));
    square.columns_mut(0, s.ncols()).copy_from(s);
    let svd = svd(square, true, false);
    let values = &svd.singular_values;
    let u = svd.u.unwrap_or_else(|| DMatrix::identity(p, p));
    let least = 1e-12 * values.max();
    let mut of_prior = DMatrix::zeros(p, p);
    let mut seen = DMatrix::identity(p, p);
    for (k, direction) in u.column_iter().enumerate() {
        let weight = match (values[k] > least, beyond) {
            (true, _) => 1.0 / values[k],
            (false, Beyond::Exact) => 1.0 / 1e-6,
            (false, Beyond::Nothing) => {
                seen -= direction * direction.transpose();
                0.0
            }
        };
        of_prior.set_row(k, &(direction.transpose() * weight));
    }
    let mut rows = match beyond {
        Beyond::Exact => rows.clone(),
        Beyond::Nothing => rows * seen,
    };
    if rows.nrows() > p {
        rows = rows.qr().r();
    }
    let n = rows.nrows();
    let mut all = DMatrix::zeros(p + n, p);
    all.rows_mut(0, p).copy_from(&of_prior);
    all.rows_mut(p, n).copy_from(&rows);
    Information::of(&all)
}

/// The factor of `rows` alone, less the directions `unseen` (orthonormal columns).
pub(crate) fn of_rows(rows: &DMatrix<f64>, unseen: &DMatrix<f64>) -> Information {
    Information::of(&(rows - (rows * unseen) * unseen.transpose()))
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

    /// A row that is said to be exact becomes a constraint; the others tell the rest.
    #[test]
    fn a_row_with_an_absurd_deviation_hides_no_other() {
        let (matrix, reading, plain) = data();
        let mut weights = [1.0; 30];
        weights[7] = 1e11;
        let mut weighted = Factor::new(3);
        weighted.push(&matrix, &reading, &weights);
        let cad = DVector::from_vec(vec![0.5, -0.5, 0.1]);
        let found = Seen::by(&plain, &weighted).solve(&weighted, 1.0, &cad, None);
        assert_eq!((found.rank, found.unseen.ncols()), (3, 0));
        assert!(found.condition_number < 10.0);
        // Lagrange: [AᵀA aᵀ; a 0] [r; λ] = [Aᵀ y; y_7] over the other rows.
        let others = matrix.clone().remove_row(7);
        let mut bordered = DMatrix::zeros(4, 4);
        bordered
            .view_mut((0, 0), (3, 3))
            .copy_from(&others.tr_mul(&others));
        bordered.view_mut((3, 0), (1, 3)).copy_from(&matrix.row(7));
        bordered
            .view_mut((0, 3), (3, 1))
            .copy_from(&matrix.row(7).transpose());
        let right = others.tr_mul(&reading.clone().remove_row(7));
        let right = right.push(reading[7]);
        let exact = bordered.lu().solve(&right).unwrap().remove_row(3);
        // Of the other rows' sixteen digits the weight leaves five.
        assert!((&found.params - exact).norm() < 1e-4, "{}", found.params);
        // Their own deviations are those of two directions that they tell.
        let along = matrix.row(7).transpose().normalize();
        assert!((&found.covariance * &along).norm() < 1e-4 * found.covariance.norm());
    }

    /// A row of no weight shows nothing, whatever its posture would.
    #[test]
    fn a_row_without_weight_is_not_seen() {
        let mut plain = Factor::new(2);
        let rows = DMatrix::identity(2, 2);
        plain.push(&rows, &DVector::from_vec(vec![1.0, 2.0]), &[1.0; 2]);
        let mut weighted = Factor::new(2);
        weighted.push(&rows, &DVector::from_vec(vec![1.0, 2.0]), &[1.0, 0.0]);
        let found = Seen::by(&plain, &weighted).solve(&weighted, 1.0, &DVector::zeros(2), None);
        assert_eq!((found.rank, found.unseen.ncols()), (1, 1));
        assert!((found.params - DVector::from_vec(vec![1.0, 0.0])).norm() < 1e-14);
    }

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
        assert!((exact[2].unwrap() / 1e-6 - 1.0).abs() < 1e-6);
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
