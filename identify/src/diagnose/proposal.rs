//! A hypothesis proposed for a fit, with its predicted score.

use super::hypothesis::Term;
use super::problem::Fit;

/// A hypothesis to be fitted.
pub struct Proposal {
    pub terms: Vec<Term>,
    /// Score to first order.
    pub predicted_score: f64,
    pub parent: Option<Fit>,
}
