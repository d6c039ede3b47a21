//! What is known of a node: an enclosure of its exact value, and its error.

/// Enclosure and error of a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Range {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) error: f64,
}

impl Range {
    pub(super) const fn new(lower: f64, upper: f64, error: f64) -> Range {
        Range {
            lower,
            upper,
            error,
        }
    }

    /// What is computed, taken as it is: a starting point without an error.
    pub(super) fn exact(lower: f64, upper: f64) -> Range {
        Range::new(lower, upper, 0.0)
    }

    /// Largest magnitude of the computed value.
    pub(super) fn size(self) -> f64 {
        libm::fabs(self.lower).max(libm::fabs(self.upper)) + self.error
    }

    /// Whether anything is known.
    pub(super) fn is_bounded(self) -> bool {
        self.size().is_finite() && !self.lower.is_nan() && !self.upper.is_nan()
    }
}

/// A product of magnitudes; without a bound where one of them has none.
pub(super) fn times(a: f64, b: f64) -> f64 {
    match a.is_infinite() || b.is_infinite() {
        true => f64::INFINITY,
        false => a * b,
    }
}
