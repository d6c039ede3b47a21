//! Functions of any robot at near-native speed: programs on tape.

use sesc_codegen::program::Program;
use sesc_codegen::tape::{Argument, Lane, Tape};
use sesc_codegen::{Function, Given, Model};

/// One function of a model, ready for batches of postures.
pub struct Evaluator {
    tape: Tape,
    dof: usize,
    params: Option<Vec<f64>>,
}

impl Evaluator {
    /// Prepare `function` of `model` with the model's parameters.
    pub fn new(model: &Model, function: Function) -> Evaluator {
        Evaluator::with_params(model, function, model.params())
    }

    /// Prepare `function` with parameters `params` (base parameters, m).
    pub fn with_params(model: &Model, function: Function, params: Vec<f64>) -> Evaluator {
        let program = model
            .program(function, Given::Positions)
            .expect("every function can be had from joint positions");
        Evaluator {
            tape: Tape::new(&program),
            dof: model.dof(),
            params: function.takes_parameters().then_some(params),
        }
    }

    /// Prepare any program of joint positions and the model's parameters.
    pub fn of(model: &Model, program: &Program) -> Evaluator {
        Evaluator {
            tape: Tape::new(program),
            dof: model.dof(),
            params: (program.inputs.len() > 1).then(|| model.params()),
        }
    }

    /// Values per posture.
    pub fn width(&self) -> usize {
        self.tape.outputs()
    }

    /// Evaluate `postures` postures, `q[posture * dof + joint]`, row by row.
    pub fn run(&self, q: &[f64], postures: usize) -> Vec<f64> {
        let mut out = vec![0.0; postures * self.width()];
        let q = &q[..postures * self.dof];
        let mut arguments = vec![Argument::PerPosture(q)];
        arguments.extend(self.params.as_deref().map(Argument::Shared));
        self.tape.run(&arguments, postures, &mut out, sin_cos);
        out
    }
}

/// The runtime's kernel: what generated code computes, the tape computes.
pub fn sin_cos(angle: &Lane, sin: &mut Lane, cos: &mut Lane) {
    sesc_runtime::trig::sin_cos_block(angle, sin, cos);
}
