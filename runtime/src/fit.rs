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
    /// Of x and y.
    correlation: [Correlation<T>; 2],
}

impl<T: Scalar, const N: usize> Default for Estimator<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar, const N: usize> Estimator<T, N> {
    /// An estimator without data; unobservable parameters are zero.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// static PARAMETERS: Estimator<f32, 7> = Estimator::new();
    /// assert_eq!(PARAMETERS.rank(), 0);
    /// ```
    pub const fn new() -> Self {
        Self {
            triangle: Triangle::empty(),
            nominal: [T::ZERO; N],
            prior: [T::ZERO; N],
            kept: [T::ONE; N],
            turn: 0,
            lambda: T::ONE,
            residual: T::ZERO,
            readings: 0.0,
            postures: 0,
            correlation: [Correlation::EMPTY, Correlation::EMPTY],
        }
    }

    /// An estimator without data; unobservable parameters are those of `nominal` (m), the CAD for example.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let cad = Estimator::with_nominal(&[0.1, 0.2])?;
    /// assert_eq!((cad.params(), cad.rank()), ([0.1, 0.2], 0));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`].
    pub fn with_nominal(nominal: &[T; N]) -> Result<Self, Error> {
        finite(nominal)?;
        let mut estimator = Self::new();
        estimator.nominal = *nominal;
        Ok(estimator)
    }

    /// Each parameter is known to be `mean[k]` ± `std[k]` (m), independently.
    ///
    /// This prior is not forgotten. A prior with correlations is entered by
    /// [`row`](Self::row): line i of the upper triangular factor F of its information
    /// matrix (P⁻¹ = Fᵀ F) is a row of std 1 whose value is that line times the mean.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let cad = Estimator::with_prior(&[0.1, 0.2], &[0.01, 0.02])?;
    /// assert_eq!((cad.params(), cad.rank()), ([0.1, 0.2], 2));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`], [`Error::Std`]; [`Error::OutOfRange`] where 1/std exceeds
    /// [`Scalar::LIMIT`].
    pub fn with_prior(mean: &[T; N], std: &[T; N]) -> Result<Self, Error> {
        finite(std)?;
        let mut estimator = Self::with_nominal(mean)?;
        for (prior, std) in estimator.prior.iter_mut().zip(std) {
            let weight = T::ONE / positive(*std)?;
            if weight > T::LIMIT {
                return Err(Error::OutOfRange);
            }
            if weight * weight >= T::LEAST {
                *prior = weight * weight;
            }
        }
        estimator.triangle.weights = estimator.prior;
        Ok(estimator)
    }

    /// Goes on from a batch fit: `params` (m) and the packed triangle `factor` of their
    /// information, R with RᵀR = C⁻¹ row by row from the diagonal on, 1/m, as the
    /// generated `MODEL_PARAMS` and `MODEL_INFORMATION` hold them.
    ///
    /// What comes after counts as if the batch fit had had it too. Both are `f64`, whatever
    /// the scalar of the estimator, and under [`forgetting`](Self::forgetting) they fade
    /// as readings do. A parameter whose row is zero stays as it is until readings show it.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// // 0.1 ± 0.01 and 0.2 ± 0.02, known independently.
    /// let mut estimator = Estimator::<f32, 2>::resume(&[0.1, 0.2], &[100.0, 0.0, 50.0])?;
    /// assert_eq!((estimator.params(), estimator.rank()), ([0.1, 0.2], 2));
    /// assert!((estimator.deviations()[1] - 0.02).abs() < 1e-8);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`]; [`Error::Factor`] where `factor` has not N (N + 1)/2 numbers, or
    /// a diagonal below zero, or of zero with numbers behind it; [`Error::OutOfRange`] where
    /// it holds more than [`Scalar::MOST`].
    pub fn resume(params: &[f64; N], factor: &[f64]) -> Result<Self, Error> {
        let mut estimator = Self::with_nominal(&params.map(T::from_f64))?;
        estimator.triangle = Triangle::of_factor(factor)?;
        let weights = estimator.triangle.weights.iter();
        estimator.readings = weights.filter(|weight| **weight > T::ZERO).count() as f64;
        Ok(estimator)
    }

    /// Multiply the information by `lambda` before every posture: 1 forgets nothing.
    ///
    /// See the module on winding up.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// // About the last 1000 postures count.
    /// let estimator = Estimator::<f64, 2>::new().forgetting(0.999)?;
    /// assert!(estimator.forgetting(1.5).is_err());
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Forgetting`] outside (0, 1].
    pub fn forgetting(mut self, lambda: T) -> Result<Self, Error> {
        self.lambda = factor(lambda)?;
        Ok(self)
    }

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

    /// Multiply the information by `lambda` once, as every posture does by the factor of
    /// [`forgetting`](Self::forgetting), and restore one column of the prior.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// estimator.row(&[1.0], 0.1, 1.0)?;
    /// estimator.forget(0.5)?;
    /// assert_eq!(estimator.variance(0), Some(2.0));
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Forgetting`] outside (0, 1].
    pub fn forget(&mut self, lambda: T) -> Result<(), Error> {
        self.fade(factor(lambda)?);
        Ok(())
    }

    /// Take over all that `other` knows, as if its rows had been fed here.
    ///
    /// That includes its prior, as if it were data: two estimators that start from
    /// one belief would count it twice, so give it to one of them and start the other
    /// [`with_nominal`](Self::with_nominal) its mean. The forgetting factor stays.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let (mut first, mut second) = (Estimator::<f64, 1>::new(), Estimator::new());
    /// first.row(&[1.0], 0.1, 1e-3)?;
    /// second.row(&[1.0], 0.3, 1e-3)?;
    /// first.merge(&second)?;
    /// assert!((first.params()[0] - 0.2).abs() < 1e-15);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] where both together exceed [`Scalar::MOST`].
    pub fn merge(&mut self, other: &Self) -> Result<(), Error> {
        let (mine, theirs) = (self.triangle.information(), other.triangle.information());
        if mine.iter().zip(&theirs).any(|(a, b)| *a + *b > T::MOST) {
            return Err(Error::OutOfRange);
        }
        let fits = |value: T, weight: T| weight == T::ZERO || weight * value * value <= T::MOST;
        if !self
            .shifted(other)
            .all(|(_, value, weight)| fits(value, weight))
        {
            return Err(Error::OutOfRange);
        }
        for (row, value, weight) in self.shifted(other) {
            self.residual = self.residual + self.triangle.include(row, value, weight).square();
        }
        self.residual = self.residual + other.residual;
        self.readings += other.readings + other.prior_readings();
        self.postures = self.postures.saturating_add(other.postures);
        for (axis, other) in self.correlation.iter_mut().zip(&other.correlation) {
            axis.merge(other);
        }
        Ok(())
    }

    fn prior_readings(&self) -> f64 {
        self.prior.iter().filter(|p| **p > T::ZERO).count() as f64
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

    fn fade(&mut self, lambda: T) {
        if lambda < T::ONE {
            self.lighten(lambda);
        }
        // The prior comes back in turn, also after a single `forget`.
        let turn = self.turn;
        if turn < N {
            let lost = self.prior[turn] * (T::ONE - self.kept[turn]);
            if lost >= T::LEAST {
                let mut row = [T::ZERO; N];
                row[turn] = T::ONE;
                self.residual = self.residual + self.triangle.include(row, T::ZERO, lost).square();
                self.kept[turn] = T::ONE;
            }
            self.turn = turn + 1;
        }
        if self.turn >= N {
            self.turn = 0;
        }
    }

    /// Multiply all information by λ.
    fn lighten(&mut self, lambda: T) {
        self.readings *= lambda.to_f64();
        self.residual = self.residual * lambda;
        for i in 0..N {
            self.kept[i] = self.kept[i] * lambda;
            let weight = self.triangle.weights[i] * lambda;
            self.triangle.weights[i] = weight;
            if weight < T::LEAST && weight > T::ZERO {
                self.residual = self.residual + self.triangle.drop_pivot(i);
            }
        }
    }

    /// The lines of `other` about the own nominal parameters: row, value, weight.
    fn shifted<'a>(&self, other: &'a Self) -> impl Iterator<Item = ([T; N], T, T)> + use<'a, T, N> {
        let nominal = self.nominal;
        let values = other.triangle.values.iter().zip(&other.triangle.weights);
        values.enumerate().map(move |(i, (value, weight))| {
            let (line, mut value) = (other.triangle.line(i), *value);
            for ((x, theirs), mine) in line.iter().zip(&other.nominal).zip(&nominal) {
                value = value + *x * (*theirs - *mine);
            }
            (line, value, *weight)
        })
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
