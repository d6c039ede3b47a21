//! Old postures count less, a prior does not.

use super::{Error, Estimator, factor};
use crate::scalar::Scalar;

impl<T: Scalar, const N: usize> Estimator<T, N> {
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

    pub(super) fn fade(&mut self, lambda: T) {
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
}
