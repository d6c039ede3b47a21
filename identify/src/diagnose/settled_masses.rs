//! Masses linearised about an explanation's own estimate instead of about CAD.
//!
//! ```text
//! y ≈ h(e, r_b) + ∂h/∂r (r − r_b)        r = r₀ + F z,  r_b = r₀ + F z_b
//! ```
//!
//! The search takes ∂h/∂r from the robot without effects and r_b = r₀: the product of an
//! effect and a mass error is left out. Where both are large (a gain of 2, free masses) the
//! file that holds both would not predict what was stated. Here ∂h/∂r and r_b are taken
//! where the explanation ended, and it is fitted again, until nothing changes.

use super::exact::{Exact, masses_of};
use super::hypothesis::effects_of;
use super::problem::{ALL, Fit, Problem};
use super::resting;

/// Rounds, at most.
const ROUNDS: usize = 12;

/// `problem` and `fit` about the masses at which the fit ends; `None` where those of CAD do.
pub(super) fn settle<'m>(problem: &Problem<'m>, fit: &Fit) -> Option<(Problem<'m>, Fit)> {
    if effects_of(&fit.terms).is_empty() {
        return None;
    }
    let exact = Exact::new(problem, fit);
    // On which side a loose joint rests, the file decides by its own masses.
    if fit.terms.iter().any(|term| term.dead_band().is_some()) {
        return Some(resting::settle(&exact, problem, fit));
    }
    if exact.agrees(problem, fit) {
        return None;
    }
    let mut own = exact.about(problem, fit, masses_of(problem, fit));
    let mut fit = own.fit(&fit.terms, Some(&fit.unknowns), ALL);
    for _ in 1..ROUNDS {
        if exact.agrees(&own, &fit) {
            break;
        }
        own = exact.about(&own, &fit, masses_of(&own, &fit));
        fit = own.fit(&fit.terms, Some(&fit.unknowns), ALL);
    }
    Some((own, fit))
}
