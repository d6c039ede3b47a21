//! Functions of a model that are ready to be called, each made when it is first asked for.

use std::sync::OnceLock;

use pyo3::prelude::*;
use sesc_identify::evaluate::Evaluator;
use sesc_model::{Function, Given, Model};

/// Functions that Python calls.
const FUNCTIONS: [Function; 11] = [
    Function::Com,
    Function::ComJacobian,
    Function::ComVelocity,
    Function::GravityMoments,
    Function::Cop,
    Function::CopJacobian,
    Function::RegressorCop,
    Function::Regressor,
    Function::RegressorFull,
    Function::Zmp,
    Function::CorrectCop,
];

/// Columns of a reading of the CoP.
pub(crate) const READING: [&str; 2] = ["cop_x", "cop_y"];

/// The functions of one model.
#[derive(Default)]
pub(crate) struct Functions([OnceLock<Prepared>; FUNCTIONS.len()]);

impl Functions {
    /// `function` of `model`, the same in every call.
    pub(crate) fn get(&self, py: Python<'_>, model: &Model, function: Function) -> &Prepared {
        let place = FUNCTIONS.iter().position(|known| *known == function);
        let prepared = &self.0[place.unwrap_or_default()];
        match prepared.get() {
            Some(prepared) => prepared,
            // Most of a millisecond, in which other threads go on.
            None => py.detach(|| prepared.get_or_init(|| Prepared::new(model, function))),
        }
    }
}

/// A function that is ready to be called.
pub(crate) struct Prepared {
    /// None where the model does not have it.
    pub evaluator: Option<Evaluator>,
    /// Shape of the result of one posture.
    pub shape: Vec<usize>,
}

impl Prepared {
    fn new(model: &Model, function: Function) -> Prepared {
        let evaluator = Evaluator::variant(model, function, Given::Positions, model.params());
        let columns = function.columns().on(model);
        let rows = function.rows().into_iter();
        let shape = match &evaluator {
            Some(_) => rows.chain([columns]).collect(),
            None => vec![READING.len()],
        };
        Prepared { evaluator, shape }
    }
}
