//! One function of the generated C: what it is called, takes and computes.

use sesc_model::expr::Argument;
use sesc_model::program::Program;
use sesc_model::{Function, Given};

use super::case::Case;

/// One C function.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub function: Function,
    /// Whether its parameters are constants.
    pub baked: bool,
    /// Behind the prefix.
    pub name: String,
    /// `None`: servo ticks.
    pub given: Option<Given>,
    pub width: usize,
}

impl Entry {
    /// What it computes, from positions where it takes ticks.
    pub(crate) fn program(&self, case: &Case) -> Option<Program> {
        let given = self.given.unwrap_or(Given::Positions);
        let program = match self.baked {
            true => case.model.baked_program(self.function, given),
            false => case.model.program(self.function, given),
        };
        program.filter(|program| !program.shape.is_empty())
    }

    /// What it takes after the posture: joint velocities, base parameters.
    fn takes(&self, argument: Argument) -> bool {
        let arguments = self.function.arguments(Given::Positions);
        let baked = self.baked && argument == Argument::Parameters;
        arguments.contains(&argument) && !baked
    }

    pub(crate) fn takes_velocities(&self) -> bool {
        self.takes(Argument::Velocities)
    }

    pub(crate) fn takes_accelerations(&self) -> bool {
        self.takes(Argument::Accelerations)
    }

    pub(crate) fn takes_parameters(&self) -> bool {
        self.takes(Argument::Parameters)
    }

    /// What a call in C passes before the result, of `ticks`, `q`, `sines`, `cosines`, `qd`
    /// (`slow` beside accelerations `qdd`) and `r`.
    pub(crate) fn arguments(&self) -> String {
        let mut arrays = match self.given {
            None => vec!["ticks"],
            Some(Given::Positions) => vec!["q"],
            Some(_) => vec!["sines", "cosines"],
        };
        match (self.takes_velocities(), self.takes_accelerations()) {
            (true, true) => arrays.extend(["slow", "qdd"]),
            (true, false) => arrays.push("qd"),
            (false, _) => {}
        }
        arrays.extend(self.takes_parameters().then_some("r"));
        arrays.join(", ")
    }
}
