//! Masses linearised about an explanation's own estimate instead of about CAD.
//!
//! ```text
//! y ≈ h(e, r_b) + ∂h/∂r (r − r_b)        r = r₀ + F z,  r_b = r₀ + F z_b
//! ```
//!
//! The search takes ∂h/∂r from the robot without effects and r_b = r₀: the product of an
//! effect and a mass error is left out. Where both are large (a gain of 2, free masses) the
//! file that holds both would not predict what was stated. Here ∂h/∂r and r_b are taken
//! where the explanation ended, and it is fitted again, until nothing changes. Further logs are
//! taken about their own masses in the same way, and fitted with the first.

use super::exact::{Exact, masses_of};
use super::further_logs::{FurtherLog, fitted_again};
use super::hypothesis::effects_of;
use super::problem::{Fit, Problem};
use super::resting;

/// Rounds, at most.
const ROUNDS: usize = 12;

/// `problem` and `fit` of all logs about the masses at which the fit ends; `None` where those of
/// CAD do.
pub(super) fn settle<'m>(
    problem: &Problem<'m>,
    fit: &Fit,
    further: &[FurtherLog],
) -> Option<(Problem<'m>, Fit)> {
    if effects_of(&fit.terms).is_empty() {
        return None;
    }
    let exact = Exact::new(problem, fit);
    // On which side a loose joint rests, the file decides by its own masses.
    if fit.terms.iter().any(|term| term.dead_band().is_some()) {
        return Some(resting::settle(&exact, problem, fit, further));
    }
    if exact.agrees(problem, fit) {
        return None;
    }
    let (mut own, mut fit) = (problem.clone(), fit.clone());
    for _ in 0..ROUNDS {
        own = exact.about(&own, &fit, masses_of(&own, &fit));
        fit = fitted_again(&own, &fit, further);
        if exact.agrees(&own, &fit) {
            break;
        }
    }
    Some((own, fit))
}
