//! Orientations and regressor columns as plain numbers.
//!
//! Serves the rank checks: it multiplies `R Rot(axis, θ)` body by body and knows
//! nothing of canonical frames, expressions or programs.

use nalgebra::{DMatrix, Matrix3, Vector3};

use crate::chain::Chain;
use crate::snap;
use crate::tree::{Coordinate, Dof, Motion};

/// Value of a coordinate in posture `q`.
fn at(by: &Coordinate, q: &[f64]) -> f64 {
    by.factor * q[by.dof] + by.offset
}

/// `B_i(q)` of every body.
pub(crate) fn orientations(chain: &Chain, q: &[f64]) -> Vec<Matrix3<f64>> {
    let mut b: Vec<Matrix3<f64>> = Vec::with_capacity(chain.bodies.len());
    for body in &chain.bodies {
        let parent = body.parent.map_or_else(Matrix3::identity, |p| b[p]);
        let local = match body.motion {
            Motion::Revolute { axis, by } => body.rotation * snap::about(&axis, at(&by, q)),
            _ => body.rotation,
        };
        b.push(parent * local);
    }
    b
}

/// The full regressor at `q`: CoM = matrix · full parameters. 3 × full_params.
pub(crate) fn full_regressor(chain: &Chain, q: &[f64]) -> DMatrix<f64> {
    let b = orientations(chain, q);
    let mut rows = DMatrix::zeros(3, chain.full_params);
    for (i, body) in chain.bodies.iter().enumerate() {
        rows.fixed_view_mut::<3, 3>(0, body.column).copy_from(&b[i]);
        if let (Motion::Prismatic { axis, by }, Some(parent)) = (body.motion, body.parent) {
            let along: Vector3<f64> = b[parent] * axis * at(&by, q);
            rows.fixed_view_mut::<3, 1>(0, body.column + 3)
                .copy_from(&along);
        }
    }
    rows
}

/// A fixed, seedless sequence of postures spread over the limits.
///
/// Joint j takes the fractional parts of k·√(j-th prime): dense in the box, and
/// no two joints ever line up.
pub fn postures(dofs: &[Dof], count: usize) -> impl Iterator<Item = Vec<f64>> + '_ {
    let steps: Vec<f64> = primes()
        .take(dofs.len())
        .map(|p| libm::sqrt(p as f64))
        .collect();
    (0..count).map(move |k| {
        dofs.iter()
            .zip(&steps)
            .map(|(dof, step)| {
                let x = (k as f64 + 0.5) * step;
                let unit = x - libm::floor(x);
                dof.lower + unit * (dof.upper - dof.lower)
            })
            .collect()
    })
}

/// Postures for rank checks: limits set aside, every joint and every follower
/// of it moves by ±3 at one of the scales that the postures go through.
///
/// A follower geared down by 100 hardly moves when its master turns by ±3, one
/// geared up by 100 then spins; both must show what they can.
pub fn wide_postures(chain: &Chain, dofs: &[Dof], count: usize) -> Vec<Vec<f64>> {
    let mut least = vec![1.0_f64; dofs.len()];
    let mut most = vec![1.0_f64; dofs.len()];
    for by in chain.bodies.iter().filter_map(|b| b.motion.coordinate()) {
        let factor = libm::fabs(by.factor).clamp(1e-4, 1e4);
        least[by.dof] = least[by.dof].min(factor);
        most[by.dof] = most[by.dof].max(factor);
    }
    let unit: Vec<Dof> = dofs
        .iter()
        .map(|dof| Dof {
            lower: -3.0,
            upper: 3.0,
            ..dof.clone()
        })
        .collect();
    postures(&unit, count)
        .enumerate()
        .map(|(k, q)| {
            let scale = |j: usize| match k % 3 {
                0 => 1.0 / most[j],
                1 => 1.0 / libm::sqrt(most[j] * least[j]),
                _ => 1.0 / least[j],
            };
            q.iter().enumerate().map(|(j, x)| x * scale(j)).collect()
        })
        .collect()
}

fn primes() -> impl Iterator<Item = usize> {
    (2..).filter(|&n: &usize| (2..).take_while(|d| d * d <= n).all(|d| n % d != 0))
}

/// Rows beyond the columns that are enough for any number of them.
const SPARE: usize = 600;

/// How many postures tell the rank of so many columns, where each gives so many `rows`: four times
/// the rows that are needed, and no more beyond them than are enough, since what they cost goes
/// with rows · columns².
pub fn enough(columns: usize, rows: usize) -> usize {
    (4 * columns).min(columns + SPARE) / rows + 30
}

/// Pivots of a matrix of `columns` columns, given row by row, by QR with column pivoting,
/// relative to the largest one: as many as are above a tolerance are its numeric rank.
pub fn pivots(rows: &[f64], columns: usize) -> Vec<f64> {
    let rows = DMatrix::from_row_slice(rows.len() / columns.max(1), columns, rows);
    if rows.is_empty() {
        return Vec::new();
    }
    let r = rows.col_piv_qr().unpack_r();
    let largest = r[(0, 0)].abs();
    if largest == 0.0 {
        return Vec::new();
    }
    (0..r.nrows().min(r.ncols()))
        .map(|k| r[(k, k)].abs() / largest)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn postures_are_enough_and_not_four_times_as_many_for_many_columns() {
        assert_eq!([enough(20, 3), enough(200, 2)], [56, 430]);
        assert!((1..5000).all(|columns| 3 * enough(columns, 3) > columns + 80));
        assert!(2 * enough(2000, 2) < 2700);
    }
}
