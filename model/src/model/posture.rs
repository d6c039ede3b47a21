//! The functions of a posture, with the effects of a model file as constants.
//!
//! Each function takes the effects that act on it: the CoP all that one posture shows,
//! functions of the body those of the body, regressor rows those of the encoders.

use crate::effects::{
    self, Catalog, ContextSource, EffectContext, Instance, Measured, PostureContext,
};
use crate::expr::{Argument, Id};
use crate::formula::Variable;
use crate::functions::{Parameters, can_be_had};
use crate::interface::{Function, Given};
use crate::model::Model;
use crate::program::{Array, Program, Shape};
use crate::tape::{Kernels, Tape, Values};

/// The robot with the foot cells of the model file.
pub(super) fn context(model: &Model) -> EffectContext<'_> {
    let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
    let mut context = EffectContext::new(model, cells, false, Catalog::standard());
    context.rounds = model.rounds;
    context
}

/// How far joints that give way are moved by moments: see [`Measured::yielding`].
pub(super) fn yielding(model: &Model) -> (Program, Vec<(usize, usize)>) {
    let context = context(model);
    let parameters = Parameters::Baked(model.params());
    let source = ContextSource::Posture;
    let mut measured = Measured::new(model, source, Given::Positions, parameters, &context.cells);
    let (instances, values) = parts(&model.effects_of(Function::Com));
    let unknowns: Vec<Id> = values.iter().map(|x| measured.constant(*x)).collect();
    effects::apply_to_body(&mut measured, &context, &instances, &unknowns);
    measured.yielding()
}

/// Effects and their unknowns.
fn parts(acting: &[&(Instance, Vec<f64>)]) -> (Vec<Instance>, Vec<f64>) {
    let instances = acting.iter().map(|(instance, _)| instance.clone());
    let values = acting.iter().flat_map(|(_, values)| values.iter().copied());
    (instances.collect(), values.collect())
}

/// The program of a function, with the parameters as constants where they are `baked`.
pub(super) fn program(
    model: &Model,
    function: Function,
    given: Given,
    baked: Option<Vec<f64>>,
) -> Option<Program> {
    if !can_be_had(model, function, given) {
        return None;
    }
    let beyond = match (&baked, function) {
        (Some(_), Function::Com | Function::Cop) => model.beyond(),
        _ => Vec::new(),
    };
    let count = beyond.len();
    let source = ContextSource::Posture;
    let (measured, outputs) = measured(model, source, function, given, baked, beyond);
    let mut program = measured.program(function, given, &outputs)?;
    if count > 0 {
        program.inputs.push(Array::new(Argument::Context, count));
    }
    Some(program)
}

/// The predicted reading of postures with their [`PostureContext`], of which only
/// gravity's direction counts. Inputs: `q`, `r`, `u`.
pub fn tilted_cop(model: &Model) -> Program {
    tilted(model, Function::Cop, 2)
}

/// The CoM of such postures, whose joints give way to gravity as it points.
pub fn tilted_com(model: &Model) -> Program {
    tilted(model, Function::Com, 3)
}

fn tilted(model: &Model, function: Function, count: usize) -> Program {
    let (measured, outputs) = measured(
        model,
        ContextSource::Tilted,
        function,
        Given::Positions,
        None,
        Vec::new(),
    );
    let inputs = vec![
        Array::new(Argument::Positions, model.dof()),
        Array::new(Argument::Parameters, model.base.params.len()),
        Array::new(Argument::Context, PostureContext::of(model).len()),
    ];
    let shape = Shape::Vector(count);
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

impl Model {
    /// A function of one posture with parameters `params`, by its program; empty where a
    /// reading is what it takes.
    pub fn evaluate(&self, function: Function, q: &[f64], params: &[f64]) -> Vec<f64> {
        let Some(program) = self.program(function, Given::Positions) else {
            return Vec::new();
        };
        let still = vec![0.0; self.dof()];
        let arguments = function.arguments(Given::Positions).into_iter();
        let arguments: Vec<Values> = arguments
            .map(|argument| match argument {
                Argument::Velocities | Argument::Accelerations => Values::Shared(&still),
                Argument::Parameters => Values::Shared(params),
                _ => Values::Shared(q),
            })
            .collect();
        let mut out = vec![0.0; program.outputs.len()];
        Tape::new(&program).run(&arguments, 1, &mut out, Kernels::LIBM);
        out
    }

    /// CoM of a posture with CAD's parameters, m: by the plain sum of
    /// [`Robot::com_by_sum`](crate::Robot::com_by_sum), unless effects move the body.
    pub fn expected_com(&self, q: &[f64]) -> [f64; 3] {
        if self.effects_of(Function::Com).is_empty() {
            return self.com_by_sum(q);
        }
        let com = self.evaluate(Function::Com, q, &self.cad_params());
        [com[0], com[1], com[2]]
    }
}

/// The measurement with the effects that act on `function`, up to what it is made of, and its
/// outputs, row-major.
fn measured(
    model: &Model,
    source: ContextSource,
    function: Function,
    given: Given,
    baked: Option<Vec<f64>>,
    beyond: Vec<Variable>,
) -> (Measured<'_>, Vec<Id>) {
    let parameters = match baked {
        Some(values) => Parameters::Baked(values),
        None => Parameters::Argument(model.param_limits.clone()),
    };
    let context = context(model);
    let mut measured = Measured::new(model, source, given, parameters, &context.cells);
    measured.beyond = beyond;
    let (instances, values) = parts(&model.effects_of(function));
    let unknowns: Vec<Id> = values.iter().map(|x| measured.constant(*x)).collect();
    let outputs = match function {
        Function::Cop => {
            effects::apply(&mut measured, &context, &instances, &unknowns);
            measured.reading.to_vec()
        }
        Function::CopJacobian => {
            effects::reading_slopes(&mut measured, &context, &instances, &unknowns)
        }
        _ => {
            effects::apply_before_sensor(&mut measured, &context, &instances, &unknowns);
            measured.outputs(function)
        }
    };
    (measured, outputs)
}
