//! The functions of a robot as programs, made once for every language.

use sesc_model::bounds::{self, Bound, Input, Precision};
use sesc_model::expr::{Argument, Expr};
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model};

/// A function of the generated interface.
#[derive(Debug, Clone)]
pub struct Routine {
    /// Which one.
    pub function: Function,
    /// What it computes from.
    pub given: Given,
    /// Whether the parameters of a model file are constants in it.
    pub baked: bool,
    /// Its straight-line code.
    pub program: Program,
    /// What each entry of each input array may be: bounds hold for these.
    pub inputs: Vec<Vec<Input>>,
}

impl Routine {
    /// Proven bound on the rounding error of its results, in their unit.
    pub fn rounding(&self, precision: Precision) -> Bound {
        bounds::prove(&self.program, &self.inputs, precision)
    }
}

/// Whether a program takes what effects depend on beside q and r.
pub(crate) fn takes_context(program: &Program) -> bool {
    let mut inputs = program.inputs.iter();
    inputs.any(|array| array.argument == Argument::Context)
}

/// The first function with a constant that is no number, or larger than `most`: what the
/// scalar of a language holds.
pub(crate) fn beyond<'r>(
    mut routines: impl Iterator<Item = &'r Routine>,
    most: f64,
) -> Option<&'r Routine> {
    let is_beyond = |expr: &Expr| match expr {
        Expr::Const(x) => x.is_nan() || x.abs() > most,
        _ => false,
    };
    routines.find(|routine| {
        routine
            .program
            .nodes
            .iter()
            .any(|node| is_beyond(&node.expr))
    })
}

/// Every variant of `functions` that can be had of `model`, those with constant parameters last.
/// [`Function::CorrectCop`] comes along: without it a fit would take readings for what they are
/// made of.
pub(crate) fn routines(model: &Model, functions: &[Function]) -> Vec<Routine> {
    let routine = |function, given, baked, program: Option<Program>| {
        program.map(|program| Routine {
            function,
            given,
            baked,
            inputs: model.input_ranges(&program),
            program,
        })
    };
    let mut all = Vec::new();
    for given in [Given::Positions, Given::SinesCosines, Given::Direction] {
        for &function in functions.iter().chain([&Function::CorrectCop]) {
            all.extend(routine(
                function,
                given,
                false,
                model.program(function, given),
            ));
        }
    }
    if model.file.is_some() {
        for given in [Given::Positions, Given::SinesCosines] {
            let of_static = [
                Function::Com,
                Function::ComJacobian,
                Function::Cop,
                Function::CopJacobian,
            ];
            for function in of_static
                .into_iter()
                .filter(|function| functions.contains(function))
            {
                let program = model.baked_program(function, given);
                all.extend(routine(function, given, true, program));
            }
        }
    }
    all
}
