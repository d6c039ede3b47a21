//! Parameters from postures, on the robot: recursive least squares.
//!
//! ```text
//! min  Σ_t λ^(n−t) |S_t⁻¹ (Y_t r − cop_t)|² + |P^(−½) (r − r_prior)|²
//!  r
//! ```
//!
//! over the postures t = 1 … n: `Y_t` the two regressor rows of the CoP, `S_t` the
//! standard deviations of the reading, λ the forgetting factor. The estimator holds
//! the triangular factor of the information matrix, free of square roots,
//!
//! ```text
//! Σ Yᵀ S⁻² Y + P⁻¹ = R̄ᵀ D R̄        R̄ r = θ̄
//! ```
//!
//! and rotates every row into it as it comes (Gentleman's fast Givens rotations,
//! Algorithm AS 154, Applied Statistics 23, 1974). Rows are forgotten, the factor stays:
//! one posture costs the same time after the first as after the millionth, about
//! 4 N² multiplications and additions, and N² + 5 N + 74 numbers and 40 bytes hold it
//! all (N = 43: 8.6 kB in f32, 17.1 kB in f64). The normal equations are never
//! formed, so the condition number enters once, not squared.
//!
//! **Range.** A row is divided by its standard deviation. Entries and readings
//! up to [`Scalar::LIMIT`] of these units are taken; a pivot of less information than
//! [`Scalar::LEAST`] counts as zero, and below [`Scalar::MOST`] sums stop growing by
//! themselves. Between these bounds no rotation overflows, and so a state that is
//! finite stays finite, whatever is fed.
//!
//! **Unobservable columns.** Column k holds d_k of information beyond the columns before
//! it, of Σ_i d_i r̄_ik² in all. Where the ratio is not above [`Scalar::INDEPENDENT`]² the
//! column is *unobservable*: its parameter stays at the nominal (prior) value, and the
//! others are what the data say given that. A flat single-foot CoP never sees the
//! constant height of r_0.
//!
//! **Forgetting.** With λ < 1 about 1/(1−λ) postures count. A robot that stands still
//! then *winds up*: information fades in every direction it does not move in, and the
//! next motion makes the parameters jump. The independent prior of
//! [`Estimator::with_prior`] is the remedy, for it does not fade: every posture restores
//! one column of it, in turn, so that it never holds less than λ^N of itself.
//!
//! **Noise that lasts.** Readings of a robot that moves err alike for a while: a thousand rows
//! may be worth twenty. Postures are taken to come in the order of time, at about even
//! intervals; how many independent ones they are worth is seen in the errors of predictions
//! ([`Estimator::independent_postures`]), and [`Estimator::lasting_deviations`] are as wide as
//! that number makes them.
//!
//! **Single precision.** On the OP2 (43 parameters, noise 1 mm) f32 and f64 differ by
//! less than 1 % of the standard deviation of a parameter after 1000 postures, also of
//! 100 000 with λ = 0.9995, and by less than 10 % after 100 000 that all count. It ends
//! at 2²⁴: a sum of so many equal terms grows no further. Choose λ so that some
//! thousands of postures count, or use f64 where it is affordable.
//!
//! ```
//! use sesc_runtime::fit::{Error, Estimator};
//!
//! // Two parameters: CoP x = r_0 + cos(q) r_1, a constant y that nobody asks for.
//! let mut estimator = Estimator::<f64, 2>::with_prior(&[0.0, 0.2], &[0.1, 0.1])?;
//! for (cos, cop_x) in [(1.0, 0.31), (0.9, 0.28), (0.2, 0.07), (0.0, 0.01)] {
//!     let rows = [[1.0, cos], [0.0, 0.0]];
//!     estimator.posture(&rows, &[cop_x, 0.0], &[1e-4, 1e-4])?;
//! }
//! let [r_0, r_1] = estimator.params();
//! assert!((r_0 - 0.01).abs() < 1e-4 && (r_1 - 0.3).abs() < 1e-4);
//! assert_eq!((estimator.rank(), estimator.postures()), (2, 4));
//!
//! // A reading that is no number is refused, and nothing has changed.
//! let refused = estimator.posture(&[[1.0, 0.5], [0.0, 0.0]], &[f64::NAN, 0.0], &[1e-4, 1e-4]);
//! assert_eq!(refused, Err(Error::NotFinite));
//! # Ok::<(), Error>(())
//! ```

mod answers;
mod batch;
mod correlation;
mod error;
mod forget;
mod merge;
mod start;
mod triangle;

#[cfg(test)]
mod tests;

use crate::__private::v1::Robot;
use crate::dim::Const;
use crate::model::{Posture, Sesc};
use crate::scalar::Scalar;
pub use answers::Prediction;
pub use batch::MAX_CONDITION;
use correlation::Correlation;
pub use error::Error;
use triangle::Triangle;

/// Estimates `N` base parameters from postures, one at a time.
///
/// No function allocates or panics. Copying one is copying all of its memory:
/// [`new`](Self::new) is `const`, for a `static`.
///
/// ```
/// use sesc_generated::two_link_foot::{self as robot, BASE_PARAMS, CAD_PARAMS};
/// use sesc_runtime::fit::{Error, Estimator};
///
/// let mut parameters = Estimator::<f64, BASE_PARAMS>::with_prior(&CAD_PARAMS, &[0.01; 7])?;
/// // Whenever the robot stands still:
/// let (q, cop) = ([0.2, -0.4], [0.021, 0.001]);
/// parameters.add_posture::<robot::TwoLinkFoot>(&q, &cop, &[1e-3; 2])?;
/// let com = robot::com(&q, &parameters.params());
/// assert!((com[0] - cop[0]).abs() < 1e-3);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Estimator<T, const N: usize> {
    triangle: Triangle<T, N>,
    /// The triangle is about the difference from these.
    nominal: [T; N],
    /// 1/std² of the independent prior, zero where there is none.
    prior: [T; N],
    /// Share of the prior that the triangle still holds.
    kept: [T; N],
    /// Column whose prior is restored next.
    turn: usize,
    lambda: T,
    residual: T,
    readings: f64,
    postures: u64,
    /// Correlation in time of the x and the y readings.
    correlation: [Correlation<T>; 2],
}

impl<T: Scalar, const N: usize> Estimator<T, N> {
    /// Feed one posture: `rows` as the generated `regressor_cop` gives them, the reading
    /// `cop` (m) and its standard deviations `std` (m), each x and y.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// let rows = [[1.0, 0.0], [0.0, 1.0]];
    /// estimator.posture(&rows, &[0.01, -0.02], &[1e-3; 2])?;
    /// assert_eq!(estimator.params(), [0.01, -0.02]);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`], [`Error::Std`], [`Error::OutOfRange`]; neither row is then
    /// taken, and nothing is forgotten.
    pub fn posture(
        &mut self,
        [x, y]: &[[T; N]; 2],
        cop: &[T; 2],
        std: &[T; 2],
    ) -> Result<(), Error> {
        let x = self.weighed(x, cop[0], std[0])?;
        let y = self.weighed(y, cop[1], std[1])?;
        self.fade(self.lambda);
        let errors = [self.take(x), self.take(y)];
        for (axis, error) in self.correlation.iter_mut().zip(errors) {
            if error != T::ZERO {
                axis.push(error, self.lambda);
            }
        }
        self.postures = self.postures.saturating_add(1);
        Ok(())
    }

    /// Feed what the robot `R` measured at the joint positions `q`: `reading` as its sensor
    /// gave it (m), `std` of the CoP that stands behind it (m), each x and y.
    ///
    /// The rows are those of `R`, with the joint effects of its model (wiring, offset,
    /// scale), and the reading is freed of its sensor effects as
    /// [`CorrectCop`](crate::CorrectCop) frees it, where the model has any. What is not
    /// linear in the parameters or not the robot's (compliance, backlash, payload, a slope of
    /// the ground) stays in the reading and pulls at the parameters.
    ///
    /// ```
    /// use sesc_generated::two_link_foot::{BASE_PARAMS, CAD_PARAMS, TwoLinkFoot};
    /// use sesc_runtime::fit::{Error, Estimator};
    ///
    /// let mut estimator = Estimator::<f64, BASE_PARAMS>::with_prior(&CAD_PARAMS, &[0.01; 7])?;
    /// estimator.add_posture::<TwoLinkFoot>(&[0.2, -0.4], &[0.021, 0.001], &[1e-3; 2])?;
    /// assert_eq!(estimator.postures(), 1);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`posture`](Self::posture); [`Error::NotFinite`] also where an angle is out of the
    /// domain of [`Real::sin_cos`](crate::Real::sin_cos).
    pub fn add_posture<R: Sesc<Base = Const<N>>>(
        &mut self,
        q: &Posture<R, T>,
        reading: &[T; 2],
        std: &[T; 2],
    ) -> Result<(), Error> {
        let cop = <R::Generated as Robot>::correct_cop(reading);
        self.posture(&R::regressor_cop(q), &cop, std)
    }

    /// Feed one row, `row` · r = `value` ± `std`: another sensor, or a belief about the
    /// parameters. Forgets nothing, and is no posture.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// // The two are equal, within 1 mm.
    /// estimator.row(&[1.0, -1.0], 0.0, 1e-3)?;
    /// assert_eq!(estimator.rank(), 1);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`posture`](Self::posture).
    pub fn row(&mut self, row: &[T; N], value: T, std: T) -> Result<(), Error> {
        let row = self.weighed(row, value, std)?;
        self.take(row);
        Ok(())
    }

    /// A row in units of its standard deviation, its reading from the nominal one.
    fn weighed(&self, row: &[T; N], value: T, std: T) -> Result<([T; N], T), Error> {
        finite(row)?;
        finite(&[value, std])?;
        let weight = T::ONE / positive(std)?;
        let mut off = value;
        for (x, nominal) in row.iter().zip(&self.nominal) {
            off = off - *x * *nominal;
        }
        let (row, off) = (row.map(|x| x * weight), off * weight);
        let taken = |x: &T| x.abs() <= T::LIMIT;
        if row.iter().all(taken) && taken(&off) {
            Ok((row, off))
        } else {
            Err(Error::OutOfRange)
        }
    }

    /// Take a row; the error of its prediction by the rows before, over its deviation.
    fn take(&mut self, (row, value): ([T; N], T)) -> T {
        let left = self.triangle.include(row, value, T::ONE);
        self.residual = self.residual + left.square();
        self.readings += 1.0;
        left.error()
    }
}

fn finite<T: Scalar>(numbers: &[T]) -> Result<(), Error> {
    if numbers.iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(Error::NotFinite)
    }
}

fn positive<T: Scalar>(std: T) -> Result<T, Error> {
    if std > T::ZERO {
        Ok(std)
    } else {
        Err(Error::Std)
    }
}

fn factor<T: Scalar>(lambda: T) -> Result<T, Error> {
    if lambda > T::ZERO && lambda <= T::ONE {
        Ok(lambda)
    } else {
        Err(Error::Forgetting)
    }
}
