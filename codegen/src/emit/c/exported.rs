//! One function of the C interface: a routine and how its arguments come.

use std::ops::Deref;

use super::{Options, Scalar};
use crate::emit::listing::{Line, Listing, Results};
use crate::facts::Facts;
use crate::routines::{Routine, takes_context};
use sesc_model::Given;
use sesc_model::bounds::Formats;
use sesc_model::expr::Argument;
use sesc_model::program::Counts;

/// What a caller passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Input {
    /// The arguments of the program.
    Program,
    /// Servo ticks, turned into what the program takes.
    Ticks,
    /// The arguments of the program for many postures.
    Batch,
}

/// A function to write.
#[derive(Debug, Clone)]
pub(super) struct Exported<'f> {
    pub(super) routine: &'f Routine,
    pub(super) input: Input,
    /// Binary points in fixed point.
    pub(super) formats: Option<Formats>,
    /// Operations of the program and of what turns ticks into its arguments.
    pub(super) counts: Counts,
    /// Sine and cosine pairs that ticks read from the table.
    pub(super) look_ups: usize,
    /// Proven bound on the rounding error, in the unit of its results.
    pub(super) bound: f64,
    /// The largest error on random postures, where that bound is of no use.
    pub(super) seen: Option<f64>,
}

/// What a call, saved registers and helpers take of the stack, bytes.
const CALL: usize = 256;

impl Deref for Exported<'_> {
    type Target = Routine;

    fn deref(&self) -> &Routine {
        self.routine
    }
}

impl Exported<'_> {
    /// Its name after the prefix.
    pub(super) fn name(&self) -> String {
        let suffix = match (self.input, self.given) {
            (Input::Ticks, _) => "_ticks",
            (Input::Batch, _) => "_batch",
            (_, Given::SinesCosines) => "_sc",
            (_, Given::Direction) => "_along",
            (_, Given::Positions) => "",
        };
        let model = if self.baked { "model_" } else { "" };
        format!("{model}{}{suffix}", self.function.name())
    }

    /// Bytes of the stack that it and all that it calls take at most: every value with a name,
    /// in fixed point a product of 64 bits for each, in a block of postures a register.
    pub(super) fn stack(&self, facts: &Facts, options: &Options) -> usize {
        let real = match options.scalar {
            Scalar::F32 => 4,
            Scalar::F64 | Scalar::Fixed32 => 8,
        };
        let lines = Listing::new(&self.program, Results::AtTheEnd).lines;
        let values = lines.iter().map(|line| match line {
            Line::SinCos { .. } => 2,
            Line::Let(_) => 1,
            Line::Title(_) | Line::Result(_) => 0,
        });
        let lanes = options.lanes.filter(|_| self.is_batch()).unwrap_or(1);
        let body = real * lanes as usize * values.sum::<usize>() + CALL * lanes as usize;
        match self.input {
            Input::Ticks => body + CALL + 2 * real * facts.dof(),
            Input::Program | Input::Batch => body,
        }
    }

    pub(super) fn is_of_ticks(&self) -> bool {
        self.input == Input::Ticks
    }

    pub(super) fn is_batch(&self) -> bool {
        self.input == Input::Batch
    }

    pub(super) fn takes_parameters(&self) -> bool {
        self.function.takes_parameters() && !self.baked
    }

    /// What a caller passes of one posture, in order; joint angles also where they come as
    /// ticks.
    pub(super) fn arguments(&self) -> Vec<Argument> {
        let mut arguments = self.function.arguments(self.given);
        arguments.retain(|argument| *argument != Argument::Parameters || !self.baked);
        arguments.extend(takes_context(&self.program).then_some(Argument::Context));
        arguments
    }

    /// Name of its result array.
    pub(super) fn output(&self) -> &'static str {
        self.function.interface().result
    }
}

/// Fraction bits of an input array in fixed point; 0 in floats and where nothing takes it.
pub(super) fn array_bits(routines: &[Exported], argument: Argument) -> i32 {
    let find = |routine: &Exported| {
        let mut inputs = routine.program.inputs.iter();
        let k = inputs.position(|array| array.argument == argument)?;
        Some(routine.formats.as_ref()?.arrays[k])
    };
    routines.iter().find_map(find).unwrap_or(0)
}
