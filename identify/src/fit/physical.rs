//! Fits that only real masses can give.
//!
//! ```text
//! min ‖(R W θ − z) / σ‖² + ‖v‖²       θ = θ_CAD + D S v
//! m_k ≥ floor,  m_k lo ≤ m_k c_k ≤ m_k hi
//! ```
//!
//! [lo, hi] is the box of a link ([`super::limits`]). When the plain fit breaks no
//! bound it is the answer. A free fit has a prior [`WEAK`] times wider than CAD
//! usually is, and only where a bound is active: there it settles what data leave
//! open. Standard deviations stay those of the plain fit: what bounds add is not
//! counted.

use nalgebra::DVector;
use sesc_model::Model;

use super::limits::Limits;
use super::masses::{Masses, Space};
use super::prior::Prior;
use crate::lsq::factor::Factor;
use crate::lsq::inequality::{Linear, NoAnswer};

/// Tolerances of a free fit, in units of the usual ones: masses to ten times their
/// own, CoMs to half a metre.
pub const WEAK: f64 = 100.0;

/// A fit within bounds.
#[derive(Debug, Clone)]
pub struct Physical {
    /// Base parameters, m.
    pub params: DVector<f64>,
    pub masses: Masses,
}

/// What bounds make of the `plain` fit to `factor` (σ = 1 where rows are weighted).
///
/// # Errors
/// When the search does not converge.
pub fn constrain(
    model: &Model,
    factor: &Factor,
    sigma: f64,
    prior: &Prior,
    limits: &Limits,
    plain: &DVector<f64>,
) -> Result<Physical, String> {
    let free = matches!(prior, Prior::Free);
    let width = if free { WEAK } else { 1.0 };
    let space = Space::new(model, &prior.tolerances())?;
    // No bound is felt when masses of the plain fit keep them all: for a prior, its
    // own most likely ones; without, any.
    if let Ok(mut masses) = space.nearest(plain, limits)
        && (free || masses.active.is_empty())
    {
        masses.active.clear();
        return Ok(Physical {
            params: plain.clone(),
            masses,
        });
    }
    let cad = DVector::from_vec(model.cad_params());
    let gain = width / sigma;
    let data = Linear {
        matrix: factor.r() * space.to_base() * gain,
        right: (factor.z() - factor.r() * cad) * gain,
    };
    let none = Linear::none(data.matrix.ncols());
    let masses = space.best(data, none, limits).map_err(|no| match no {
        NoAnswer::Stuck => "the search for physical masses did not converge",
        _ => "no physical masses are within the tolerances",
    })?;
    Ok(Physical {
        params: space.base(&masses.theta),
        masses,
    })
}
