//! How far generated code may be from the reference: by rounding, snapping and springs.

use std::borrow::Cow;

use sesc_model::bounds::Precision;
use sesc_model::effects::Effect;
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model};

use super::motion::{JointMotion, velocities};
use super::world::magnified;

/// Derivatives by differences are this exact, relative to the robot's size.
const DIFFERENCES: f64 = 2e-10;

/// The model whose rounding counts: postures that are compared have every loose joint at an
/// end of its dead band, by a moment that rounding does not turn round. Where springs give
/// way on the way to that end, the bound of the whole model is taken.
pub(super) fn decided(model: &Model) -> Cow<'_, Model> {
    let effects = || model.effects.iter().map(|(instance, _)| instance.effect);
    let is_loose = |effect: &dyn Effect| effect.dead_band().is_some();
    if effects().any(|effect| effect.is_spring()) || !effects().any(is_loose) {
        return Cow::Borrowed(model);
    }
    let mut decided = model.clone();
    decided.effects.retain(|(i, _)| !is_loose(i.effect));
    Cow::Owned(decided)
}

/// Proven bound on the rounding error of a `program` of `model`. Infinite where nothing is
/// proven, and where there is no program because the variant cannot be had.
pub(super) fn rounding(model: &Model, program: Option<&Program>) -> f64 {
    program.map_or(f64::INFINITY, |program| {
        model.rounding(program, Precision::F64).worst
    })
}

/// How far generated code may be from the reference, m; infinite for a variant
/// that cannot be had.
pub fn allowed(model: &Model, function: Function, given: Given) -> f64 {
    let rounding = |function, given| rounding(model, model.program(function, given).as_ref());
    allowed_by(model, function, given, &rounding)
}

/// The same where [`rounding`] of each function is known.
pub(super) fn allowed_by(
    model: &Model,
    function: Function,
    given: Given,
    rounding: &dyn Fn(Function, Given) -> f64,
) -> f64 {
    let snapped: f64 = model
        .tree
        .snaps
        .iter()
        .map(|snap| snap.com_error)
        .sum::<f64>()
        + model.base.regrouping_error;
    let tilted: f64 = model.tree.snaps.iter().map(|snap| snap.angle_error).sum();
    // The CoM that rows are compared by comes from no direction.
    let com = match given {
        Given::Direction => rounding(Function::Com, Given::SinesCosines),
        given => rounding(Function::Com, given),
    };
    let com = 2.0 * com + snapped;
    // Rows times parameters: every entry's error, weighed, and a long sum's own.
    let weighed = |params: Vec<f64>| {
        let sum: f64 = params.iter().map(|x| x.abs()).sum();
        sum * (rounding(function, given) + params.len() as f64 * f64::EPSILON)
    };
    match function {
        Function::Com => com,
        Function::Cop if model.effects.is_empty() => com,
        // A sensor may magnify what is snapped, and give it another unit.
        Function::Cop => 2.0 * rounding(function, given) + snapped * magnified(model),
        Function::Zmp => {
            let moved = JointMotion::of(model).snapped(model, snapped);
            2.0 * rounding(function, given) + moved
        }
        // Not of a posture: nothing to compare.
        Function::CorrectCop => 0.0,
        Function::Regressor | Function::RegressorCop => com + weighed(model.cad_params()),
        Function::RegressorFull => com + weighed(model.chain.full_cad()),
        Function::ComJacobian | Function::ComVelocity | Function::GravityMoments => {
            // A column is a × S: turning what is below the joint by ε changes it by
            // what it moves the CoM, turning the joint itself by no more. The
            // axis of a prismatic joint turns as a whole.
            let prismatic = model.tree.dofs.iter().any(|dof| dof.prismatic);
            let turned = if prismatic { snapped + tilted } else { snapped };
            let columns: f64 = match function {
                Function::ComVelocity => velocities(model.dof()).iter().sum(),
                _ => 1.0,
            };
            2.0 * rounding(function, given)
                + columns.max(1.0) * model.largest_tie() * (DIFFERENCES * model.reach() + turned)
        }
    }
}
