//! Many postures at once, by normal equations and one refinement.
//!
//! ```text
//! G = Σ w² Yᵀ Y = R̄ᵀ D R̄        G δ = Σ w² Yᵀ e
//! ```
//!
//! Sums of products cost a twentieth of rotations but square the condition number κ. A
//! second pass over the postures mends that: with residuals taken anew at the estimate,
//! `G Δ = Σ w² Yᵀ (cop − Y r)` leaves an error of order ε²κ⁴ + ε κ instead of ε κ²
//! (iterative refinement; Björck, "Numerical Methods for Least Squares Problems", 1996,
//! section 2.9). Postures whose rows are worse conditioned than [`MAX_CONDITION`] are rotated in
//! one by one.

use core::marker::PhantomData;

use super::triangle::Triangle;
use super::{Error, Estimator, Scalar, finite, positive};
use crate::__private::v1::{Array, Robot};
use crate::dim::Const;
use crate::model::{Posture, Sesc};
use crate::scalar::{Simd, sealed::Dispatch};
use crate::simd::normal::{Data, Products, Residuals, Sums};

/// Postures whose products are summed before they enter the triangle.
const CHUNK: usize = 1 << 16;

/// Largest condition number κ of rows that [`Estimator::batch`] sums as products; it
/// rotates in, one by one, the postures of a worse one.
///
/// ```
/// use sesc_runtime::fit;
///
/// // Its square, which sums of products have, leaves half of the digits of f64.
/// assert!(fit::MAX_CONDITION.powi(2) * f64::EPSILON < 1e-6);
/// ```
pub const MAX_CONDITION: f64 = 65536.0;

/// A column that keeps less than this share of its information beside the columns before
/// it belongs to a larger condition number.
const LEAST_SHARE: f64 = 1.0 / (MAX_CONDITION * MAX_CONDITION);

impl<const N: usize> Estimator<f64, N> {
    /// The estimate from what this one knows and all of these postures: as
    /// [`posture`](Self::posture) in turn would give it, many times faster.
    ///
    /// `q[k]` are the joint positions of posture k of the robot `R`, `cop[k]` its reading
    /// (m), `std` the standard deviations of x and y (m), alike for all. Takes about
    /// 64 N (N + 48) bytes of stack beside its own size (N = 43: 250 kB): partial sums of
    /// eight lanes and a panel of rows. Several estimators, each with its share of the
    /// postures, [`merge`](Self::merge). With forgetting, postures are fed in turn.
    ///
    /// ```
    /// use sesc_generated::two_link_foot::{self as robot, TwoLinkFoot};
    /// use sesc_runtime::fit::{Error, Estimator};
    /// use sesc_runtime::{Const, Posture, Sesc, Simd};
    ///
    /// /// Parameters of any robot; only their number, which the compiler finds, is named.
    /// fn identify<R: Sesc<Base = Const<N>>, const N: usize>(
    ///     q: &[Posture<R>],
    ///     cop: &[[f64; 2]],
    /// ) -> Result<[f64; N], Error> {
    ///     let cad = Estimator::with_nominal(&R::CAD_PARAMS)?;
    ///     Ok(cad.batch::<R>(Simd::best(), q, cop, &[1e-3, 1e-3])?.params())
    /// }
    ///
    /// let q: [_; 50] = core::array::from_fn(|k| [0.01 * k as f64, (0.3 * k as f64).sin()]);
    /// let cop = q.map(|q| robot::cop(&q, &robot::CAD_PARAMS));
    /// let found = identify::<TwoLinkFoot, _>(&q, &cop)?;
    /// assert!((found[0] - robot::CAD_PARAMS[0]).abs() < 1e-12);
    ///
    /// let lengths = Error::Length { postures: 50, readings: 49 };
    /// assert_eq!(identify::<TwoLinkFoot, _>(&q, &cop[..49]), Err(lengths));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Length`]; [`Error::NotFinite`], also where a posture has no finite row;
    /// [`Error::Std`]; [`Error::OutOfRange`].
    pub fn batch<R: Sesc<Base = Const<N>>>(
        &self,
        simd: Simd,
        q: &[Posture<R>],
        cop: &[[f64; 2]],
        std: &[f64; 2],
    ) -> Result<Self, Error> {
        let count = q.len();
        if cop.len() != count {
            return Err(Error::Length {
                postures: count,
                readings: cop.len(),
            });
        }
        finite(std)?;
        let weight = [1.0 / positive(std[0])?, 1.0 / positive(std[1])?];
        if weight.iter().any(|weight| *weight > f64::LIMIT) {
            return Err(Error::OutOfRange);
        }
        let mut found = self.clone();
        if self.lambda < 1.0 {
            found.in_turn::<R::Generated>(q, cop, std)?;
            return Ok(found);
        }
        let whole = count - count % 8;
        let mut products = false;
        for (q, cop) in q[..whole].chunks(CHUNK).zip(cop[..whole].chunks(CHUNK)) {
            let data = Data::<R::Generated> {
                q,
                cop,
                weight,
                model: PhantomData,
            };
            let mut sums = Sums::zero();
            f64::run(
                simd,
                Products {
                    data: &data,
                    sums: &mut sums,
                },
            );
            // Readings from the nominal ones.
            for i in 0..N {
                for (j, nominal) in self.nominal.iter().enumerate() {
                    sums.right[i] -= sums.gram[i.max(j)][i.min(j)] * nominal;
                }
            }
            if found.take_sums(&sums, q.len())? {
                products = true;
            } else {
                found.in_turn::<R::Generated>(q, cop, std)?;
            }
        }
        found.in_turn::<R::Generated>(&q[whole..], &cop[whole..], std)?;
        if products {
            found.refine::<R::Generated>(self, simd, q, cop, weight);
        }
        Ok(found)
    }

    fn in_turn<M: Robot<Base = Const<N>>>(
        &mut self,
        q: &[Array<M::Dof, f64>],
        cop: &[[f64; 2]],
        std: &[f64; 2],
    ) -> Result<(), Error> {
        for (q, cop) in q.iter().zip(cop) {
            self.posture(&<M as Sesc>::regressor_cop(q), cop, std)?;
        }
        Ok(())
    }

    /// Rotate summed products in; false, and nothing changed, where they are too badly
    /// conditioned.
    fn take_sums(&mut self, sums: &Sums<N>, postures: usize) -> Result<bool, Error> {
        if !sums.is_finite() {
            return Err(Error::NotFinite);
        }
        let information = self.triangle.information();
        for (k, column) in information.iter().enumerate() {
            if sums.gram[k][k] > f64::LIMIT * f64::LIMIT || column + sums.gram[k][k] > f64::MOST {
                return Err(Error::OutOfRange);
            }
        }
        let Some(part) = factorise(sums) else {
            return Ok(false);
        };
        for i in 0..N {
            if part.weights[i] > 0.0 {
                // What is left over is known after the second pass.
                let (line, value) = (part.line(i), part.values[i]);
                self.triangle.include(line, value, part.weights[i]);
            }
        }
        self.readings += 2.0 * postures as f64;
        self.postures = self.postures.saturating_add(postures as u64);
        Ok(true)
    }

    /// One step of refinement over the same postures; `start` is what was known before.
    fn refine<M: Robot<Base = Const<N>>>(
        &mut self,
        start: &Self,
        simd: Simd,
        q: &[Array<M::Dof, f64>],
        cop: &[[f64; 2]],
        weight: [f64; 2],
    ) {
        let observable = self.triangle.observable();
        let change = self.triangle.solve(&observable);
        let params: [f64; N] = core::array::from_fn(|k| self.nominal[k] + change[k]);
        let mut sums = Sums::zero();
        let whole = q.len() - q.len() % 8;
        let data = Data::<M> {
            q,
            cop,
            weight,
            model: PhantomData,
        };
        f64::run(
            simd,
            Residuals {
                data: &data,
                params,
                sums: &mut sums,
            },
        );
        for (q, cop) in q[whole..].iter().zip(&cop[whole..]) {
            for (axis, row) in <M as Sesc>::regressor_cop(q).iter().enumerate() {
                let mut e = cop[axis];
                for (y, r) in row.iter().zip(&params) {
                    e -= y * r;
                }
                let e = e * weight[axis];
                for (sum, y) in sums.right.iter_mut().zip(row) {
                    *sum += y * weight[axis] * e;
                }
                sums.square += e * e;
            }
        }
        let mut cost = start.residual + sums.square;
        for i in 0..N {
            let line = start.triangle.line(i);
            let mut off = start.triangle.values[i];
            for (r, x) in line.iter().zip(&change) {
                off -= r * x;
            }
            for (sum, r) in sums.right.iter_mut().zip(&line) {
                *sum += r * start.triangle.weights[i] * off;
            }
            cost += start.triangle.weights[i] * off * off;
        }
        // R̄ᵀ D R̄ Δ = g
        let mut values = [0.0; N];
        for i in 0..N {
            if observable[i] {
                let value = sums.right[i];
                for (k, r) in self.triangle.lines[i].iter().enumerate().skip(i + 1) {
                    sums.right[k] -= r * value;
                }
                values[i] = value / self.triangle.weights[i];
                cost -= value * values[i];
            }
        }
        for (i, value) in values.into_iter().enumerate() {
            if observable[i] {
                // At the estimate a row holds up to rounding; the rest of it need not be kept.
                self.triangle.values[i] += value;
            }
        }
        self.residual = cost.max(0.0);
    }
}

/// The triangle of sums of products; `None` where rounding may have decided a pivot.
fn factorise<const N: usize>(sums: &Sums<N>) -> Option<Triangle<f64, N>> {
    let mut triangle = Triangle::empty();
    for i in 0..N {
        let column = sums.gram[i][i];
        if column < f64::LEAST {
            continue;
        }
        let (mut pivot, mut right) = (column, sums.right[i]);
        for k in 0..i {
            let r = triangle.lines[k][i];
            pivot -= triangle.weights[k] * r * r;
            right -= triangle.weights[k] * r * triangle.values[k];
        }
        if pivot <= LEAST_SHARE * column {
            return None;
        }
        for j in i + 1..N {
            let mut product = sums.gram[j][i];
            for k in 0..i {
                product -= triangle.weights[k] * triangle.lines[k][i] * triangle.lines[k][j];
            }
            triangle.lines[i][j] = product / pivot;
        }
        triangle.weights[i] = pivot;
        triangle.values[i] = right / pivot;
    }
    Some(triangle)
}
