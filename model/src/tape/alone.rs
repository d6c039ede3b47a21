//! One posture: number by number, its sines and cosines eight at a time.
//!
//! ```text
//! program ─▶ angles ─▶ sines, cosines ─▶ everything else, in runs of one operation
//! ```
//!
//! A run is a loop over places alone: the processor guesses right what comes next, and has
//! many operations under way that do not wait for each other.

use super::plan::{Instruction, Plan, RegisterFill, Step, angles_first};
use super::{Kernels, SHORT, Values};
use crate::program::Program;

/// Where the operands of an operation stand, and where its result goes.
#[derive(Debug, Clone, Copy)]
struct Places {
    to: u32,
    a: u32,
    b: u32,
}

/// An operation on two numbers, or on the first of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    Neg,
    Clamp,
    Pow,
    /// The cosine goes where `b` says.
    SinCos,
}

/// One operation, many times.
#[derive(Debug, Clone)]
struct Run {
    operation: Operation,
    places: Vec<Places>,
}

/// The steps of a program for one posture.
#[derive(Debug, Clone)]
pub(super) struct Alone {
    /// Angles that no sine is part of.
    angles: Vec<Run>,
    /// Sines and cosines of those.
    sines: Vec<Places>,
    rest: Vec<Run>,
    /// Constants in their places, zero elsewhere.
    initial: Vec<f64>,
    /// The values that each argument has to give, and the places that they go to.
    inputs: Vec<Vec<(u32, u32)>>,
    outputs: Vec<u32>,
}

impl Alone {
    pub fn new(program: &Program, sources: &[RegisterFill]) -> Alone {
        let (order, angles) = angles_first(program);
        let plan = Plan::new(program, &order);
        let sine = |step: &Instruction| matches!(step.step, Step::SinCos(_));
        let sines = plan.steps[angles..].iter().take_while(|step| sine(step));
        let sines = angles + sines.count();
        let mut initial = vec![0.0; plan.registers];
        let mut inputs = vec![Vec::new(); program.inputs.len()];
        for (k, source) in sources.iter().enumerate() {
            match *source {
                RegisterFill::Const(x) => initial[k] = x,
                RegisterFill::Input { array, index } => {
                    inputs[array].push((place(k), place(index)))
                }
            }
        }
        Alone {
            angles: runs(&plan.steps[..angles]),
            sines: plan.steps[angles..sines]
                .iter()
                .map(|step| parts(step).1)
                .collect(),
            rest: runs(&plan.steps[sines..]),
            initial,
            inputs,
            outputs: plan.outputs.iter().map(|k| place(*k)).collect(),
        }
    }

    /// Evaluate into `out`, with the bits of a block.
    pub fn run(&self, arguments: &[Values], out: &mut [f64], kernels: Kernels) {
        let mut values = self.initial.clone();
        for (places, argument) in self.inputs.iter().zip(arguments) {
            let (Values::PerPosture(given) | Values::Shared(given)) = argument;
            for &(to, index) in places {
                values[to as usize] = given[index as usize];
            }
        }
        for run in &self.angles {
            run.on(&mut values, kernels);
        }
        for some in self.sines.chunks(SHORT) {
            sin_cos(some, &mut values, kernels);
        }
        for run in &self.rest {
            run.on(&mut values, kernels);
        }
        for (to, place) in out.iter_mut().zip(&self.outputs) {
            *to = values[*place as usize];
        }
    }
}

/// A place in 32 bits: half the memory of steps that are walked once a call.
fn place(k: usize) -> u32 {
    u32::try_from(k).expect("fewer than 2^32 values")
}

fn parts(step: &Instruction) -> (Operation, Places) {
    let (operation, a, b) = match step.step {
        Step::Add(a, b) => (Operation::Add, a, b),
        Step::Sub(a, b) => (Operation::Sub, a, b),
        Step::Mul(a, b) => (Operation::Mul, a, b),
        Step::Div(a, b) => (Operation::Div, a, b),
        Step::Pow(a, b) => (Operation::Pow, a, b),
        Step::Neg(a) => (Operation::Neg, a, a),
        Step::Clamp(a) => (Operation::Clamp, a, a),
        Step::SinCos(a) => (Operation::SinCos, a, step.also),
    };
    let [to, a, b] = [step.to, a, b].map(place);
    (operation, Places { to, a, b })
}

fn runs(steps: &[Instruction]) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (operation, places) in steps.iter().map(parts) {
        match runs.last_mut() {
            Some(last) if last.operation == operation => last.places.push(places),
            _ => runs.push(Run {
                operation,
                places: vec![places],
            }),
        }
    }
    runs
}

impl Run {
    fn on(&self, values: &mut [f64], kernels: Kernels) {
        match self.operation {
            Operation::Add => self.each(values, |x, y| x + y),
            Operation::Sub => self.each(values, |x, y| x - y),
            Operation::Mul => self.each(values, |x, y| x * y),
            Operation::Div => self.each(values, |x, y| x / y),
            Operation::Neg => self.each(values, |x, _| -x),
            Operation::Clamp => self.each(values, |x, _| x.clamp(-1.0, 1.0)),
            Operation::Pow => self.each(values, |x, y| {
                let mut power = [0.0; SHORT];
                (kernels.power)(&[x; SHORT], &[y; SHORT], &mut power);
                power[0]
            }),
            // Each may be an angle made of the sine before.
            Operation::SinCos => {
                for one in self.places.chunks(1) {
                    sin_cos(one, values, kernels);
                }
            }
        }
    }

    #[inline(always)]
    fn each(&self, values: &mut [f64], f: impl Fn(f64, f64) -> f64) {
        for &Places { to, a, b } in &self.places {
            values[to as usize] = f(values[a as usize], values[b as usize]);
        }
    }
}

/// Sines and cosines of up to [`SHORT`] angles.
fn sin_cos(places: &[Places], values: &mut [f64], kernels: Kernels) {
    let (mut angles, mut sines, mut cosines) = ([0.0; SHORT], [0.0; SHORT], [0.0; SHORT]);
    for (angle, places) in angles.iter_mut().zip(places) {
        *angle = values[places.a as usize];
    }
    (kernels.sin_cos)(&angles, &mut sines, &mut cosines);
    for ((places, sine), cosine) in places.iter().zip(sines).zip(cosines) {
        values[places.to as usize] = sine;
        values[places.b as usize] = cosine;
    }
}
