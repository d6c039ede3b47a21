//! Whether the soles of both feet close under an explanation, and how that is said.

use super::criteria;
use super::problem::{Fit, Problem};
use crate::Error;
use crate::feet::{Closure, ClosureFound, Feet, of_many, of_one_foot, tell_contacts};
use crate::logs::Sidecar;
use crate::observations::postures::Postures;
use crate::watch::Watch;

/// The soles of a log of both feet, which the caller, its sidecar or its contacts say; `None` of
/// one that stands on one foot. Where each foot has its own contact, the `data` learn what joints
/// do to that.
///
/// # Errors
/// When the other sole cannot be told.
pub(super) fn of(
    feet: &Feet,
    sidecar: &Sidecar,
    model: &sesc_model::Model,
    data: &mut Postures,
    watch: &mut dyn Watch,
) -> Result<Option<Closure>, Error> {
    let mut sidecar = sidecar.clone();
    sidecar.other_foot = sidecar.other_foot.or_else(|| data.other_foot.clone());
    let Some(other) = feet.of(&sidecar, model)? else {
        return Ok(None);
    };
    if let Some(note) = of_many(model, &other) {
        watch.note(&note);
    }
    if let Some(warning) = of_one_foot(model, &other, data) {
        watch.warning(&warning.into());
    }
    tell_contacts(data, model, &other);
    Ok(Some(Closure::of(model, other, &data.q, data.t.as_deref())))
}

/// Whether more is left of the soles than noise leaves.
pub(super) fn is_open(problem: &Problem, fit: &Fit) -> bool {
    let pair = problem
        .first()
        .closure
        .as_deref()
        .zip(fit.blocks[0].closed.as_ref());
    pair.is_some_and(|(closure, closed)| {
        let (chi2, expected) = closure.chi2(&closed.residual);
        chi2 > criteria::LEFTOVER_RATIO_OF_RESIDUALS * expected
    })
}

/// What is said of the soles, by CAD (`null`) and with the explanation.
pub(super) fn said(problem: &Problem, null: &Fit, best: &Fit) -> Option<ClosureFound> {
    let closure = problem.first().closure.as_deref()?;
    let (before, after) = (
        null.blocks[0].closed.as_ref()?,
        best.blocks[0].closed.as_ref()?,
    );
    let found = closure.said(&before.residual, &after.residual);
    let changed = !best.terms.is_empty() && found.after != found.before;
    Some(found.explained(changed))
}
