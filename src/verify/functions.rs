//! The functions of a model that are compared: their programs on tape, and how far each may be
//! from the reference.

use std::borrow::Cow;

use sesc_codegen::emit::header::function_name;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::threads::each_long;
use sesc_model::bounds::Precision;
use sesc_model::effects::Effect;
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model};

use super::compare::Compares;
use super::motion::{JointMotion, velocities};
use super::world::{Bent, beyond_rounding, magnified};

/// Part of the robot's reach from which on a bound is too wide to verify anything.
pub const USEFUL: f64 = 1e-3;

/// Part of the robot's reach that is allowed where the proven bound is of no use.
pub const UNPROVEN_OF_REACH: f64 = 1e-9;

/// What is allowed where an effect of the model file divides or takes powers, so that no
/// bound is proven, m.
const UNPROVEN_M: f64 = 1e-9;

/// Prepares every function of `model` for comparison. Bounds of a `bent` robot allow for what its
/// springs leave out. The robot's `reach` is in m.
pub(super) fn functions(model: &Model, bent: Option<&Bent>, reach: f64) -> Vec<Compares> {
    let givens = [Given::Positions, Given::SinesCosines, Given::Direction];
    let all = givens
        .into_iter()
        .flat_map(|given| Function::ALL.map(|function| (given, function)));
    let decided = decided(model);
    let prepare = |(given, function): (Given, Function)| {
        let program = model.program(function, given)?;
        let evaluator =
            Evaluator::of_function(model, &program, function, given, model.cad_params());
        let rounding = match &decided {
            Cow::Borrowed(_) => rounding(model, Some(&program)),
            Cow::Owned(decided) => rounding(decided, decided.program(function, given).as_ref()),
        };
        Some((((function, given), rounding), evaluator))
    };
    let prepared = each_long(all, prepare).into_iter().flatten();
    let (roundings, evaluators): (Vec<_>, Vec<Evaluator>) = prepared.unzip();
    let rounding = |function: Function, given: Given| {
        let own = roundings.iter().find(|own| own.0 == (function, given));
        own.map_or(f64::INFINITY, |own| own.1)
    };
    let compares =
        |(&((function, given), _), evaluator): (&((Function, Given), f64), Evaluator)| {
            let own = bent.map(|bent| beyond_rounding(model, function, bent.allowed_for_springs()));
            let mut allowed = allowed_by(&decided, function, given, &rounding);
            if own.is_some() && allowed.is_infinite() {
                allowed = UNPROVEN_M * magnified(model);
            }
            // Springs beside dead bands have bounds of millimetres, which are told by name.
            let is_of_use = own.is_some() || allowed <= USEFUL * reach;
            // What is infinite or no number stays so, and fails.
            if !is_of_use && allowed.is_finite() {
                allowed = UNPROVEN_OF_REACH * reach;
            }
            Compares {
                name: function_name(function, given),
                function,
                params: explained_by(model, function),
                evaluator,
                bound: allowed + own.unwrap_or(0.0),
                is_of_use,
            }
        };
    roundings.iter().zip(evaluators).map(compares).collect()
}

/// What rows of a function are multiplied with to be compared, if it has any.
fn explained_by(model: &Model, function: Function) -> Vec<f64> {
    match function {
        Function::Regressor | Function::RegressorCop => model.cad_params(),
        Function::RegressorFull => model.chain.full_cad(),
        Function::ComVelocity => velocities(model.dof()),
        _ => Vec::new(),
    }
}

// How far generated code may be from the reference: by rounding, snapping and springs.

/// Derivatives by differences are this exact, relative to the robot's size.
const DIFFERENCES: f64 = 2e-10;

/// The model whose rounding counts: postures that are compared have every loose joint at an
/// end of its dead band, by a moment that rounding does not turn round. Where springs give
/// way on the way to that end, the bound of the whole model is taken.
fn decided(model: &Model) -> Cow<'_, Model> {
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
fn rounding(model: &Model, program: Option<&Program>) -> f64 {
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
fn allowed_by(
    model: &Model,
    function: Function,
    given: Given,
    rounding: &dyn Fn(Function, Given) -> f64,
) -> f64 {
    let snaps = model.tree.snaps.iter();
    let tilted: f64 = snaps.clone().map(|snap| snap.angle_error).sum();
    let snapped: f64 = snaps.map(|snap| snap.com_error).sum();
    let snapped = snapped + model.base.regrouping_error;
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
        Function::ComJacobian
        | Function::ComVelocity
        | Function::GravityMoments
        | Function::CopJacobian => {
            // A column is a × S: turning what is below the joint by ε changes it by
            // what it moves the CoM, turning the joint itself by no more. The
            // axis of a prismatic joint turns as a whole.
            let prismatic = model.tree.dofs.iter().any(|dof| dof.prismatic);
            let turned = if prismatic { snapped + tilted } else { snapped };
            let columns: f64 = match function {
                Function::ComVelocity => velocities(model.dof()).iter().sum(),
                _ => 1.0,
            };
            // A sensor may magnify what is snapped and what differences leave.
            let sensor = match function {
                Function::CopJacobian => magnified(model),
                _ => 1.0,
            };
            2.0 * rounding(function, given)
                + sensor
                    * columns.max(1.0)
                    * model.largest_tie()
                    * (DIFFERENCES * model.reach() + turned)
        }
    }
}
