//! Where an estimate begins: from nothing, a nominal model, a prior, a batch fit.

use super::correlation::Correlation;
use super::triangle::Triangle;
use super::{Error, Estimator, factor, finite, positive};
use crate::scalar::Scalar;

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
}
