//! What an estimator refuses.

use core::fmt;

/// Why an estimator refused its input; its state is as it was before.
///
/// ```
/// use sesc_runtime::fit::{Error, Estimator};
///
/// let refused = Estimator::<f64, 2>::with_nominal(&[0.1, f64::NAN]).unwrap_err();
/// assert_eq!(refused, Error::NotFinite);
/// assert_eq!(refused.to_string(), "a number is NaN or infinite; leave this reading out");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// A number is NaN or infinite.
    NotFinite,
    /// A standard deviation is zero or negative.
    Std,
    /// A forgetting factor is outside (0, 1].
    Forgetting,
    /// An information factor is no triangle of as many columns as there are parameters.
    Factor,
    /// A row entry or a reading is more than [`LIMIT`](crate::Scalar::LIMIT)
    /// standard deviations large, or two estimators together hold more
    /// information than [`MOST`](crate::Scalar::MOST).
    OutOfRange,
    /// There are not as many readings as postures.
    Length {
        /// Postures given.
        postures: usize,
        /// Readings given.
        readings: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sentence = match self {
            Self::NotFinite => "a number is NaN or infinite; leave this reading out",
            Self::Std => "a standard deviation is not positive; give the noise of the reading",
            Self::Forgetting => "the forgetting factor is outside (0, 1]; 1 forgets nothing",
            Self::Factor => {
                "the information factor is not N (N + 1)/2 numbers with a diagonal of zero or \
                 more, and rows of zeros where it is zero; take MODEL_INFORMATION"
            }
            Self::OutOfRange => {
                "too many standard deviations for this scalar; give a larger one, or use f64"
            }
            Self::Length { postures, readings } => {
                return write!(
                    f,
                    "{postures} postures but {readings} readings; give one for each"
                );
            }
        };
        f.write_str(sentence)
    }
}

impl core::error::Error for Error {}
