//! What an estimator knows, and how well.

use super::{Error, Estimator, Scalar, finite};

/// What the parameters say about a row.
///
/// ```
/// use sesc_runtime::fit::{Error, Estimator, Prediction};
///
/// let estimator = Estimator::with_prior(&[0.2, 0.1], &[0.01, 0.01])?;
/// let found: Prediction<f64> = estimator.predict(&[1.0, -1.0])?;
/// assert!((found.value - 0.1).abs() < 1e-15 && (found.variance - 2e-4).abs() < 1e-15);
/// # Ok::<(), Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Prediction<T> {
    /// row · r, in the unit of the reading.
    pub value: T,
    /// Variance of `value` from that of the parameters, without the noise of a reading.
    /// Infinite where the row looks into an unobservable direction.
    pub variance: T,
}

impl<T: Scalar, const N: usize> Estimator<T, N> {
    /// The estimate, m; unobservable parameters at their nominal (prior) value. About 2 N²
    /// operations.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// estimator.row(&[2.0], 0.5, 1e-3)?;
    /// assert_eq!(estimator.params(), [0.25]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn params(&self) -> [T; N] {
        let mut params = self.triangle.solve(&self.triangle.observable());
        for (param, nominal) in params.iter_mut().zip(&self.nominal) {
            *param = *nominal + *param;
        }
        params
    }

    /// Which columns data or prior have shown, in the sense of the module. Which of
    /// several dependent columns is the unobservable one depends on their order: the last.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 1.0], 0.5, 1e-3)?;
    /// assert_eq!(estimator.observable(), [true, false]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn observable(&self) -> [bool; N] {
        self.triangle.observable()
    }

    /// Number of observable columns.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 1.0], 0.5, 1e-3)?;
    /// assert_eq!(estimator.rank(), 1);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn rank(&self) -> usize {
        self.triangle
            .observable()
            .iter()
            .filter(|observable| **observable)
            .count()
    }

    /// The change of all parameters that the unobservable column `k` stands for, with 1 at `k`:
    /// any multiple of it can be added to the estimate without changing a reading. `None` where
    /// `k` is observable, or no column.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 1.0], 0.5, 1e-3)?;
    /// // The sum is known: what one parameter gains the other loses.
    /// assert_eq!(estimator.unobservable_direction(1), Some([-1.0, 1.0]));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn unobservable_direction(&self, k: usize) -> Option<[T; N]> {
        let observable = self.triangle.observable();
        match observable.get(k) {
            Some(false) => Some(self.triangle.direction(k, &observable)),
            _ => None,
        }
    }

    /// What `row` · r is, and how sure: one more CoP, or a row of the CoM.
    ///
    /// A reading that is further from `value` than a few √(`variance` + std²) does not
    /// belong to this robot; leaving it out is up to the caller.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::with_prior(&[0.2], &[0.1])?;
    /// let far = estimator.predict(&[1.0])?;
    /// estimator.row(&[1.0], 0.25, 1e-3)?;
    /// let near = estimator.predict(&[1.0])?;
    /// assert!(near.variance < far.variance && (near.value - 0.25).abs() < 1e-4);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::NotFinite`].
    pub fn predict(&self, row: &[T; N]) -> Result<Prediction<T>, Error> {
        finite(row)?;
        let observable = self.triangle.observable();
        let change = self.triangle.solve(&observable);
        let mut value = T::ZERO;
        for ((x, nominal), change) in row.iter().zip(&self.nominal).zip(&change) {
            value = value + *x * (*nominal + *change);
        }
        let variance = match self.triangle.variance(*row, &observable) {
            (_, true) => T::INFINITY,
            (variance, false) => variance,
        };
        Ok(Prediction { value, variance })
    }

    /// Variance of parameter `k`, m², given that the unobservable parameters are nominal;
    /// infinite where `k` is unobservable, `None` where there is no such parameter.
    ///
    /// It rests on the standard deviations fed, not on the residuals, and takes every posture as
    /// independent.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// assert_eq!(estimator.variance(0), Some(f64::INFINITY));
    /// estimator.row(&[1.0], 0.25, 0.5)?;
    /// assert_eq!(estimator.variance(0), Some(0.25));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn variance(&self, k: usize) -> Option<T> {
        let mut row = [T::ZERO; N];
        *row.get_mut(k)? = T::ONE;
        let observable = self.triangle.observable();
        match observable.get(k) {
            Some(true) => Some(self.triangle.variance(row, &observable).0),
            _ => Some(T::INFINITY),
        }
    }

    /// Standard deviations of all parameters, m: roots of [`variance`](Self::variance), which
    /// take every posture as independent. About N³/3 operations.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 0.0], 0.25, 0.5)?;
    /// assert_eq!(estimator.deviations(), [0.5, f64::INFINITY]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn deviations(&self) -> [T; N] {
        let observable = self.triangle.observable();
        core::array::from_fn(|k| match observable.get(k) {
            Some(true) => {
                let mut row = [T::ZERO; N];
                if let Some(one) = row.get_mut(k) {
                    *one = T::ONE;
                }
                self.triangle.variance(row, &observable).0.root()
            }
            _ => T::INFINITY,
        })
    }

    /// [`deviations`](Self::deviations) as wide as noise that lasts makes them, m: times
    /// √([`postures`](Self::postures)/[`independent_postures`](Self::independent_postures)).
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 0.0], 0.25, 0.5)?;
    /// assert_eq!(estimator.lasting_deviations(), estimator.deviations());
    /// # Ok::<(), Error>(())
    /// ```
    pub fn lasting_deviations(&self) -> [T; N] {
        let wider = T::from_f64(self.postures_per_sample()).root();
        self.deviations().map(|std| std * wider)
    }

    /// Covariance of the parameters, m², into `out`: (R̄ᵀ D R̄)⁻¹ on the observable columns,
    /// given that the unobservable ones are nominal; those have infinite variance and
    /// covariance zero. About 2 N³/3 operations.
    ///
    /// It rests on the standard deviations fed. If these were guesses, multiply by
    /// [`residual_sum_of_squares`](Self::residual_sum_of_squares) over
    /// [`degrees_of_freedom`](Self::degrees_of_freedom) (without forgetting).
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 2>::new();
    /// estimator.row(&[1.0, 0.0], 0.1, 0.5)?;
    /// estimator.row(&[1.0, 1.0], 0.3, 0.5)?;
    /// let mut covariance = [[0.0; 2]; 2];
    /// estimator.covariance(&mut covariance);
    /// assert_eq!(covariance, [[0.25, -0.25], [-0.25, 0.5]]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn covariance(&self, out: &mut [[T; N]; N]) {
        self.triangle.covariance(&self.triangle.observable(), out);
    }

    /// The minimum of the sum in the module: squared residuals of readings and prior, each
    /// over its variance, faded by forgetting. No unit.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// estimator.row(&[1.0], 0.0, 1.0)?;
    /// estimator.row(&[1.0], 2.0, 1.0)?;
    /// assert_eq!(estimator.residual_sum_of_squares(), 2.0);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn residual_sum_of_squares(&self) -> T {
        self.residual
    }

    /// Readings and prior values, less the observable parameters: what
    /// [`residual_sum_of_squares`](Self::residual_sum_of_squares) is on average if the
    /// standard deviations are right and nothing is forgotten. Under forgetting readings
    /// fade, and this is less than that average: a fit with factor λ takes up about
    /// rank/(1 + λ) of them in the long run, not the rank.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// estimator.row(&[1.0], 0.0, 1.0)?;
    /// estimator.row(&[1.0], 2.0, 1.0)?;
    /// assert_eq!(estimator.degrees_of_freedom(), 1.0);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn degrees_of_freedom(&self) -> f64 {
        (self.readings + self.prior_readings() - self.rank() as f64).max(0.0)
    }

    /// How many independent postures those fed are worth, of the axis that has fewer; all of
    /// them unless errors of predictions show beyond chance that noise lasts.
    ///
    /// Postures of [`batch`](Self::batch) count as those that were fed one by one.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// for k in 0..4000 {
    ///     // Every reading is written ten times.
    ///     let reading = 0.1 + 1e-3 * f64::from(k / 10).sin();
    ///     estimator.posture(&[[1.0], [0.0]], &[reading, 0.0], &[1e-3; 2])?;
    /// }
    /// assert_eq!(estimator.postures(), 4000);
    /// assert!(estimator.independent_postures() < 1000.0);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn independent_postures(&self) -> f64 {
        self.postures as f64 / self.postures_per_sample()
    }

    fn postures_per_sample(&self) -> f64 {
        let axes = self.correlation.iter();
        axes.map(|axis| axis.postures_per_sample())
            .fold(1.0, f64::max)
    }

    /// Postures fed, those forgotten included.
    ///
    /// ```
    /// # use sesc_runtime::fit::{Error, Estimator};
    /// let mut estimator = Estimator::<f64, 1>::new();
    /// estimator.posture(&[[1.0], [0.0]], &[0.01, 0.0], &[1e-3; 2])?;
    /// assert_eq!(estimator.postures(), 1);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn postures(&self) -> u64 {
        self.postures
    }
}
