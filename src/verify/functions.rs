//! The functions of a model that are compared: their programs on tape, and how far each may be
//! from the reference.

use std::borrow::Cow;

use sesc_codegen::emit::header::function_name;
use sesc_identify::evaluate::Evaluator;
use sesc_identify::threads::each_long;
use sesc_model::{Function, Given, Model};

use super::allowed::{allowed_by, decided, rounding};
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

/// A function, and the proven bound on its rounding error.
struct Prepared {
    function: Function,
    given: Given,
    evaluator: Evaluator,
    rounding: f64,
}

/// Prepares every function of `model` for comparison. Joints move as `joints`; bounds of a
/// `bent` robot allow for what its springs leave out. The robot's `reach` is in m.
pub(super) fn functions(
    model: &Model,
    bent: Option<&Bent>,
    joints: &JointMotion,
    reach: f64,
) -> Vec<Compares> {
    let givens = [Given::Positions, Given::SinesCosines, Given::Direction];
    let all = givens
        .into_iter()
        .flat_map(|given| Function::ALL.map(|function| (given, function)));
    let decided = decided(model);
    let prepare = |(given, function): (Given, Function)| {
        let program = model.program(function, given)?;
        let evaluator =
            Evaluator::of_function(model, &program, function, given, model.cad_params());
        let evaluator = match function {
            Function::Zmp => evaluator.moving(&joints.rates, &joints.accelerations),
            _ => evaluator.moving(&velocities(model.dof()), &[]),
        };
        let rounding = match &decided {
            Cow::Borrowed(_) => rounding(model, Some(&program)),
            Cow::Owned(decided) => rounding(decided, decided.program(function, given).as_ref()),
        };
        Some(Prepared {
            function,
            given,
            evaluator,
            rounding,
        })
    };
    let prepared = each_long(all, prepare);
    let prepared: Vec<Prepared> = prepared.into_iter().flatten().collect();
    let roundings: Vec<(Function, Given, f64)> = prepared
        .iter()
        .map(|own| (own.function, own.given, own.rounding))
        .collect();
    let rounding = |function: Function, given: Given| {
        let own = roundings
            .iter()
            .find(|own| (own.0, own.1) == (function, given));
        own.map_or(f64::INFINITY, |own| own.2)
    };
    let compares = |prepared: Prepared| {
        let Prepared {
            function,
            given,
            evaluator,
            ..
        } = prepared;
        let own = bent.map(|bent| beyond_rounding(model, function, bent.allowed_for_springs()));
        let allowed = match allowed_by(&decided, function, given, &rounding) {
            infinite if own.is_some() && infinite.is_infinite() => UNPROVEN_M * magnified(model),
            proven => proven,
        };
        // Springs beside dead bands have bounds of millimetres, which are told by name.
        let is_of_use = own.is_some() || allowed <= USEFUL * reach;
        let allowed = match is_of_use {
            true => allowed,
            // What is infinite or no number stays so, and fails.
            false if allowed.is_finite() => UNPROVEN_OF_REACH * reach,
            false => allowed,
        };
        Compares {
            name: function_name(function, given),
            function,
            params: explained_by(model, function),
            evaluator,
            bound: allowed + own.unwrap_or(0.0),
            is_of_use,
        }
    };
    prepared.into_iter().map(compares).collect()
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
