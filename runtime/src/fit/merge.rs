//! Two estimates of one robot become one.

use super::{Error, Estimator};
use crate::scalar::Scalar;

impl<T: Scalar, const N: usize> Estimator<T, N> {
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

    pub(super) fn prior_readings(&self) -> f64 {
        self.prior.iter().filter(|p| **p > T::ZERO).count() as f64
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
